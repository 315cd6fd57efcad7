"""Diagnoses of campaigns of the prior, the weights of the confidence fitted to them, and how reliable it is."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.linear_model import LogisticRegression

from friction_models.common import write_json
from friction_models.discovery import diagnose
from friction_models.discovery.judge.confidence import WEIGHTS, confidence

from ..common import Section, Table, section
from ..data import sources
from ..literature.calibration import reliability
from .campaigns import campaign

#: Campaigns below are fitted to, those from here on judge.
JUDGED_FROM = 600_000
#: Scatter of a hidden part over that of the noise below which it need not be named.
VISIBLE = 0.3
#: Ridge penalty of the regression, with grounds that are about one wide.
PENALTY = 1.0


def right(row: dict[str, Any]) -> bool:
    """Return whether an answer is right: it names what is hidden and nothing else, or abstains where no effect describes it.

    A part that is too small to be seen may be named, but need not.
    """
    verdict, names = row["verdict"], set(row["effects"])
    every = [set(n) for n in row["hidden"]]
    seen = [n for n, strength in zip(every, row["strengths"], strict=True) if strength >= VISIBLE]
    if verdict == "nothing_missing":
        return not seen
    if row["kind"] == "outside":
        return bool(verdict == "unknown_structure")
    if verdict == "ambiguous":
        return bool(every) and all((names | set(row["confusion_set"])) & n for n in seen)
    if verdict not in {"explained", "data_problem", "partly_explained"} or not names:
        return False
    only = names <= set().union(*every)
    return only and (verdict == "partly_explained" or all(names & n for n in seen))


def answer(seed: int) -> dict[str, Any]:
    """Diagnose one campaign."""
    made = campaign(seed)
    said = diagnose(made.points, made.tests)
    return {
        "seed": seed,
        "kind": made.kind,
        "laws": [law.key for law in made.laws],
        "hidden": [sorted(law.names) for law in made.laws],
        "strengths": made.strengths,
        "verdict": said.verdict,
        "effects": said.effects,
        "confusion_set": said.confusion_set,
        "confidence": said.confidence,
        "grounds": said.grounds,
    }


def answers(folder: Path, seeds: Sequence[int]) -> list[dict[str, Any]]:
    """Return the answers of campaigns; those that the same code gave before and that are kept in `folder` are read."""
    kept = folder / "prior" / sources("friction_models")
    kept.mkdir(parents=True, exist_ok=True)
    rows = []
    for seed in seeds:
        path = kept / f"{seed}.json"
        if not path.exists():
            write_json(path, answer(seed))
        rows.append(json.loads(path.read_text(encoding="utf-8")))
    return rows


def kind_of(verdict: str) -> str:
    """Return the entry of `WEIGHTS` that a verdict has."""
    return verdict if verdict in WEIGHTS else "named"


def fitted(rows: Sequence[dict[str, Any]]) -> dict[str, tuple[float, dict[str, float]]]:
    """Return weights like `WEIGHTS`, fitted to the answers."""
    found = {}
    for kind, (_, weights) in WEIGHTS.items():
        own = [r for r in rows if kind_of(r["verdict"]) == kind and r["verdict"] != "out_of_domain"]
        x = np.array([[r["grounds"][name] for name in weights] for r in own])
        model = LogisticRegression(C=1.0 / PENALTY, max_iter=1000).fit(x, [right(r) for r in own])
        found[kind] = (
            round(float(model.intercept_[0]), 2),
            {name: round(float(w), 2) for name, w in zip(weights, model.coef_[0], strict=True)},
        )
    return found


def reliability_table(rows: Sequence[dict[str, Any]]) -> tuple[float, Table]:
    """Return the expected calibration error and the reliability diagram as a table."""
    said = [confidence(r["verdict"], r["grounds"]) for r in rows]
    error, bins = reliability(said, [right(r) for r in rows], 5)
    table = Table(["confidence", "answers", "mean confidence", "right"])
    for b in bins:
        if b.n:
            table.rows.append([f"{b.low:.1f} to {b.high:.1f}", b.n, f"{b.said:.2f}", f"{b.was:.2f}"])
    return error, table


def measure(folder: Path, campaigns: int = 200) -> Section:
    """Return the section on the confidence: campaigns of the prior that the weights were not fitted to."""
    rows = answers(folder, range(JUDGED_FROM, JUDGED_FROM + campaigns))
    error, table = reliability_table(rows)
    sure = [right(r) for r in rows if confidence(r["verdict"], r["grounds"]) >= 0.9]
    text = (
        f"{len(rows)} campaigns of a broad prior (random monotone laws, pairs, laws outside the catalogue, nothing hidden; random "
        "plans, noises and strengths; synthetic), other ones than those that the confidence was fitted to. Expected calibration "
        f"error {error:.3f}. Of the {len(sure)} answers at 0.9 and above {sum(sure)} are right. "
        f"All answers: {np.mean([right(r) for r in rows]):.2f} right."
    )
    return section("Confidence of the diagnosis", text, table)
