"""Upsetting in the virtual laboratory: its own material rings, contact edge and pressure on a run of the solver."""
