"""Files of the learning-curve study."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from friction_models.common import atomic_path, write_json, write_text

from .result import LearningCurves


def write_results(folder: Path, curves: LearningCurves, page: str) -> None:
    """Write ``learning-curve.json``, ``repeats.csv``, ``curves.csv``, ``needed.csv`` and ``report.html``."""
    content = curves.to_dict()
    write_json(folder / "learning-curve.json", content)
    _write_csv(folder / "repeats.csv", _repeats(curves), curves.synthetic)
    _write_csv(folder / "curves.csv", _points(content["curves"]), curves.synthetic)
    _write_csv(folder / "needed.csv", _needed(content), curves.synthetic)
    write_text(folder / "report.html", page)


def _repeats(curves: LearningCurves) -> Iterable[dict[str, Any]]:
    for c in curves.curves:
        for column, size in enumerate(c.sizes):
            for repeat, (error, average) in enumerate(
                zip(c.errors[:, column], c.averages[:, column].mean(axis=1)), 1
            ):
                yield {
                    "lubricant": c.lubricant,
                    "collection": c.collection,
                    "model": c.model,
                    "tests": size,
                    "repeat": repeat,
                    "mae": float(error),
                    "mae_averages": float(average),
                }


def _points(curves: Iterable[Mapping[str, Any]]) -> Iterable[dict[str, Any]]:
    names = ("mae_percentile", "mae_median", "mae_averages_percentile")
    for c in curves:
        for k, size in enumerate(c["tests"]):
            head = {name: c[name] for name in ("lubricant", "collection", "model")}
            chosen = " ".join(f"{key}={value}" for key, value in c["parameters"][k].items())
            numbers = {name: c[name][k] for name in names}
            yield {**head, "tests": size, "points": c["points"][k], **numbers, "parameters": chosen}


def _needed(content: Mapping[str, Any]) -> Iterable[dict[str, Any]]:
    for c in (*content["comparisons"], *content["comparisons_apart"], *content["comparisons_near_lowest"]):
        row = {name: c[name] for name in ("lubricant", "model", "accuracy")}
        for collection in ("time_series", "average", "average_judged_by_averages"):
            names = ("tests", "at_most", "lower", "upper", "reached")
            row |= {f"{collection}_{name}": c[collection][name] for name in names}
        yield {**row, **{name: c[name] for name in ("share_fewer", "share_more", "verdict")}}


def _write_csv(target: Path, rows: Iterable[Mapping[str, Any]], synthetic: bool) -> None:
    table = [{**row, "synthetic": synthetic} for row in rows]
    with atomic_path(target) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(table[0]) if table else ["synthetic"], lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
