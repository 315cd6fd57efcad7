"""Comparison with CalculiX; where it is not installed, numbers of an earlier run take its place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from .calculix import CalculixError, Compression, compress
from .case import Row

#: The earlier run: its numbers are kept for machines without CalculiX.
KEPT_VERSION, KEPT_DAY = "2.20", "2026-11-21"


@dataclass(frozen=True)
class CalculixNumbers:
    """Numbers to compare with; `reason` says why CalculiX was not run, or is empty."""

    values: Mapping[str, float]
    source: str
    reason: str = ""

    def row(
        self, quantity: str, unit: str, key: str, ours: float, tolerance: float, absolute: bool = False
    ) -> Row:
        """Return the row that compares `ours` with one of the numbers."""
        row = Row(quantity, unit, self.values[key], self.source, ours, tolerance, absolute)
        return replace(row, standing="skipped", note=self.reason) if self.reason else row


def bore_key(reduction: int) -> str:
    """Return the name of the decrease of the bore [%] at a reduction of the height [%]."""
    return f"bore_decrease_{reduction}"


def calculix_numbers(setup: Compression, kept: Mapping[str, float]) -> CalculixNumbers:
    """Run CalculiX; where it is missing, return the kept numbers and the reason."""
    try:
        result = compress(setup)
    except CalculixError as error:
        source = f"CalculiX {KEPT_VERSION} CAX8R, value kept from {KEPT_DAY}"
        return CalculixNumbers(kept, source, str(error))
    values = {"force": result.force, "bore_middle": result.bore_middle}
    if setup.inner:
        values |= {
            bore_key(r): 100.0 * (1.0 - result.bore_at(0.01 * r) / setup.inner)
            for r in range(10, round(100.0 * setup.reduction) + 1, 10)
        }
    return CalculixNumbers(values, f"CalculiX {result.version} CAX8R, run beside")
