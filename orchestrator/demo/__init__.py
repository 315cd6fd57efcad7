"""The whole loop on built-in synthetic data: from raw records to a better friction model in co-simulation."""

from .loop import Demo, DemoResult
from .printed import printed_summary
from .scenario import Level, Scenario

__all__ = ["Demo", "DemoResult", "Level", "Scenario", "printed_summary"]
