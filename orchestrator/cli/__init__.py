"""The command line `tribofmu`."""

from .main import main

__all__ = ["main"]
