"""Forming processes, run as a whole, step by step or in batches."""
