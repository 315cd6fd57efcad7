"""Files of the study ``lag``."""

from __future__ import annotations

from pathlib import Path

from friction_models.common import write_json, write_text
from friction_models.common.json_values import plain

from ..tables import write_nested
from .result import LagNumbers


def write_results(folder: Path, numbers: LagNumbers, page: str) -> None:
    """Write ``lag.json``, ``lag.csv`` and ``report.html``."""
    write_json(folder / "lag.json", plain(numbers))
    write_nested(folder / "lag.csv", numbers["rows"], numbers["synthetic"])
    write_text(folder / "report.html", page)
