"""The forming processes, and how they run: single, in steps, in batches."""
