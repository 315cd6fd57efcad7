"""Single tests that lie far off what all others say: a wrong specimen, a slipped gauge, a mixed-up record."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...loads import FloatArray
from ..campaign.binning import Campaign
from .noise_floor import Layout, NoiseFloor, estimate
from .reference import Reference

#: Robust standard deviations from the prediction of the others beyond which a test is odd.
ODD = 4.0
#: Median of the absolute value of normal noise, and level and value of another quantile, by which the tails are judged.
MIDDLE, TAIL = 0.6745, (0.9, 1.645)
#: If more than this share of the tests is odd, it is not a matter of single tests.
MOST_ODD = 0.06
#: With fewer tests no one can say which of them is odd.
LEAST_TESTS = 12


def odd_tests(campaign: Campaign, columns: FloatArray, floor: NoiseFloor | None) -> list[str]:
    """Return the names of tests whose level no smooth dependence on loads and metadata explains.

    Parameters
    ----------
    campaign : Campaign
    columns : ndarray, shape (m, p)
        Base in the bins.
    floor : NoiseFloor or None
        Estimated here where it is not known yet.
    """
    tests = len(campaign.tests)
    if tests < LEAST_TESTS:
        return []
    y = campaign.average(campaign.mu)
    if floor is None:
        floor = estimate(campaign, Layout.of(campaign), y, columns)
    z = np.abs(Reference(campaign, floor, y).surprise(columns))
    far = as_normal(z) > ODD
    return (
        [campaign.tests[k] for k in np.flatnonzero(far)]
        if 0 < far.sum() <= max(MOST_ODD * tests, 1.0)
        else []
    )


def as_normal(z: FloatArray) -> FloatArray:
    """Return distances, in robust standard deviations, as far out in normal noise as they are among the others here.

    Tests may scatter unevenly. Their quantiles are then taken for a power of those of normal noise, which the middle and the tenth
    that lies farthest off tell: only what is odd beside those is single.

    Examples
    --------
    >>> even = np.abs(np.random.default_rng(0).normal(size=10_000))
    >>> uneven = 0.6745 * (even / 0.6745) ** 2
    >>> np.quantile(as_normal(even), 0.99).round(1), np.quantile(as_normal(uneven), 0.99).round(1)
    (np.float64(2.6), np.float64(2.6))
    """
    far = max(float(np.quantile(z, TAIL[0])) / MIDDLE, 1.0)
    power = max(np.log(far) / np.log(TAIL[1] / MIDDLE), 1.0)
    return np.asarray(MIDDLE * (z / MIDDLE) ** (1.0 / power))


def without_tests(campaign: Campaign, names: list[str]) -> Campaign:
    """Return the campaign without some tests, with a warning that names them."""
    keep: npt.NDArray[np.bool_] = ~np.isin(np.array(campaign.tests)[campaign.point_test], names)
    told = ", ".join(names[:5]) + (" ..." if len(names) > 5 else "")
    what = "one test lies" if len(names) == 1 else f"{len(names)} tests lie"
    warning = (
        f"{what} far off what all others say and was left out ({told}): look at its record"
        if len(names) == 1
        else (f"{what} far off what all others say and were left out ({told}): look at their records")
    )
    return replace(campaign.part(keep), warnings=[*campaign.warnings, warning], spikes=campaign.spikes)
