"""Friction models compared: on tribometer tests, on press curves, in one system."""
