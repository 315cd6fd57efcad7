"""Do proposed protocols separate the rivals? Many seeds in the virtual laboratory, through raw records and the twin."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd

from friction_models.discovery import Diagnosis, diagnose
from friction_models.discovery.separation import ENOUGH, separated
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
    # the laboratory's cells have no offset that a reading without load could show
    asked = next((n for n in first.next_tests if n["protocol"] != "zero reading"), None)
    if asked is None or len(first.confusion_set) < 2:
        return result | {"protocol": ""}
    more = SctTwin().run(run_protocol(lab, asked["plan"], seed=seed + 1, jobs=1), jobs=1)
    points = pd.concat(
        [before.points, more.points.assign(test_id="new " + more.points["test_id"])], ignore_index=True
    )
    tests = pd.concat(
        [before.tests, more.tests.assign(test_id="new " + more.tests["test_id"])], ignore_index=True
    )
    second = diagnose(points, tests, seed=seed)
    winner, rival = asked["separates"]
    if rival == hidden:
        winner, rival = rival, winner
    observed = separated(
        _lead(first, winner, rival),
        _lead(second, winner, rival),
        max(_evidence(second).values(), default=0.0),
    )
    return result | {
        "protocol": asked["protocol"],
        "rival": rival,
        "expected_t": asked["expected_t"],
        "observed_t": observed.t,
        "after": second.verdict,
        "set_after": second.confusion_set,
        "truth_kept": hidden in second.confusion_set,
        "separated": rival not in second.confusion_set and hidden in second.confusion_set,
    }


def _evidence(found: Diagnosis) -> dict[str, float]:
    return {r["effect"]: float(r["evidence"]) for r in found.ranking}


def _lead(found: Diagnosis, winner: str, rival: str) -> float:
    own = _evidence(found)
    return own.get(winner, 0.0) - own.get(rival, 0.0)


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
    """Return the table: what was expected of the most telling protocol, and what it did."""
    table = Table(
        ["hidden", "protocol", "against", "expected t", "observed t", "set before", "set after", "truth kept"]
    )
    asked = sorted((r for r in results if r["protocol"]), key=lambda r: -r["expected_t"])
    for r in asked:
        table.rows.append(
            (r["hidden"], r["protocol"], r["rival"], f"{r['expected_t']:.1f}", f"{r['observed_t']:.1f}",
             ", ".join(r["set_before"]), ", ".join(r["set_after"]), "yes" if r["truth_kept"] else "no")
        )  # fmt: skip
    promised = [r for r in asked if r["expected_t"] >= ENOUGH]
    hits = sum(r["separated"] for r in promised)
    low, high = wilson(hits, len(promised))
    others = [r for r in asked if r["expected_t"] < ENOUGH]
    return section(
        "Proposed protocols in the virtual laboratory",
        f"{len(results)} small campaigns with a strong hidden effect, {len(asked)} with rivals: the most telling protocol that the "
        "diagnosis proposes (a reading without load aside: the cells there have no offset) is run once under the same law with new "
        f"specimens, and everything is diagnosed again. Of {len(promised)} that promise {ENOUGH:g} standard errors or more, {hits} "
        f"({100 * low:.0f} to {100 * high:.0f} %) put the rival out of the confusion set with the truth in it; of {len(others)} that "
        f"promise less, {sum(r['separated'] for r in others)}. Synthetic.",
        table,
    )
