"""Files of the forming-error study."""

from __future__ import annotations

from pathlib import Path

from friction_models.common import write_json, write_text

from ..tables import write_rows
from .result import FormingErrors


def write_results(folder: Path, errors: FormingErrors, page: str) -> None:
    """Write ``forming-error.json``, ``runs.csv``, ``summary.csv``, ``changes.csv`` and ``report.html``."""
    write_json(folder / "forming-error.json", errors.to_dict())
    for name, rows in (("runs", errors.runs), ("summary", errors.summaries()), ("changes", errors.changes())):
        write_rows(folder / f"{name}.csv", (row.to_dict() for row in rows), errors.synthetic)
    write_text(folder / "report.html", page)
