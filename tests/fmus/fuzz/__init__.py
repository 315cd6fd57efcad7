"""Fuzzers of the friction FMUs' C interface; for longer runs: ``python -m tests.fmus.fuzz --seconds 600``."""
