"""Files and the table of the forming-error study."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from friction_models.common import atomic_path, write_json, write_text

from ...force_curves.metrics import LevelSummary
from .result import FormingErrors

#: Processes as readers know them.
PROCESS_TITLES = {"fre": "forward rod extrusion", "bce": "backward cup extrusion"}


def write_results(folder: Path, errors: FormingErrors, page: str) -> None:
    """Write ``forming-error.json``, ``runs.csv``, ``summary.csv``, ``changes.csv`` and ``report.html``."""
    content = errors.to_dict()
    write_json(folder / "forming-error.json", content)
    for name, rows in (("runs", "runs"), ("summary", "summaries"), ("changes", "changes")):
        _write_csv(folder / f"{name}.csv", content[rows], errors.synthetic)
    write_text(folder / "report.html", page)


def _write_csv(target: Path, rows: Sequence[Mapping[str, Any]], synthetic: bool) -> None:
    with atomic_path(target) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        names = [*(rows[0] if rows else ()), "synthetic"]
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows({**row, "synthetic": synthetic} for row in rows)


def table(errors: FormingErrors) -> str:
    """Return the summary as text: a block for each process and lubricant, and one over all."""
    lines = ["synthetic measurements"] if errors.synthetic else []
    width = max(len(f.label) for f in errors.frictions) + 2
    group: tuple[str, str] | None = None
    for s in errors.summaries():
        this = (s.lubricant or "all lubricants", PROCESS_TITLES.get(s.process or "", "all processes"))
        if this != group:
            group = this
            head = f"{this[1]}, {this[0]} ({s.levels})"
            lines += [
                "",
                head,
                f"{'':{width}}{'MARE max force':>18}{'std over levels':>18}{'MARE work':>18}{'tau/k':>8}{'friction time':>15}",
            ]
        cells = [
            percent(s.max_force.mare, s.max_force.mare_std),
            spread(s.max_force),
            percent(s.work.mare, s.work.mare_std),
        ]
        lines.append(
            f"{s.friction:{width}}"
            + "".join(f"{c:>18}" for c in cells)
            + f"{s.tau_over_k:8.2f}{100 * s.friction_share:13.2f} %"
        )
    if errors.missing:
        lines += [
            "",
            f"{errors.missing} runs are missing, see failed.json; errors are over levels that all laws have",
        ]
    return "\n".join(lines)


def spread(summary: LevelSummary) -> str:
    """Return the standard deviation over levels in percent; a single level has none."""
    return percent(summary.spread, summary.spread_std) if summary.levels > 1 else "-"


def percent(value: float, std: float) -> str:
    """Return a share and its uncertainty in percent."""
    return f"{100 * value:.1f} +- {100 * std:.1f} %"
