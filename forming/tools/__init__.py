"""Forming tools: shapes of dies and punches, their elasticity, and the tools that eject a product."""
