"""What further tests are asked: which of some effects is there, and how probable each is before they are run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.curves import transformed
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...loads import LOAD_NAMES, FloatArray
from ...loads.splits import Mask
from .formula_error import allowance

#: Most effects that are weighed against each other, and the least weight beside the largest one.
MOST_EFFECTS, LEAST_WEIGHT = 7, 0.01
#: Weight, beside the best effect, that one has at least: not told apart by the data; the next one of the ranking; driven by a
#: load that moves with a load of the best one.
CONFUSED, NEXT, TIED = 0.3, 0.05, 0.1
#: Correlation of two loads from which on they move together.
TOGETHER = 0.8


@dataclass(frozen=True)
class Answer:
    """How probable an answer is, and each of what else may be true.

    Examples
    --------
    A name that is 90 % sure, beside another effect and "none of the catalogue":

    >>> Answer(sure=0.9, none=0.2).prior(np.array([1.0, 0.1]), np.array([True, False])).round(3).tolist()
    [0.9, 0.027, 0.073]
    """

    #: Probability that one of the names that the answer holds is right; None where it holds none.
    sure: float | None
    #: Probability that none of the catalogue is right, before those of the effects are made to agree with `sure`.
    none: float
    missing: float = 1.0  #: Probability that anything is missing at all.

    def prior(self, weight: FloatArray, held: Mask) -> FloatArray:
        """Return the probability of each effect, with weights of shape (k,), and of none of them last; those `held` are as sure as the answer."""
        prior = np.r_[(1.0 - self.none) * weight / weight.sum(), self.none]
        inside = np.r_[held, False]
        if self.sure is None or not held.any():
            return prior
        for own, share in ((inside, self.sure), (~inside, 1.0 - self.sure)):
            prior[own] *= share / prior[own].sum()
        return prior


@dataclass(frozen=True)
class Question:
    """Which of some effects is there: alternatives, of which one holds."""

    found: SearchRound  #: The search in which they were compared.
    rivals: list[Fit]  #: What tests are to tell apart, the winner first.
    held: int  #: How many of them, the first ones, the data do not tell apart.
    given: Sequence[Fit] = ()  #: Other effects that are named, and present whichever of the rivals is.


def weighed(campaign: BinnedTests, question: Question) -> tuple[list[Fit], FloatArray]:
    """Return the effects that may be true, the winner first, with their weights."""
    found, rivals = question.found, question.rivals
    if not rivals:
        return [], np.empty(0)
    first, names = rivals[0], [f.name for f in rivals]
    largest = max(f.evidence for f in rivals)
    scale = allowance(largest)
    others = [f for f in found.ranking if f.name not in names and f.gain > 0.0]
    weight = {}
    for place, fit in enumerate([*rivals, *others]):
        own = float(np.exp(np.clip(0.5 * (fit.evidence - largest) / scale, -50.0, 0.0)))
        tied = place >= question.held and _tied(campaign, first, fit)
        weight[fit.name] = max(own, CONFUSED if place < question.held else TIED if tied else 0.0)
    if len(weight) > 1:
        following = list(weight)[1]
        weight[following] = max(weight[following], NEXT)
    kept = sorted(
        (n for n in weight if weight[n] >= LEAST_WEIGHT), key=lambda n: (n != first.name, -weight[n])
    )
    by_name = {f.name: f for f in [*rivals, *others]}
    kept = kept[:MOST_EFFECTS]
    return [by_name[n] for n in kept], np.array([weight[n] for n in kept])


def _tied(campaign: BinnedTests, first: Fit, other: Fit) -> bool:
    """Return whether an effect is driven by a load that moves with that of the first one from test to test."""
    a, b = (f.effect.driver[0] for f in (first, other))
    if a == b or not {a, b} <= set(LOAD_NAMES) or not (campaign.varies(a) and campaign.varies(b)):
        return False
    levels = [campaign.of_tests(transformed(campaign, n)) for n in (a, b)]
    if min(np.ptp(x) for x in levels) <= 0.0 or len(campaign.tests) < 3:
        return False
    return bool(abs(np.atleast_2d(np.corrcoef(np.array(levels)))[0, 1]) > TOGETHER)
