"""Comparison of friction models: on tribometer tests, on press curves, in one system."""
