"""Forming processes, run as a whole, step by step or in batches.

When a run is remeshed, `forming/fe/simulation.py` decides.
"""
