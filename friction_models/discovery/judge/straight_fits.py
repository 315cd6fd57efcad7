"""Base and effects with the shapes of the scan: only their amplitudes are fitted, which is quick enough to try many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...estimation.campaign.binning import Campaign
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...loads import FloatArray
from .unseen_tests import ErrorsByTest, Mask, UnseenTests, errors_of_tests


@dataclass(frozen=True)
class StraightFits:
    """Fits of amplitudes only."""

    campaign: Campaign
    unseen: UnseenTests  #: Gives the folds.
    found: SearchRound  #: Gives the base in the bins.

    def errors(self, fits: Sequence[Fit]) -> ErrorsByTest:
        """Return the errors on unseen tests with amplitudes of the other tests."""
        fold = self.unseen.fold_of_test[self.campaign.test]
        residual = np.empty(len(self.found.y))
        for k in np.unique(fold):
            residual[fold == k] = self.residual(fits, fold != k)[fold == k]
        return errors_of_tests(self.campaign, residual)

    def residual(self, fits: Sequence[Fit], seen: Mask | None = None) -> FloatArray:
        """Return what base and effects leave in the bins, shape (m,), fitted to those seen or to all."""
        y, columns = self.found.y, self.found.columns_with(fits)
        root = np.sqrt(self.campaign.count) * (1.0 if seen is None else seen)
        return np.asarray(y - columns @ np.linalg.lstsq(root[:, None] * columns, root * y, rcond=1e-9)[0])
