"""Repeats of tests beside names: settings may differ by more than their repeats do, whatever a model of the loads predicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.noise.repeats import Repeats, repeats_of
from ...estimation.search.scan import Fit
from .beside_reference import effects_of
from .confirmation import EXPLAINED
from .error_budget import ErrorShares
from .naming.straight_fits import StraightFits
from .unseen_tests import UnseenTests

#: This share of the squared error must lie between the settings for the verdict to say that they differ by more than their repeats.
BEYOND_REPEATS = 0.25


class BesideRepeats:
    """What repeats say of a budget, beside names."""

    def __init__(self, campaign: BinnedTests, unseen: UnseenTests, straight: StraightFits) -> None:
        self.campaign, self.unseen, self.straight = campaign, unseen, straight

    def budget(self, kept: Sequence[Fit], shares: ErrorShares) -> tuple[ErrorShares, Repeats | None]:
        """Return the budget, in which repeats say what can be predicted if settings differ by more, and their scatter."""
        repeats = self._repeats(kept)
        if repeats is not None and repeats.lacks_fit:
            low, high = repeats.interval
            shares = replace(shares, best=min(shares.best, repeats.scatter**2), interval=(low**2, high**2))
        return shares, repeats

    def _repeats(self, kept: Sequence[Fit]) -> Repeats | None:
        """Return the scatter of repeats, and whether settings differ by more than that beside what is named."""
        seed = self.unseen.seed
        repeats = repeats_of(self.campaign, self.straight.residual(kept), seed)
        if not kept or repeats is None or not repeats.lacks_fit:
            return repeats
        # the shapes of the scan lie on a grid: what they leave, a fit of the shapes may not
        fitted = self.unseen.fitted(effects_of(kept))
        return repeats_of(self.campaign, fitted.residual, seed)


def beyond_repeats(verdict: str, shares: ErrorShares) -> str:
    """Return the verdict where settings differ by more than their repeats: no model of what was recorded need predict that."""
    if verdict == "nothing_missing" and shares.missing > BEYOND_REPEATS * shares.base:
        return "unknown_structure"
    return "partly_explained" if verdict == "explained" and shares.left > EXPLAINED else verdict
