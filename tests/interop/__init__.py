"""Friction FMUs in the simulators of others; ``python -m tests.interop`` writes what came out as a table."""
