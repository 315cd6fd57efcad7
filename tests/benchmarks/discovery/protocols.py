"""Do proposed protocols separate the rivals? Many seeds in the virtual laboratory, through raw records and the twin."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from friction_models.discovery import Diagnosis, diagnose
from friction_models.loads import write_json
from sct_twin import SctTwin
from sct_twin.virtual_lab import Campaign, run_protocol

from ..common import Section, Table, section
from ..data import sources
from .study import wilson

#: Effects with near twins in a plan of constant speeds and pressures.
HIDDEN = ("stribeck", "pressure_power", "flash_temperature", "running_in", "wear_out", "thermal_softening")
#: The effect is this much stronger than in other campaigns: the question is which, not whether.
STRONGER = 3.0
FIRST_SEED = 70_000


def one(hidden: str, seed: int) -> dict[str, Any]:
    """Diagnose a small campaign, run the most telling proposed protocol, diagnose again."""
    grid = product((500.0, 1200.0, 2000.0, 2700.0), (50.0, 400.0), (20.0, 200.0))
    rows = [{"sigma_set": s, "psi_set": 1.069, "v_set": v, "T_tool": T, "sd_set": 25.0} for s, v, T in grid]
    law = Campaign("tiny-6+3", hidden=hidden, seed=seed).true_law
    law = replace(law, hidden=tuple((e, {**p, "A": STRONGER * p["A"]}) for e, p in law.hidden))
    lab = Campaign(pd.DataFrame(rows), seed=seed, law=law)
    before = SctTwin().run(lab.run(jobs=1), jobs=1)
    first = diagnose(before.points, before.tests, seed=seed)
    result: dict[str, Any] = {
        "hidden": hidden,
        "seed": seed,
        "before": first.verdict,
        "set_before": first.confusion_set,
    }
    asked = next(
        (n for n in first.next_tests if hidden in n["separates"] and n["protocol"] != "zero reading"), None
    )
    if asked is None:
        return result | {"protocol": ""}
    plan = [row for row in asked["plan"] for _ in range(min(int(asked["repeats"]), 3))]
    more = SctTwin().run(run_protocol(lab, plan, seed=seed + 1, jobs=1), jobs=1)
    points = pd.concat(
        [before.points, more.points.assign(test_id="new " + more.points["test_id"])], ignore_index=True
    )
    tests = pd.concat(
        [before.tests, more.tests.assign(test_id="new " + more.tests["test_id"])], ignore_index=True
    )
    second = diagnose(points, tests, seed=seed)
    rival = next(n for n in asked["separates"] if n != hidden)
    grown = _lead(second, hidden, rival) - _lead(first, hidden, rival)
    return result | {
        "protocol": asked["protocol"],
        "rival": rival,
        "expected_t": asked["expected_t"] * float(np.sqrt(len(plan) / len(asked["plan"]))),
        "observed_t": float(np.sign(grown) * np.sqrt(abs(grown))),
        "after": second.verdict,
        "set_after": second.confusion_set,
        "separated": rival not in second.confusion_set and hidden in second.confusion_set,
    }


def _lead(found: Diagnosis, hidden: str, rival: str) -> float:
    gains = {r["effect"]: float(r["gain"]) for r in found.ranking}
    return gains.get(hidden, 0.0) - gains.get(rival, 0.0)


def run_all(folder: Path, seeds: int, tell: Callable[[str], None] = print) -> list[dict[str, Any]]:
    """Run what is not in `folder` yet; return all results."""
    place = folder / "protocols" / sources("friction_models", "sct_twin", "forming")
    found = []
    for hidden, k in product(HIDDEN, range(seeds)):
        kept = place / f"{hidden}-{FIRST_SEED + k}.json"
        if not kept.is_file():
            write_json(kept, one(hidden, FIRST_SEED + k))
            tell(kept.stem)
        found.append(json.loads(kept.read_text(encoding="utf-8")))
    return found


def summary(results: Sequence[dict[str, Any]]) -> Section:
    """Return the table: how often the rival that a protocol was proposed against is out afterwards."""
    table = Table(["hidden", "campaigns", "proposed", "separated", "expected t", "observed t (median)"])
    asked = [r for r in results if r["protocol"]]
    for name in HIDDEN:
        own = [r for r in results if r["hidden"] == name]
        run = [r for r in own if r["protocol"]]
        if run:
            table.rows.append(
                (name, len(own), len(run), sum(r["separated"] for r in run),
                 f"{np.median([r['expected_t'] for r in run]):.1f}", f"{np.median([r['observed_t'] for r in run]):.1f}")
            )  # fmt: skip
        else:
            table.rows.append((name, len(own), 0, 0, "", ""))
    hits = sum(r["separated"] for r in asked)
    low, high = wilson(hits, len(asked))
    table.rows.append(
        ("all", len(results), len(asked), f"{hits} ({100 * low:.0f} to {100 * high:.0f} %)", "", "")
    )
    return section(
        "Proposed protocols in the virtual laboratory",
        "Small campaigns with a strong hidden effect; the most telling protocol that the diagnosis proposes is run under the same law "
        "with new specimens, and everything is diagnosed again; synthetic.",
        table,
    )
