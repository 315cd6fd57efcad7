"""The same question through the whole chain: raw records of the virtual laboratory, twin, diagnosis, refinement.

Effects are hidden by the laboratory in forms of its own; the sensors' noise reaches mu and the pressure together, and
the twin heats with the measured friction.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypedDict

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from friction_models import make_model
from friction_models.common import write_json
from friction_models.discovery import diagnose, refine
from friction_models.loads import DataSet
from sct_twin.virtual_lab import load_truth

from ..common import Section, Table, section
from ..data import PLAN, campaign, raw_folder, sources
from .study import wilson

HIDDEN = ("stribeck", "thermal_softening", "work_exhaustion", "running_in")
#: Nothing is hidden in so many campaigns for each of the effects.
NULLS = 1
FIRST_SEED, FIRST_NULL = 1, 101


class Outcome(TypedDict):
    """What became of a campaign, as its file keeps it; held-out errors before and after the addition [mu]."""

    hidden: str
    seed: int
    verdict: str
    effects: list[str]
    confusion_set: list[str]
    before: float
    after: float


def one(folder: Path, hidden: str | None, seed: int) -> Outcome:
    """Diagnose and refine one campaign on its training tests, judge on the others."""
    data = campaign(folder, hidden, seed)
    train, held_out = data.select("train"), data.select("test")
    law = _law(raw_folder(folder, hidden, seed), held_out)
    found = diagnose(train.points, train.tests, model="linear", seed=seed)
    base = make_model("linear").fit_frame(train.points, train.tests)
    before = after = _rms(base.predict_frame(held_out.points, held_out.tests) - law)
    if found.effects:
        better = refine(train.points, train.tests, model="linear", add=found.effects, force=True)
        after = _rms(better.predict_frame(held_out.points, held_out.tests) - law)
    return {
        "hidden": hidden or "nothing",
        "seed": seed,
        "verdict": found.verdict,
        "effects": found.effects,
        "confusion_set": found.confusion_set,
        "before": before,
        "after": after,
    }


def run_all(folder: Path, seeds: int, tell: Callable[[str], None] = print) -> list[Outcome]:
    """Run what is not in `folder` yet; return all results."""
    place = folder / "chain" / sources("friction_models", "sct_twin", "forming")
    cases: list[tuple[str | None, int]] = []
    for k in range(seeds):
        cases += [(hidden, FIRST_SEED + k) for hidden in HIDDEN]
        cases += [(None, FIRST_NULL + k * NULLS * len(HIDDEN) + n) for n in range(NULLS * len(HIDDEN))]
    found: list[Outcome] = []
    for hidden, seed in cases:
        kept = place / f"{hidden or 'null'}-{seed}.json"
        if not kept.is_file():
            write_json(kept, one(folder, hidden, seed))
            tell(f"chain {kept.stem}")
        found.append(json.loads(kept.read_text(encoding="utf-8")))
    return found


def summary(results: Sequence[Outcome]) -> Section:
    """Return the tables: rates, and every campaign."""
    hidden = [r for r in results if r["hidden"] != "nothing"]
    null = [r for r in results if r["hidden"] == "nothing"]
    rates = Table(["what", "reached", "95 % interval"])
    for what, answers in (
        ("hidden effect named first", [r["effects"][:1] == [r["hidden"]] for r in hidden]),
        ("hidden effect in the confusion set", [r["hidden"] in r["confusion_set"] for r in hidden]),
        ("at least half of the avoidable error removed", [r["after"] < 0.5 * r["before"] for r in hidden]),
        ("false alarms, nothing missing", [r["verdict"] != "nothing_missing" for r in null]),
    ):
        low, high = wilson(sum(answers), len(answers))
        reached = f"{sum(answers)} of {len(answers)}"
        rates.rows.append((what, reached, f"{100 * low:.0f} to {100 * high:.0f} %"))
    each = Table(["hidden", "seed", "verdict", "confusion set", "held-out RMS before", "after"])
    for r in results:
        names = ", ".join(r["confusion_set"])
        each.rows.append(
            (r["hidden"], r["seed"], r["verdict"], names, f"{r['before']:.5f}", f"{r['after']:.5f}")
        )
    return section(
        "Finding hidden effects through raw records and the twin",
        f"Virtual campaigns of the plan {PLAN}: raw records, twin, diagnosis on the training tests; synthetic. The RMS is the difference to the "
        "law that the laboratory keeps, without specimen scatter, drift and sensor noise.",
        rates,
        each,
    )


def _law(raw: Path, data: DataSet) -> np.ndarray:
    """Return the friction that the laboratory's law gives at each point, without scatter, drift and noise."""
    _, truth = load_truth(raw)
    points: pd.DataFrame = data.points
    values = np.empty(len(points))
    for test_id, rows in points.groupby("test_id").indices.items():
        true = truth[str(test_id)]
        values[rows] = np.interp(points["sd"].to_numpy()[rows], true["sd"], true["mu_law"])
    return values


def _rms(error: ArrayLike) -> float:
    return float(np.sqrt(np.mean(np.square(error))))
