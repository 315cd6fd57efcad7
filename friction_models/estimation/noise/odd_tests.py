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
    far = np.abs(Reference(campaign, floor, y).surprise(columns)) > ODD
    return (
        [campaign.tests[k] for k in np.flatnonzero(far)]
        if 0 < far.sum() <= max(MOST_ODD * tests, 1.0)
        else []
    )


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
