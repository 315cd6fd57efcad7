"""Files of the study ``extrapolation``."""

from __future__ import annotations

from pathlib import Path

from friction_models.common import write_json, write_text
from friction_models.common.json_values import plain

from ..tables import write_nested
from .result import ExtrapolationNumbers, ExtrapolationRun


def write_results(folder: Path, numbers: ExtrapolationNumbers, page: str) -> None:
    """Write ``extrapolation.json``, ``extrapolation.csv`` and ``report.html``."""
    write_json(folder / "extrapolation.json", plain(numbers))
    write_nested(folder / "extrapolation.csv", map(_row, numbers["runs"]), numbers["synthetic"])
    write_text(folder / "report.html", page)


def _row(run: ExtrapolationRun) -> dict[str, object]:
    """Return a run with its share beyond the trained range of each load as columns."""
    row: dict[str, object] = {name: value for name, value in run.items() if name != "loads"}
    for item in run.get("loads", []):
        row[f"{item['load']}_below"] = item["below"]["share"]
        row[f"{item['load']}_above"] = item["above"]["share"]
    return row
