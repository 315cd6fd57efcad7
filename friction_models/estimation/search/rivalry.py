"""How surely tests prefer one set of effects to another, when no formula need be quite right.

In a test where two fits predict alike neither can lead; where they predict differently, the fit that is true leads by the square of
the difference, on average. How far the leads lie from that, test by test, tells how far both formulas are off, in units of the noise.
That is the test of Vuong (Econometrica 57 (1989) 307), for tests that do not tell equally much: one test that parts the rivals as far
as they predict decides, and many that part them by chance do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...loads import FloatArray
from ..campaign.binned_tests import BinnedTests
from .scan import Fit, Projector
from .search_round import SearchRound


@dataclass(frozen=True)
class Rivalry:
    """Leads of the first of two sets of effects over the second, in units of the variance of the noise.

    Examples
    --------
    Fifteen tests in which the rivals predict nearly alike, and one that was made to part them:

    >>> decided = Rivalry(np.r_[np.full(15, -0.1), 60.0], np.r_[np.full(15, 0.1), 64.0])
    >>> decided.overdispersion, round(decided.certainty, 1)
    (1.0, 3.6)

    The same lead where formulas are wrong by more than the tests part them:

    >>> undecided = Rivalry(np.r_[np.full(8, 70.0), np.full(8, -62.5)], np.full(16, 4.0))
    >>> round(undecided.certainty, 1)
    0.2
    """

    #: By how much the first leaves a smaller sum of squares in the tests of each setting, shape (settings,).
    lead: FloatArray
    #: What its lead would be on average if it were true: the square of the difference of the two predictions. Shape (settings,).
    expected: FloatArray

    @property
    def overdispersion(self) -> float:
        """Variance of the leads around those expected, beside that of the noise; at least 1."""
        noise = 4.0 * float(np.sum(self.expected))
        return max(1.0, float(np.sum((self.lead - self.expected) ** 2)) / max(noise, 1e-300))

    @property
    def certainty(self) -> float:
        """By how many standard errors the first leads."""
        spread = np.sqrt(self.overdispersion * 4.0 * float(np.sum(self.expected)))
        return float(np.sum(self.lead) / max(float(spread), 1e-150))


def rivalry(campaign: BinnedTests, found: SearchRound, some: Sequence[Fit], others: Sequence[Fit]) -> Rivalry:
    """Compare two sets of effects, fitted beside the base with the shapes of the search, on all tests."""
    y = found.whiten(found.y)
    first, second = (Projector(found.whiten(found.columns_with(fits)))(y) for fits in (some, others))
    setting = campaign.setting[campaign.test]
    lead, expected = (
        np.asarray(np.bincount(setting, values), dtype=float)
        for values in (second**2 - first**2, (second - first) ** 2)
    )
    return Rivalry(lead, expected)
