"""Gaps between the levels of a plan over which only the formula of an effect says how friction changes."""

from __future__ import annotations

from typing import NamedTuple

from ..campaign.binned_tests import BinnedTests
from ..campaign.gaps import Gap, gaps_of
from .parameters import FittedTerms


class OpenGap(NamedTuple):
    """A gap in a load that drives an effect, and by how much the effect changes over it.

    The effect is empty where nothing is missing: the model alone says how friction changes there.
    """

    effect: str
    gap: Gap
    change: float


def open_gaps(campaign: BinnedTests, fitted: FittedTerms) -> list[OpenGap]:
    """Return the gaps over which fitted effects change much, by effect and load, from low to high."""
    return [
        OpenGap(term.name, gap, change)
        for term in fitted.terms
        for name in dict.fromkeys(term.effect.driver)
        for gap in gaps_of(campaign, name)
        if (change := gap.change(campaign, term.binned)) > 0.0
    ]
