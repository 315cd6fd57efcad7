"""Groups of tests whose levels lie apart by what nobody recorded."""

from __future__ import annotations

from typing import TYPE_CHECKING, NotRequired, TypedDict

import numpy as np

from ...common.wording import listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...loads import FloatArray

if TYPE_CHECKING:
    from sklearn.mixture import GaussianMixture

#: Groups of tests are looked for in so many tests at least; most groups, by how much they must describe the tests better, and the least share of the tests
#: in each.
LEAST_TESTS, MOST_GROUPS, CLEARLY, LEAST_SHARE = 20, 4, 10.0, 0.1
#: Spreads of a group by which more than two of them lie apart.
APART = 4.0
NUMBERS = ("one", "two", "three", "four")


class TestGroups(TypedDict):
    """Groups of tests whose levels lie apart: the names above the widest ``gap`` between them, the number of the others."""

    note: str
    groups: NotRequired[int]  #: How many; not in files of before, when there were two.
    gap: float
    group: list[str]
    others: int


def unrecorded_factor(campaign: BinnedTests, residual: FloatArray) -> TestGroups | None:
    """Return groups of test offsets when one normal distribution does not describe them.

    One normal distribution is compared with mixtures of two to `MOST_GROUPS` of the same spread; a mixture must win by far (Bayes
    information criterion by `CLEARLY`), and each group hold at least a tenth of the tests.
    """
    tests = len(campaign.tests)
    offsets = campaign.of_tests(residual)
    if tests < LEAST_TESTS or len(np.unique(offsets)) <= MOST_GROUPS:
        return None
    values = ((offsets - offsets.mean()) / offsets.std())[:, None]
    mixtures = [_mixture(values, k) for k in range(1, MOST_GROUPS + 1)]
    worth = [mixtures[0].bic(values) - m.bic(values) if _lie_apart(m) else 0.0 for m in mixtures]
    best = int(np.argmax(worth))
    centres = np.sort(mixtures[best].means_[:, 0])
    members = np.argmin(np.abs(values - centres), axis=1)
    if worth[best] < CLEARLY or np.bincount(members, minlength=best + 1).min() < LEAST_SHARE * tests:
        return None
    levels = [float(offsets[members == k].mean()) for k in range(best + 1)]
    gaps = np.diff(levels)
    widest = int(np.argmax(gaps))
    high = [campaign.tests[k] for k in np.flatnonzero(members > widest)]
    apart = listed(f"{gap:.4f}" for gap in gaps)
    return {
        "note": f"test offsets fall into {NUMBERS[best]} groups {apart} apart; look for a factor that is not recorded",
        "groups": best + 1,
        "gap": float(gaps[widest]),
        "group": high,
        "others": tests - len(high),
    }


def _lie_apart(mixture: GaussianMixture) -> bool:
    """Return whether each of more than two groups lies far from the others: several of one spread follow any even scatter."""
    centres = np.sort(mixture.means_[:, 0])
    return (
        len(centres) < 3 or float(np.diff(centres).min()) > APART * float(mixture.covariances_[0, 0]) ** 0.5
    )


def _mixture(values: FloatArray, groups: int) -> GaussianMixture:
    """Return a mixture of normal distributions of one spread that describes values, shape (n, 1)."""
    from sklearn.mixture import GaussianMixture

    # one group needs no start
    starts = 5 if groups > 1 else 1
    return GaussianMixture(groups, covariance_type="tied", n_init=starts, random_state=0).fit(values)
