"""Readers of measurement files: each returns a table of channels with their units."""

from .csv import RawTable, read_csv

__all__ = ["RawTable", "read_csv"]
