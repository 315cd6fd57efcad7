"""How often the hidden effect is found, and how often an effect is seen where there is none.

Every campaign goes through the whole chain: raw records, twin, training, diagnosis, refinement. The
effects are hidden in forms that differ from the catalogue's, by code that the diagnosis never imports.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from friction_models import make_model
from friction_models.discovery import diagnose, refine
from friction_models.loads import DataSet, write_json
from sct_twin.virtual_lab import load_truth

from .common import Section, Table, section
from .data import PLAN, campaign, raw_folder, sources

HIDDEN = ("stribeck", "thermal_softening", "work_exhaustion")
SEEDS = range(1, 6)
NULL_SEEDS = range(101, 121)
ACCUSES = {"explained", "ambiguous", "data_problem", "unknown_structure"}


def measure(folder: Path) -> Section:
    """Run or read all campaigns; one JSON file each, so that an interrupted measurement goes on."""
    hidden = [_one(folder, effect, seed) for effect in HIDDEN for seed in SEEDS]
    null = [_one(folder, None, seed) for seed in NULL_SEEDS]
    table = Table(
        ["hidden", "seed", "verdict", "first", "confusion set", "held-out RMS before", "after", "avoidable removed"]
    )  # fmt: skip
    for r in hidden:
        table.rows.append(
            (
                r["hidden"],
                r["seed"],
                r["verdict"],
                r["first"],
                ", ".join(r["confusion_set"]),
                f"{r['before']:.5f}",
                f"{r['after']:.5f}",
                f"{100 * r['removed']:.0f} %",
            )
        )
    first = sum(r["first"] == r["hidden"] for r in hidden)
    inside = sum(r["hidden"] in r["confusion_set"] for r in hidden)
    removed = sum(r["removed"] >= 0.5 for r in hidden)
    accused = [r for r in null if r["verdict"] in ACCUSES]
    rates = Table(["what", "reached", "asked for"])
    rates.rows += [
        ("hidden effect ranked first", f"{first} of {len(hidden)}", "at least 13 of 15"),
        ("hidden effect in the confusion set", f"{inside} of {len(hidden)}", ""),
        ("at least half of the avoidable error removed", f"{removed} of {len(hidden)}", "at least 13 of 15"),
        ("avoidable error removed, median", f"{100 * np.median([r['removed'] for r in hidden]):.0f} %", ""),
        ("accusations where nothing is hidden", f"{len(accused)} of {len(null)}", "at most 1 of 20"),
    ]
    for r in accused:
        rates.rows.append((f"accused at seed {r['seed']}", f"{r['verdict']}: {r['first']}", ""))
    return section(
        "Finding hidden effects",
        f"Plan {PLAN}, base model linear, diagnosed and refined on the training tests, judged on the held-out ones. "
        "The avoidable error is the RMS difference to the law without specimen scatter, drift and sensor noise, which the "
        "laboratory keeps; what is removed counts what the diagnosis itself proposed, right or wrong.",
        rates,
        table,
    )


def _one(folder: Path, hidden: str | None, seed: int) -> dict[str, Any]:
    """Diagnose and refine one campaign, or read what was found before."""
    code = sources("friction_models", "sct_twin", "forming")
    kept = folder / "rates" / code / f"{hidden or 'null'}-{seed}.json"
    if kept.is_file():
        found: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
        return found
    data = campaign(folder, hidden, seed)
    train, held_out = data.select("train"), data.select("test")
    law = _law(raw_folder(folder, hidden, seed), held_out)
    diagnosis = diagnose(train.points, train.tests, model="linear", seed=seed)
    base = make_model("linear").fit_frame(train.points, train.tests)
    before = after = _rms(base.predict_frame(held_out.points, held_out.tests) - law)
    if diagnosis.effects:
        better = refine(train.points, train.tests, model="linear", add=diagnosis.effects, force=True)
        after = _rms(better.predict_frame(held_out.points, held_out.tests) - law)
    result = {
        "hidden": hidden or "nothing",
        "seed": seed,
        "verdict": diagnosis.verdict,
        "effects": diagnosis.effects,
        "first": diagnosis.ranking[0]["effect"] if diagnosis.effects else "-",
        "confusion_set": diagnosis.confusion_set,
        "before": before,
        "after": after,
        "removed": 1.0 - after / before,
    }
    write_json(kept, result)
    print(
        f"{result['hidden']} {seed}: {result['verdict']} {result['first']} removed {result['removed']:.2f}",
        flush=True,
    )
    return result


def _law(raw: Path, data: DataSet) -> np.ndarray:
    """Return the friction that the laboratory's law gives at each point, without scatter, drift and noise."""
    _, truth = load_truth(raw)
    points: pd.DataFrame = data.points
    values = np.empty(len(points))
    for test_id, rows in points.groupby("test_id").indices.items():
        true = truth[str(test_id)]
        values[rows] = np.interp(points["sd"].to_numpy()[rows], true["sd"], true["mu_law"])
    return values


def _rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(error**2)))
