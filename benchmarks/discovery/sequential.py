"""Tests one after the other until one right name is left: the proposed one each time, or one of the plan at random."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Literal, NotRequired, TypedDict

import numpy as np
import pandas as pd

from friction_models.common import write_json
from friction_models.discovery import Diagnosis, diagnose
from friction_models.discovery.further_tests.protocols import PlanRow

from ..common import Section, Table, section
from ..data import sources
from .form_sets import SETS
from .made_laboratory import MadeLaboratory

#: Effects with rivals in small plans that some test can tell from them (twins of pressure are left out: only formulas differ).
EFFECTS = (
    "stribeck",
    "flash_temperature",
    "thermal_softening",
)
PLANS = ("few", "tied", "diagonal")
#: Copies of a plan, and the range of strengths: tests tell the more of an effect the more they are.
SIZES = {1: (0.8, 2.0), 3: (0.4, 1.0)}
#: Not seen while the rules were made.
FIRST_SEED = 970_000
#: Most tests that are added; where they did not settle it, so many count.
MOST = 12
#: Numbers of tests after which random choice is diagnosed again; it counts with the least number that this allows.
LOOKS = (1, 2, 3, 5, 8, 12)


@dataclass(frozen=True)
class Start:
    """A small campaign with a hidden effect."""

    hidden: str
    plan: str
    copies: int
    forms: str
    seed: int

    @property
    def key(self) -> str:
        """Name of its file."""
        return f"{self.plan}-{self.copies}-{self.hidden}-{self.forms}-{self.seed}"


class Round(TypedDict):
    """A proposed test that was run: what it promised, and what was found.

    ``observed_t`` is the growth of the truth's lead in evidence, None where it is not of the pair.
    """

    protocol: str
    separates: list[str]
    expected_t: float
    bits: float
    observed_t: float | None
    set_after: list[str]


class Way(TypedDict):
    """How many tests a way took (`MOST` where they did not settle it), and the names that were left."""

    tests: int
    settled: bool
    set: list[str]


class ProposedWay(Way):
    """The way of the proposals, with every test of it."""

    rounds: list[Round]


class Outcome(TypedDict):
    """What became of a campaign, as its file keeps it; both ways are there where the first answer did not settle it."""

    hidden: str
    plan: str
    copies: int
    forms: str
    seed: int
    noise: float
    strength: float
    before: str
    set_before: list[str]
    proposed: NotRequired[ProposedWay]
    random: NotRequired[Way]


def levels(plan: str) -> tuple[list[PlanRow], list[PlanRow]]:
    """Return the rows of a first plan, and the points of its levels from which random choice takes: they are crossed."""

    def row(sigma: float, v: float, T: float) -> PlanRow:
        return {"sigma_set": sigma, "v_set": v, "T_tool": T, "psi_set": 1.07, "sd_set": 30.0}

    pressures, speeds, tools = (600.0, 1300.0, 2600.0), (20.0, 90.0, 400.0), (20.0, 100.0, 200.0)
    crossed = [row(*x) for x in product(pressures, speeds, tools)]
    if plan == "few":  # half of two levels each, twice
        ends = [(s, v, T) for s, v, T in product((0, 2), repeat=3) if (s + v + T) % 4 == 0]
        return [row(pressures[s], speeds[v], tools[T]) for s, v, T in ends] * 2, crossed
    if plan == "tied":  # fast tests are hot
        return [row(s, v, T) for s in pressures for v, T in zip(speeds, tools, strict=True)], crossed
    # pressure, speed and temperature rise together
    return [row(*x) for x in zip(pressures, speeds, tools, strict=True)] * 3, crossed


def starts(seeds: int) -> list[Start]:
    """Return the campaigns of so many seeds for each effect, plan and number of its copies; sets of forms take turns."""
    names = list(SETS)
    return [
        Start(hidden, plan, copies, names[(k + s) % len(names)], FIRST_SEED + 100 * s + k)
        for copies in SIZES
        for s in range(seeds)
        for k, (plan, hidden) in enumerate(product(PLANS, EFFECTS))
    ]


def one(start: Start) -> Outcome:
    """Return how many tests each way takes; nothing where the first answer is right, or names nothing."""
    rows, points = levels(start.plan)
    rows = rows * start.copies
    rng = np.random.default_rng([start.seed, 3])
    noise, strength = float(rng.choice([0.8, 1.4])), float(rng.uniform(*SIZES[start.copies]))

    def laboratory() -> tuple[MadeLaboratory, tuple[pd.DataFrame, pd.DataFrame], Diagnosis]:
        lab = MadeLaboratory(start.hidden, start.forms, start.seed, rows, noise, strength)
        data = lab.run(rows)
        return lab, data, diagnose(*data, seed=start.seed)

    lab, data, first = laboratory()
    result: Outcome = {
        "hidden": start.hidden, "plan": start.plan, "copies": start.copies, "forms": start.forms, "seed": start.seed,
        "noise": noise, "strength": strength, "before": first.verdict, "set_before": first.confusion_set,
    }  # fmt: skip
    if not first.confusion_set or settled(first, start.hidden):
        return result
    proposed = _proposed(lab, data, first, start)
    lab, data, first = laboratory()
    order = [points[k] for k in rng.integers(0, len(points), MOST)]
    return {**result, "proposed": proposed, "random": _random(lab, data, order, start)}


def settled(found: Diagnosis, hidden: str) -> bool:
    """Return whether one name is left, and it is right."""
    return found.confusion_set == [hidden] and found.effects == [hidden]


def _proposed(
    lab: MadeLaboratory, data: tuple[pd.DataFrame, pd.DataFrame], found: Diagnosis, start: Start
) -> ProposedWay:
    used = 0
    rounds: list[Round] = []
    waiting = list(found.next_tests)
    while used < MOST and not settled(found, start.hidden) and waiting:
        entry = waiting.pop(0)
        data = _joined(data, lab.run(entry["plan"]))
        used += len(entry["plan"])
        after = diagnose(*data, seed=start.seed)
        rounds.append(
            {
                "protocol": entry["protocol"],
                "separates": entry["separates"],
                "expected_t": entry["expected_t"],
                "bits": entry["entropy_reduction"],
                "observed_t": observed(found, after, list(entry["separates"]), start.hidden),
                "set_after": after.confusion_set,
            }
        )
        found = after
        # where nothing new is proposed: the next one of the last list
        waiting = list(found.next_tests) or waiting
    right = settled(found, start.hidden)
    return {"tests": used if right else MOST, "settled": right, "set": found.confusion_set, "rounds": rounds}


def _random(
    lab: MadeLaboratory,
    data: tuple[pd.DataFrame, pd.DataFrame],
    order: Sequence[PlanRow],
    start: Start,
) -> Way:
    used = 0
    names: list[str] = []
    for look in LOOKS:
        data = _joined(data, lab.run(order[used:look]))
        found = diagnose(*data, seed=start.seed)
        names = found.confusion_set
        if settled(found, start.hidden):
            return {"tests": used + 1, "settled": True, "set": names}
        used = look
    return {"tests": MOST, "settled": False, "set": names}


def observed(before: Diagnosis, after: Diagnosis, pair: list[str], hidden: str) -> float | None:
    """Return the root of the growth of the truth's lead in evidence (negative where it shrinks); None if it is not in the pair."""
    if hidden not in pair:
        return None
    rival = next(n for n in pair if n != hidden)
    leads = []
    for found in (before, after):
        own = {r["effect"]: float(r["evidence"]) for r in found.ranking}
        if hidden not in own or rival not in own:
            return None
        leads.append(own[hidden] - own[rival])
    growth = leads[1] - leads[0]
    return float(np.sign(growth) * np.sqrt(abs(growth)))


