"""Files of the forming-error study."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from friction_models.common import write_json, write_text

from ...comparison.level_runs import FormingLevel
from ...jobs.graph import JobResult
from ..press_levels import StudyLevel
from ..saved import SavedStudy
from ..tables import write_rows
from .result import FormingErrors
from .study import FormingErrorStudy, Plan

_LEVEL = re.compile(r"(fre|bce)_([0-9.e+-]+)mms_([0-9.e+-]+)C")


def write_results(folder: Path, errors: FormingErrors, page: str) -> None:
    """Write ``forming-error.json``, ``runs.csv``, ``summary.csv``, ``changes.csv`` and ``report.html``."""
    write_json(folder / "forming-error.json", errors.to_dict())
    for name, rows in (("runs", errors.runs), ("summary", errors.summaries()), ("changes", errors.changes())):
        write_rows(folder / f"{name}.csv", (row.to_dict() for row in rows), errors.synthetic)
    write_text(folder / "report.html", page)


def read_study(saved: SavedStudy) -> tuple[FormingErrorStudy, dict[str, JobResult]]:
    """Return the study in a folder and its results."""
    settings = saved.settings
    virtual = "tests" in settings  # what only the virtual laboratory has
    results = saved.results(saved.manifest["jobs"], "run-", "press-", "model-", "data-")
    levels = []
    for found in settings["levels"]:
        named = _LEVEL.fullmatch(str(found["level"]))
        if named is None:
            raise ValueError(f"level {found['level']!r:.60}")
        level = FormingLevel(named[1], float(named[3]), float(named[2]), float(found["stroke_mm"]))
        item = StudyLevel(str(found["lubricant"]), level, synthetic=virtual)
        if item.job in results:
            item = replace(item, synthetic=virtual or bool(results[item.job].values["synthetic"]))
        levels.append(item)
    plan = Plan(
        models=tuple(map(str, settings["models"])),
        constants=tuple(map(float, settings["constants"])),
        conditions=tuple(dict.fromkeys((item.level.T_tool, item.level.speed) for item in levels)),
        lubricants=tuple(map(str, settings["lubricants"])),
        seed=int(settings["seed"]),
    )
    if virtual:
        plan = replace(plan, tests=str(settings["tests"]), repeats=int(settings["repeats"]))
    return FormingErrorStudy(plan, (), virtual, tuple(levels)), results
