"""The whole loop on built-in synthetic data: from raw records to a better friction model in co-simulation."""

from .loop import Demo, DemoResult
from .scenario import Level, Scenario
from .summary_text import printed_summary

__all__ = ["Demo", "DemoResult", "Level", "Scenario", "printed_summary"]
