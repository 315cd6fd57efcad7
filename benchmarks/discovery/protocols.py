"""Do proposed protocols separate the rivals? Many seeds in the virtual laboratory, through raw records and the twin."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import NotRequired, TypedDict

import numpy as np
import pandas as pd

from friction_models.common import write_json
from friction_models.discovery import Diagnosis, diagnose
from friction_models.discovery.further_tests.formula_error import ENOUGH
from friction_models.discovery.further_tests.joined import join_campaigns
from friction_models.discovery.further_tests.next_tests import NextTest
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.zero_reading import ZERO, read_zero
from friction_models.loads import DataSet
from sct_twin import SctTwin
from sct_twin.virtual_lab import Campaign, run_protocol

from ..common import Section, Table, section
from ..data import sources
from .study import wilson

#: Effects with near twins in a plan of constant speeds and pressures, and the fault that a reading without load shows.
CROSSED = (
    "stribeck",
    "pressure_power",
    "flash_temperature",
    "running_in",
    "wear_out",
    "thermal_softening",
    ZERO,
)
#: The same where fast tests are hot ones: only further points of the plan tell speed from temperature.
TIED = ("stribeck", "thermal_softening")
#: Run whatever it promises: the weakest of the proposals, which hardly ever promises enough.
POINTS = "points of the plan"
#: The effect is this much stronger than in other campaigns: the question is which, not whether.
STRONGER = 3.0
#: Not seen while the rules were made.
FIRST_SEED = 930_000


class Settled(TypedDict):
    """What became of one rival after a protocol was run.

    ``observed_t`` is the growth of the truth's lead; in place of it, ``reading`` is what the cell shows without load [N].
    """

    protocol: str
    rival: str
    expected_t: float
    after: str
    set_after: list[str]
    truth_kept: bool
    separated: bool
    reading: NotRequired[float]
    observed_t: NotRequired[float]


class Outcome(TypedDict):
    """What became of a campaign, as its file keeps it: the first answer, and what every protocol did to every rival."""

    hidden: str
    plan: str
    seed: int
    before: str
    set_before: list[str]
    runs: list[Settled]


def laboratory(hidden: str, plan: str, seed: int) -> Campaign:
    """Return a small campaign with a strong hidden effect, or with the fault."""
    pressures: tuple[float, ...] = (500.0, 1200.0, 2000.0, 2700.0)
    if hidden == ZERO:  # an offset bends less over the pressure than a law of it: more levels
        pressures = (500.0, 700.0, 1000.0, 1400.0, 2000.0, 2700.0)
    others = (
        product((50.0, 400.0), (20.0, 200.0)) if plan == "crossed" else 2 * [(50.0, 20.0), (400.0, 200.0)]
    )
    rows = pd.DataFrame(
        [
            {"sigma_set": s, "psi_set": 1.069, "v_set": v, "T_tool": T, "sd_set": 25.0}
            for s, (v, T) in product(pressures, list(others))
        ]
    )
    if hidden == ZERO:
        faults = Campaign("tiny-6+3", hidden=ZERO, seed=seed).true_faults
        assert faults is not None
        return Campaign(rows, seed=seed, faults=replace(faults, force_zero=STRONGER * faults.force_zero))
    law = Campaign("tiny-6+3", hidden=hidden, seed=seed).true_law
    law = replace(law, hidden=tuple((e, {**p, "A": STRONGER * p["A"]}) for e, p in law.hidden))
    return Campaign(rows, seed=seed, law=law)


def one(hidden: str, plan: str, seed: int) -> Outcome:
    """Diagnose a small campaign, run every protocol that is to separate the truth from a rival, diagnose again."""
    lab = laboratory(hidden, plan, seed)
    before = SctTwin().run(lab.run(jobs=1), jobs=1).dataset()
    first = diagnose(before.points, before.tests, seed=seed)
    asked: dict[str, list[NextTest]] = {}
    for entry in first.next_tests if len(first.confusion_set) > 1 else []:
        if rival_of(entry, hidden):
            asked.setdefault(entry["protocol"], []).append(entry)
    promising = {k: [e for e in v if e["expected_t"] >= ENOUGH] for k, v in asked.items()}
    chosen = {k: v for k, v in promising.items() if v} or {k: v[:1] for k, v in list(asked.items())[:1]}
    chosen |= {k: v for k, v in asked.items() if k == POINTS and v}
    runs: list[Settled] = []
    for number, entries in enumerate(chosen.values()):
        rows = entries[0]["plan"]
        more = SctTwin().run(run_protocol(lab, rows, seed=seed + 500 + number, jobs=1), jobs=1).dataset()
        runs += _again(first, before, more, hidden, entries, seed)
    return {
        "hidden": hidden,
        "plan": plan,
        "seed": seed,
        "before": first.verdict,
        "set_before": first.confusion_set,
        "runs": runs,
    }


def rival_of(entry: NextTest, hidden: str) -> str:
    """Return what a proposal tells the truth from; empty where it is of other effects, or of the truth alone."""
    pair = list(entry["separates"])
    if entry["protocol"] == "zero reading" and hidden != ZERO:
        return ZERO  # a reading tells the fault from any law
    return next((n for n in pair if n != hidden), "") if hidden in pair else ""


def _again(
    first: Diagnosis, before: DataSet, more: DataSet, hidden: str, entries: list[NextTest], seed: int
) -> list[Settled]:
    """Diagnose old and new tests together; return what was expected and found for each rival."""
    both, _ = join_campaigns({"first": before, "next": more})
    second = diagnose(both.points, both.tests, seed=seed)
    found: list[Settled] = []
    for entry in entries:
        rival = rival_of(entry, hidden)
        outcome: Settled = {
            "protocol": entry["protocol"],
            "rival": rival,
            "expected_t": entry["expected_t"],
            "after": second.verdict,
            "set_after": second.confusion_set,
            "truth_kept": hidden in second.confusion_set,
            "separated": rival not in second.confusion_set and hidden in second.confusion_set,
        }
        if entry["protocol"] == "zero reading":
            reading = read_zero(prepare(both.points, both.tests), second.noise_floor["sensor"])
            assert reading is not None
            outcome["reading"] = reading.area * max(reading.low, reading.high, key=abs)
        else:
            growth = _lead(second, hidden, rival) - _lead(first, hidden, rival)
            outcome["observed_t"] = float(np.sign(growth) * np.sqrt(abs(growth)))
        found.append(outcome)
    return found


def _evidence(found: Diagnosis) -> dict[str, float]:
    return {r["effect"]: float(r["evidence"]) for r in found.ranking}


def _lead(found: Diagnosis, winner: str, rival: str) -> float:
    own = _evidence(found)
    return own.get(winner, 0.0) - own.get(rival, 0.0)


def run_all(folder: Path, seeds: int, tell: Callable[[str], None] = print) -> list[Outcome]:
    """Run what is not in `folder` yet; return all results."""
    place = folder / "protocols" / sources("friction_models", "sct_twin", "forming")
    found: list[Outcome] = []
    for (plan, hidden), k in product(
        [("crossed", n) for n in CROSSED] + [("tied", n) for n in TIED], range(seeds)
    ):
        kept = place / f"{plan}-{hidden}-{FIRST_SEED + k}.json"
        if not kept.is_file():
            write_json(kept, one(hidden, plan, FIRST_SEED + k))
            tell(kept.stem)
        found.append(json.loads(kept.read_text(encoding="utf-8")))
    return found


def summary(results: Sequence[Outcome]) -> Section:
    """Return the tables: each protocol as a kind, and what was expected and found of each run."""
    runs = [run for r in results for run in r["runs"]]
    kinds = Table(
        ["protocol", "promised", "rival out, truth kept", "95 % interval", "observed over expected t, median"]
    )
    promised = [r for r in runs if r["expected_t"] >= ENOUGH]
    for kind in dict.fromkeys(r["protocol"] for r in promised):
        own = [r for r in promised if r["protocol"] == kind]
        ratio = [r["observed_t"] / r["expected_t"] for r in own if "observed_t" in r]
        kinds.rows.append((kind, len(own), *_share(own), f"{np.median(ratio):.2f}" if ratio else ""))
    kinds.rows.append(("all", len(promised), *_share(promised), ""))
    each = Table(
        ["hidden", "plan", "protocol", "against", "expected t", "observed", "set before", "set after"]
    )
    with_campaign = [(r, run) for r in results for run in r["runs"]]
    for r, run in sorted(with_campaign, key=lambda pair: -pair[1]["expected_t"]):
        seen = f"{run['observed_t']:.1f}" if "observed_t" in run else f"reads {run['reading']:.0f} N"
        each.rows.append(
            (r["hidden"], r["plan"], run["protocol"], run["rival"], f"{run['expected_t']:.1f}", seen,
             ", ".join(r["set_before"]), ", ".join(run["set_after"]))
        )  # fmt: skip
    others = [r for r in runs if r["expected_t"] < ENOUGH]
    with_rivals = sum(bool(r["runs"]) for r in results)
    return section(
        "Proposed protocols in the virtual laboratory",
        f"{len(results)} small campaigns with a strong hidden effect or an offset of the friction cell, {with_rivals} with "
        f"rivals. Every protocol that the diagnosis proposes with {ENOUGH:g} standard errors or more against a rival of the truth is "
        "run once under the same law with new specimens (the most telling one, where none promises that; points of the plan always), and old "
        f"and new tests are diagnosed together. Of {len(others)} that promise less, {sum(r['separated'] for r in others)} put the rival out. In the plan `tied` fast "
        "tests are hot ones. The seeds were not seen while the rules were made. Synthetic.",
        kinds,
        each,
    )


def _share(runs: Sequence[Settled]) -> tuple[str, str]:
    hits = sum(r["separated"] for r in runs)
    low, high = wilson(hits, len(runs))
    return f"{hits} of {len(runs)}", f"{100 * low:.0f} to {100 * high:.0f} %"
