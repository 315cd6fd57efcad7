"""How much of the avoidable error empirical terms remove where a law outside the catalogue is hidden. Nothing here is measured."""

from __future__ import annotations

from pathlib import Path

from ..common import Section
from .study import run_all, summary


def measure(folder: Path) -> Section:
    """Run what is missing; return the section of the page."""
    return summary(run_all(folder / "formulas"))
