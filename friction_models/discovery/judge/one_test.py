"""Names that rest on one test: without it there would be nothing to name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...estimation.campaign.binning import BinnedTests
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...loads import FloatArray

#: Share of what a name explains beside the others that one test may hold. Of about 130 right names of another author one was above it
#: (0.46 was the next); of three that a single wrong test made up, all (0.51 to 0.80).
MOST_OF_ONE = 0.5


def resting_on_one(campaign: BinnedTests, found: SearchRound, chosen: Sequence[Fit]) -> dict[str, str]:
    """Return the test that holds most of what a name explains, for each name of which one test holds more than half."""
    if len(campaign.tests) < 2 or not chosen:
        return {}
    signals = found.project(found.whiten(np.column_stack([f.binned for f in chosen])))
    all_left = _left(found, signals)
    resting = {}
    for k, fit in enumerate(chosen):
        gained = _left(found, np.delete(signals, k, axis=1)) ** 2 - all_left**2
        by_test = np.bincount(campaign.test, gained, len(campaign.tests))
        if by_test.max() > MOST_OF_ONE * by_test.sum() > 0.0:
            resting[fit.name] = campaign.tests[int(np.argmax(by_test))]
    return resting


def _left(found: SearchRound, signals: FloatArray) -> FloatArray:
    """Return what base and signals leave of mu, whitened, shape (m,)."""
    if not signals.shape[1]:
        return found.residual
    return np.asarray(found.residual - signals @ np.linalg.lstsq(signals, found.residual, rcond=1e-9)[0])
