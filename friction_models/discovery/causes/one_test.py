"""Names that rest on one test: without it there would be nothing to name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...loads import FloatArray

#: Share of what a name explains beside the others that one test may hold. Of about 130 right names of another author one was above it
#: (0.46 was the next); of three that a single wrong test made up, all (0.51 to 0.80).
MOST_OF_ONE = 0.5


def resting_on_one(campaign: BinnedTests, found: SearchRound, chosen: Sequence[Fit]) -> dict[str, str]:
    """Return the test that holds most of what a name explains, for each name of which the level of one test holds more than half.

    What changes along that test in the way of the name is no matter of its level: a wrong record is off as a whole.
    """
    if len(campaign.tests) < 2 or not chosen:
        return {}
    signals = found.project(found.whiten(np.column_stack([f.binned for f in chosen])))
    resting = {}
    for k, fit in enumerate(chosen):
        by_test = _gained(campaign, found.residual, signals, k)
        most = int(np.argmax(by_test))
        if not by_test[most] > MOST_OF_ONE * by_test.sum() > 0.0:
            continue
        level = found.project(found.whiten((campaign.test == most).astype(float)))[:, None]
        freed = _gained(campaign, _beyond(found.residual, level), _beyond(signals, level), k)
        if freed[most] < MOST_OF_ONE * by_test[most]:
            resting[fit.name] = campaign.tests[most]
    return resting


def _gained(campaign: BinnedTests, residual: FloatArray, signals: FloatArray, k: int) -> FloatArray:
    """Return by how much signal `k` beside the others lowers the squares of each test, shape (tests,)."""
    gained = _beyond(residual, np.delete(signals, k, axis=1)) ** 2 - _beyond(residual, signals) ** 2
    return np.asarray(np.bincount(campaign.test, gained, len(campaign.tests)), dtype=np.float64)


def _beyond(values: FloatArray, columns: FloatArray) -> FloatArray:
    """Return what columns, shape (m, k), leave of values, shape (m, ...)."""
    if not columns.shape[1]:
        return values
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=1e-9)[0])
