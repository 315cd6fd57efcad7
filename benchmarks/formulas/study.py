"""How much of the avoidable error empirical terms remove, and what was promised."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypedDict

import numpy as np

from friction_models import FrictionModel
from friction_models.common import InputError, write_json
from friction_models.discovery import diagnose, refine
from friction_models.families.composed import ComposedFriction
from friction_models.loads import LOAD_NAMES
from friction_models.loads.contract import QUANTITIES

from ..common import Section, Table, section
from ..data import sources
from ..discovery.study import wilson
from .cases import Case, Hidden, cases, hidden
from .laws import LAWS

#: What the terms are asked for: this share of the avoidable squared error in this share of the cases.
ASKED, ASKED_CASES = 0.8, 0.7
#: Verdicts with which terms are offered; of the others, effects are added that are named.
OFFERS = ("unknown_structure", "partly_explained")
#: Random points beyond the edge of a load, and how far beyond it they are, in ranges of it.
OUTSIDE, BEYOND = 2000, (0.11, 3.0)


class Outcome(TypedDict):
    """What became of a case, as its file keeps it.

    ``offered`` are the terms of the first offer, ``promised`` and ``interval`` what it says that they remove; ``before``,
    ``after`` and ``floor`` (of the true form) are errors on held-out tests [mu], ``outside`` is by how much terms alone differ
    from the base beyond the tests, ``refused`` why nothing could be added.
    """

    source: str
    law: str
    number: int
    unseen: bool
    verdict: str
    effects: list[str]
    seconds: float
    offered: list[str]
    promised: float | None
    interval: list[float] | None
    before: float
    floor: float
    after: float
    outside: float
    refused: str


def run_case(case: Case) -> Outcome:
    """Diagnose, add what is named and what is offered first, and judge on held-out tests without noise."""
    made = hidden(case)
    began = time.process_time()
    found = diagnose(made.data, made.tests)
    took = time.process_time() - began
    offer = found.formulas[0] if found.formulas else None
    named = found.effects if found.verdict in (*OFFERS, "explained", "ambiguous") else []
    before = _square(refine(made.data, made.tests, add=[]), made)
    result: Outcome = {
        "source": case.source, "law": case.law, "number": case.number, "unseen": case.unseen,
        "verdict": found.verdict, "effects": found.effects, "seconds": took,
        "offered": offer.names if offer else [], "promised": offer.share if offer else None,
        "interval": list(offer.interval) if offer else None,
        "before": before**0.5, "floor": made.floor**0.5, "after": before**0.5, "outside": 0.0, "refused": "",
    }  # fmt: skip
    if offer or named:
        try:
            model = refine(made.data, made.tests, add=[*named, *(offer.effects if offer else [])])
        except InputError as error:
            return {**result, "refused": str(error)}
        result["after"] = _square(model, made) ** 0.5
        if offer and not named and isinstance(model, ComposedFriction):
            result["outside"] = _beyond(model, made)
    return result


def _square(model: FrictionModel, made: Hidden) -> float:
    return float(np.mean((model.predict_frame(made.held, made.held_tests) - made.truth) ** 2))


def _beyond(model: ComposedFriction, made: Hidden) -> float:
    """Return by how much a model with empirical terms alone differs from its base where one load or more are beyond the tests."""
    loads = made.data[list(LOAD_NAMES)].to_numpy(dtype=np.float64)
    low, high = loads.min(axis=0), loads.max(axis=0)
    rng = np.random.default_rng(0)
    points = rng.uniform(low, high, (OUTSIDE, len(LOAD_NAMES)))
    beyond = rng.random(points.shape) < 0.3
    beyond[np.arange(OUTSIDE), rng.integers(len(LOAD_NAMES), size=OUTSIDE)] = True
    far = high + (high - low) * rng.uniform(*BEYOND, points.shape)
    points = np.minimum(np.where(beyond, far, points), [QUANTITIES[n].upper for n in LOAD_NAMES])
    base = np.maximum(model.base_.predict(points), 0.0)
    return float(np.max(np.abs(model.predict(points) - base)))


def removed(result: Outcome) -> float:
    """Return the share of the avoidable squared error that is removed."""
    before, after, floor = result["before"] ** 2, result["after"] ** 2, result["floor"] ** 2
    return float((before - after) / max(before - floor, 1e-300))


def run_all(
    folder: Path, chosen: Sequence[Case] | None = None, tell: Callable[[str], None] = print
) -> list[Outcome]:
    """Run what is not in `folder` yet; return all results."""
    place = folder / sources("friction_models")
    found: list[Outcome] = []
    for case in cases() if chosen is None else chosen:
        kept = place / f"{case.key}.json"
        if not kept.is_file():
            write_json(kept, run_case(case))
            tell(case.key)
        found.append(json.loads(kept.read_text(encoding="utf-8")))
    return found


def summary(results: Sequence[Outcome]) -> Section:
    """Return the tables of the benchmark."""
    table = Table(
        ["cases", "at least 80 % removed", "95 % interval", "median removed", "worse than the base"]
    )
    asked = [r for r in results if r["verdict"] in OFFERS]
    groups = [
        ("all", results),
        ("... left alone", [r for r in results if r["unseen"]]),
        ("... on which the terms were changed", [r for r in results if not r["unseen"]]),
        *((f"... {s}", [r for r in results if r["source"] == s]) for s in ("forms", "literature", "physics")),
        ("terms are sought: verdict `unknown_structure` or `partly_explained`", asked),
        ("... left alone", [r for r in asked if r["unseen"]]),
        ("another verdict", [r for r in results if r["verdict"] not in OFFERS]),
    ]
    for what, own in groups:
        if not own:
            continue
        shares = np.array([removed(r) for r in own])
        hits = int(np.sum(shares >= ASKED))
        low, high = wilson(hits, len(own))
        table.rows.append(
            (what, f"{hits} of {len(own)} ({100 * hits / len(own):.0f} %)", f"{100 * low:.0f} to {100 * high:.0f} %",
             f"{100 * np.median(shares):.0f} %", int(np.sum(shares < -0.02)))
        )  # fmt: skip
    each = Table(["law", "source", "verdict", "terms", "removed", "promised"])
    for r in results:
        names = ", ".join(n.removeprefix("empirical:") for n in r["offered"]) or "-"
        promised = "-" if r["promised"] is None else f"{100 * r['promised']:.0f} %"
        law = r["law"] + (" (left alone)" if r["unseen"] else "")
        each.rows.append(
            (law, r["source"], r["verdict"], f"`{names}`", f"{100 * removed(r):.0f} %", promised)
        )
    return section("Terms for what is outside the catalogue: benchmark", _text(results, asked), table, each)


def _text(results: Sequence[Outcome], asked: Sequence[Outcome]) -> str:
    offered = [
        (r["promised"], r["interval"][0], removed(r))
        for r in asked
        if r["promised"] is not None and r["interval"] is not None
    ]
    kept = sum(share >= low for _, low, share in offered)
    high = sum(promised > share + 0.1 for promised, _, share in offered)
    outside = max((r["outside"] for r in results), default=0.0)
    return (
        f"{len(results)} synthetic campaigns{' (those that were left alone)' if all(r['unseen'] for r in results) else ''} "
        "that hide a law outside the catalogue: the forms of `benchmarks/discovery`, the laws of "
        f"`benchmarks/literature`, and {len(LAWS)} further laws from physics. `diagnose` answers, `refine` adds what it names and the first "
        "of the terms that it offers, and the model predicts held-out tests. Removed: of the squared error there that a linear law "
        "leaves, less what a fit with the true form leaves. "
        f"Asked for: {100 * ASKED:.0f} % removed in {100 * ASKED_CASES:.0f} % of the cases. Cases of index 2, 5, 8 ... were left alone while "
        "the terms were changed, although their laws also stand in other cases. "
        f"Of {len(offered)} first offers, {kept} removed at least the lower end of the promised interval; {high} promised over 10 points more than "
        f"they removed. Beyond the tests, {OUTSIDE} random points for each model of empirical terms alone: it differs from its base by at most {outside:.1g}."
    )
