"""Compression tests that were not run, predicted in a closed loop."""