def _joined(
    data: tuple[pd.DataFrame, pd.DataFrame], more: tuple[pd.DataFrame, pd.DataFrame]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    points, tests = (pd.concat([a, b], ignore_index=True) for a, b in zip(data, more, strict=True))
    return points, tests


def run_all(folder: Path, seeds: int, jobs: int = 1, tell: Callable[[str], None] = print) -> list[Outcome]:
    """Run what is not in `folder` yet; return all results."""
    place = folder / "sequential" / sources("friction_models")
    todo = starts(seeds)
    files = {s: place / f"{s.key}.json" for s in todo}
    missing = [s for s in todo if not files[s].is_file()]
    with ProcessPoolExecutor(jobs, mp_context=get_context("fork")) as pool:
        running = {pool.submit(one, s): s for s in missing}
        for future in as_completed(running):
            s = running[future]
            write_json(files[s], future.result())
            tell(s.key)
    return [json.loads(files[s].read_text(encoding="utf-8")) for s in todo]


def summary(results: Sequence[Outcome]) -> Section:
    """Return the tables: how many tests each way takes, and what was promised and found."""
    run = [r for r in results if "proposed" in r]
    table = Table(
        [
            "plan, copies",
            "campaigns",
            "proposed: settled",
            "tests, mean",
            "random: settled",
            "tests, mean",
            "share of tests",
        ]
    )
    plans = [
        (f"{plan}, {copies}", [r for r in run if (r["plan"], r["copies"]) == (plan, copies)])
        for copies, plan in product(SIZES, PLANS)
    ]
    sizes = [(f"all, {copies}", [r for r in run if r["copies"] == copies]) for copies in SIZES]
    for name, own in [*plans, *sizes, ("all", run)]:
        if own:
            table.rows.append(
                (name, len(own), *_way(own, "proposed"), *_way(own, "random"), f"{_share(own):.2f}")
            )
    promised = Table(["protocol", "promises", "observed over expected t, median", "quartiles"])
    rounds = [
        (r["protocol"], r["observed_t"] / r["expected_t"])
        for x in run
        for r in x["proposed"]["rounds"]
        if r["observed_t"] is not None and r["expected_t"] >= 1.0
    ]
    for kind in [*dict.fromkeys(protocol for protocol, _ in rounds), "all"]:
        ratios = [ratio for protocol, ratio in rounds if kind in (protocol, "all")]
        low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
        promised.rows.append((kind, len(ratios), f"{middle:.2f}", f"{low:.2f} to {high:.2f}"))
    each = Table(["hidden", "plan, copies", "set before", "proposed", "set after", "random", "set after"])
    for r in run:
        ways = [(_tests(r[w]), ", ".join(r[w]["set"])) for w in ("proposed", "random")]
        each.rows.append(
            (r["hidden"], f"{r['plan']}, {r['copies']}", ", ".join(r["set_before"]), *ways[0], *ways[1])
        )
    return section(
        "Tests that settle it",
        f"{len(results)} made-up campaigns of 8 or 9 tests, and of three times as many with an effect half as strong, in three sets of "
        f"forms outside the catalogue; {len(run)} of them end in several names or a wrong one. From there, tests are added one by one and all is diagnosed again, until the "
        f"right name is left alone: the first proposal each time, or points of the plan's levels at random (crossed, also where the "
        f"plan ties speed to temperature). At most {MOST} tests; so many count where they settle nothing. Expected and observed t: root of "
        "the growth of the truth's lead in evidence over the rival that the proposal names. Synthetic.",
        table,
        promised,
        each,
    )


def _way(own: Sequence[Outcome], way: Literal["proposed", "random"]) -> tuple[str, str]:
    return (
        f"{sum(r[way]['settled'] for r in own)} of {len(own)}",
        f"{np.mean([r[way]['tests'] for r in own]):.1f}",
    )


def _share(own: Sequence[Outcome]) -> float:
    return float(np.sum([r["proposed"]["tests"] for r in own]) / np.sum([r["random"]["tests"] for r in own]))


def _tests(way: Way) -> str:
    return str(way["tests"]) if way["settled"] else f"more than {MOST}"
