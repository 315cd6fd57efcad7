"""What is missing, as unseen tests show it, and the terms that may be tried for it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.noise.noise_floor import Whitener
from ...loads import FloatArray
from ..judge.unseen_tests import UnseenTests
from .bins import Bins
from .grammar import terms
from .selection import Selection, select

#: Fewest tests from which terms are chosen.
LEAST_TESTS = 8


@dataclass
class Missing:
    """What is missing, as unseen tests show it."""

    campaign: BinnedTests  #: As it was searched.
    columns: FloatArray  #: The model and what is named, in the bins, shape (m, p).
    y: FloatArray  #: Bin means of mu without the fixed part of the model, shape (m,).
    whiten: Whitener
    unseen: UnseenTests  #: Give the folds.
    #: Mean squared error of each unseen test of the model with what is named, shape (tests,).
    before: FloatArray
    seed: int = 0
    sloping: bool = False  #: Whether the model has no slopes, so that terms keep theirs.

    @cached_property
    def bins(self) -> Bins:
        """Bin means of the loads and of what terms are added to."""
        return Bins(self.campaign, self.columns, self.y)

    @cached_property
    def selection(self) -> Selection | None:
        """Terms of the grammar that predict unseen tests better; None where none does, or of too few tests. It takes seconds."""
        return self._selected(0.0)

    def stable_selection(self, share: float) -> Selection | None:
        """Return the terms if each of them comes first in this share of the resamples; None where one does not."""
        found = self._selected(share)
        if found is None or min(found.stability) < share:
            return None
        self.selection = found
        return found

    def _selected(self, least_stable: float) -> Selection | None:
        if len(self.before) < LEAST_TESTS:
            return None
        tried = terms(tuple(self.campaign.varied), self.sloping, self.bins.logarithms)
        found = select(self.bins, self.whiten, self.unseen.fold_of_test, tried, self.seed, least_stable)
        return found if found.all.chosen else None
