"""Builds the campaign of a case: tables, base model and truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.blind.bases import design, handed_over, true_base
from benchmarks.blind.campaign import Array, Campaign, generator
from benchmarks.blind.cases import WEAK, Case
from benchmarks.blind.laws import LAWS
from benchmarks.blind.noise import RECIPES
from benchmarks.blind.oracle import Oracle
from benchmarks.blind.plans import PLANS, add_metadata
from benchmarks.blind.truth import Hidden, Truth, truth_of

HEATED_PLANS = ("correlated30", "warming30")


@dataclass(frozen=True)
class Built:
    """What the laboratory hands over (`points`, `tests`, `model`), and the truth."""

    points: pd.DataFrame
    tests: pd.DataFrame
    model: Any
    truth: Truth


def _own_heat(c: Campaign, measured: Array) -> None:
    """A test with more friction heats itself more: its temperature above that of the tool follows its own level."""
    rise = c.load("T") - c.number_of_test("T_tool")
    level = pd.Series(measured).groupby(c.k).transform("mean").to_numpy(float)
    c.points["T"] = c.load("T") + np.maximum(rise, 0) * (level / measured.mean() - 1)


def build(case: Case) -> Built:
    """The tables of a case and its truth; the same on every machine."""
    rng = generator(*case.words())
    campaign = add_metadata(PLANS[case.plan](rng), case.metadata, rng)
    base = true_base(case.base, campaign, rng)
    recipe = RECIPES[case.noise]
    columns = design(case.base, campaign, base)
    oracle = Oracle.of(campaign, base, recipe, columns, generator(*case.words("oracle")))
    hidden = []
    for key, strength in case.laws:
        term = LAWS[key].term(campaign, base, rng)
        if strength <= 0:
            power = float(np.sum(oracle.project(term) ** 2))
            strength = round(float(np.sqrt((-strength or WEAK) / power)), 4)
        hidden.append(Hidden(LAWS[key], strength, strength * term))
    total = sum((h.term for h in hidden), np.zeros(len(base)))
    # The level of friction is the rig's; the laws move it about its mean. A power law has no free level: there they only add.
    shift = 0.0 if case.base == "power_law" else float(total.mean())
    mu = base + total - shift
    lift = max(0.0, 0.012 - float(mu.min()))
    if case.base in ("number", "power_law"):
        lift = 0.0
    truth = truth_of(campaign, base + lift - shift, hidden, oracle, columns)
    measured = recipe(generator(*case.words("noise")), campaign, mu + lift)
    if case.kind == "null" and case.plan in HEATED_PLANS:
        _own_heat(campaign, measured)
    truth["mu_range"] = [round(float(mu.min() + lift), 4), round(float(mu.max() + lift), 4)]
    return Built(campaign.table(measured), campaign.tests, handed_over(case.base, base), truth)
