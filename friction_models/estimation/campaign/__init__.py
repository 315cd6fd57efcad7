"""Tests as units: measured points in bins, metadata, curves along loads."""
