"""The page of a study whose results are kept in a folder, made again without computing anything."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from fmus.runtime.errors import of_this_version
from friction_models.common import InputError, unknown_name

from ..jobs.store import JobResult, Store, read_object

#: File of each study that holds all its numbers.
NUMBERS = {name: f"{name}.json" for name in ("learning-curve", "forming-error", "lag", "extrapolation")}
#: Larger files are not read: the numbers of the full size take less than 20 MB.
MAX_BYTES = 200_000_000
_LEVEL = re.compile(r"(fre|bce)_([0-9.e+-]+)mms_([0-9.e+-]+)C")
_KEY = re.compile(r"[0-9a-f]{40}")


def study_page(folder: Path) -> str | None:
    """Return the HTML of the study in a folder; None where ``manifest.json`` is not that of a study.

    Results are those that the manifest names, whatever sources they were computed with.

    Raises
    ------
    InputError
        An unknown study, files that are missing, too large, damaged or of another version.
    """
    manifest = read_object(folder / "manifest.json", MAX_BYTES)
    settings = manifest.get("settings")
    if not isinstance(settings, dict) or "study" not in settings:
        return None
    name = str(settings["study"])
    if name not in NUMBERS:
        raise unknown_name("study", name, NUMBERS, str(folder / "manifest.json"))
    helps = f"what `tribofmu study {name}` wrote; the same command computes only what is missing"
    with of_this_version(folder, helps):
        return _PAGES[name](folder, manifest)


def _lag(folder: Path, manifest: Mapping[str, Any]) -> str:
    from ..studies.lag.result import LagNumbers
    from .lag_page import lag_page

    return lag_page(cast(LagNumbers, read_object(folder / NUMBERS["lag"], MAX_BYTES)))


def _extrapolation(folder: Path, manifest: Mapping[str, Any]) -> str:
    from ..studies.extrapolation.result import ExtrapolationNumbers
    from .extrapolation_page import extrapolation_page

    return extrapolation_page(
        cast(ExtrapolationNumbers, read_object(folder / NUMBERS["extrapolation"], MAX_BYTES))
    )


def _learning_curve(folder: Path, manifest: Mapping[str, Any]) -> str:
    from ..studies.learning_curve.result import LearningCurves
    from ..studies.learning_curve.study import LearningCurvePlan, LearningCurveStudy
    from .learning_curve_page import learning_curve_page

    settings, names = manifest["settings"], [*manifest["jobs"], *manifest["failed"]]
    given: dict[str, Any] = {
        k: tuple(v) if isinstance(v, list) else v for k, v in settings.items() if k != "study"
    }
    plan = LearningCurvePlan(**given)
    results = _results(
        folder, manifest, _starting(names, "facts-", "data-", *(f"{x}-" for x in plan.lubricants))
    )
    count = {n: results[f"facts-{n}"].values["train"] for n in plan.lubricants if f"facts-{n}" in results}
    virtual = any(str(name).startswith("specimens-") for name in names)
    study = LearningCurveStudy.of_counts(
        plan, {n: int(count.get(n, plan.sizes[-1])) for n in plan.lubricants}, virtual
    )
    return learning_curve_page(study, LearningCurves.of(study, results), manifest, results)


def _forming_error(folder: Path, manifest: Mapping[str, Any]) -> str:
    from ..comparison.level_runs import Level
    from ..studies.forming_error.result import FormingErrors
    from ..studies.forming_error.study import FormingErrorStudy, Plan
    from ..studies.press_levels import StudyLevel, press_name
    from .forming_error_page import forming_error_page

    settings = manifest["settings"]
    virtual = "tests" in settings  # what only the virtual laboratory has
    results = _results(folder, manifest, _starting(manifest["jobs"], "run-", "press-", "model-", "data-"))
    levels = []
    for found in settings["levels"]:
        named = _LEVEL.fullmatch(str(found["level"]))
        if named is None:
            raise ValueError(f"level {found['level']!r:.60}")
        level = Level(named[1], float(named[3]), float(named[2]), float(found["stroke_mm"]))
        job = press_name(str(found["lubricant"]), level)
        synthetic = virtual or (job in results and bool(results[job].values["synthetic"]))
        levels.append(StudyLevel(str(found["lubricant"]), level, job, synthetic=synthetic))
    plan = Plan(
        models=tuple(map(str, settings["models"])),
        constants=tuple(map(float, settings["constants"])),
        conditions=tuple(dict.fromkeys((item.level.T_tool, item.level.speed) for item in levels)),
        lubricants=tuple(map(str, settings["lubricants"])),
        seed=int(settings["seed"]),
    )
    if virtual:
        plan = replace(plan, tests=str(settings["tests"]), repeats=int(settings["repeats"]))
    study = FormingErrorStudy.of_levels(plan, levels, virtual)
    return forming_error_page(study, FormingErrors.of(study, results), manifest, results)


def _starting(names: Iterable[str], *heads: str) -> list[str]:
    return [str(name) for name in names if str(name).startswith(heads)]


def _results(folder: Path, manifest: Mapping[str, Any], names: Iterable[str]) -> dict[str, JobResult]:
    """Return the results of jobs that are there; a key is a name in ``jobs``, never a path out of it."""
    store, found = Store(folder / "jobs"), {}
    for name in names:
        key = str(manifest["jobs"].get(name, {}).get("job", ""))
        result = store.load(key, name) if _KEY.fullmatch(key) else None
        if result is not None:
            found[name] = result
    if not found:
        raise InputError(
            f"{folder / 'jobs'}: holds none of the results; allowed: the folder of the study as a whole"
        )
    return found


_PAGES: dict[str, Callable[[Path, Mapping[str, Any]], str]] = {
    "learning-curve": _learning_curve,
    "forming-error": _forming_error,
    "lag": _lag,
    "extrapolation": _extrapolation,
}
