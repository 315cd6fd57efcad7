"""Files of the learning-curve study."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import write_json, write_text
from friction_models.training import percentile_curve
from friction_models.training.learning_curve import PROBABILITY

from ...jobs.graph import JobResult
from ..saved import SavedStudy
from ..tables import write_rows
from .result import Comparison, Curve, LearningCurves
from .study import LearningCurvePlan, LearningCurveStudy
from .words import findings

#: Columns of `NeededTests` in ``needed.csv``.
_NEEDED = ("tests", "at_most", "lower", "upper", "reached")


def write_results(folder: Path, curves: LearningCurves, page: str) -> None:
    """Write ``learning-curve.json``, ``repeats.csv``, ``curves.csv``, ``needed.csv`` and ``report.html``."""
    write_json(folder / "learning-curve.json", numbers(curves))
    write_rows(folder / "repeats.csv", _repeats(curves), curves.synthetic)
    write_rows(folder / "curves.csv", _points(curves), curves.synthetic)
    write_rows(folder / "needed.csv", _needed(curves), curves.synthetic)
    write_text(folder / "report.html", page)


def read_study(saved: SavedStudy) -> tuple[LearningCurveStudy, dict[str, JobResult]]:
    """Return the study in a folder and its results."""
    given: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in saved.settings.items()}
    del given["study"]
    plan = LearningCurvePlan(**given)
    results = saved.results(saved.names, "facts-", "data-", *(f"{x}-" for x in plan.lubricants))
    counts = {
        n: int(results[f"facts-{n}"].values["train"] if f"facts-{n}" in results else plan.sizes[-1])
        for n in plan.lubricants
    }
    virtual = any(name.startswith("specimens-") for name in saved.names)
    return LearningCurveStudy.of_counts(plan, counts, virtual), results


def numbers(curves: LearningCurves) -> dict[str, object]:
    """Return all numbers of the study as plain data."""
    return {
        "study": "learning-curve",
        "synthetic": curves.synthetic,
        "accuracy": curves.accuracy,
        "probability": PROBABILITY,
        "repeats": curves.repeats,
        "judge": "MAE over all points of the held-out time series, loads clamped to the trained domain",
        "missing_jobs": curves.missing,
        "findings": findings(curves),
        "data": {k: dict(v) for k, v in curves.facts.items()},
        "curves": [_curve(c, curves.accuracy) for c in curves.curves],
        "comparisons": [_comparison(c) for c in curves.comparisons],
        "comparisons_apart": [_comparison(c) for c in curves.apart],
        "comparisons_near_lowest": [_comparison(c) for c in curves.strict],
    }


def _curve(c: Curve, accuracy: float) -> dict[str, object]:
    low, lower, upper = c.lowest
    return {
        **c.head,
        "tests": list(c.sizes),
        "points": list(c.points),
        "mae": c.errors.T.tolist(),
        "mae_percentile": c.percentile.tolist(),
        "mae_median": np.median(c.errors, axis=0).tolist(),
        "mae_averages_percentile": percentile_curve(c.averages).tolist(),
        "parameters": list(c.parameters),
        "needed": c.needed(accuracy).to_dict(),
        "lowest": {"mae": low, "lower": lower, "upper": upper},
        "converged": c.converged.to_dict(),
    }


def _comparison(c: Comparison) -> dict[str, object]:
    return {
        "lubricant": c.lubricant,
        "model": c.model,
        "accuracy": c.accuracy,
        "time_series": c.series.to_dict(),
        "average": c.average.to_dict(),
        "average_judged_by_averages": c.own.to_dict(),
        "share_fewer": c.fewer,
        "share_more": c.more,
        "verdict": c.verdict,
    }


def _repeats(curves: LearningCurves) -> Iterable[dict[str, object]]:
    for c in curves.curves:
        for column, size in enumerate(c.sizes):
            for repeat, (error, average) in enumerate(
                zip(c.errors[:, column], c.averages[:, column].mean(axis=1)), 1
            ):
                made = {"mae": float(error), "mae_averages": float(average)}
                yield {**c.head, "tests": size, "repeat": repeat, **made}


def _points(curves: LearningCurves) -> Iterable[dict[str, object]]:
    for c in curves.curves:
        averages, median = percentile_curve(c.averages), np.median(c.errors, axis=0)
        for k, size in enumerate(c.sizes):
            yield {
                **c.head,
                "tests": size,
                "points": c.points[k],
                "mae_percentile": float(c.percentile[k]),
                "mae_median": float(median[k]),
                "mae_averages_percentile": float(averages[k]),
                "parameters": " ".join(f"{key}={value}" for key, value in c.parameters[k].items()),
            }


def _needed(curves: LearningCurves) -> Iterable[dict[str, object]]:
    for c in (*curves.comparisons, *curves.apart, *curves.strict):
        row: dict[str, object] = {}
        for key, value in _comparison(c).items():
            row |= {f"{key}_{n}": value[n] for n in _NEEDED} if isinstance(value, dict) else {key: value}
        yield row
