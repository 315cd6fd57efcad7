"""Single tests that lie far off what all others say: a wrong specimen, a slipped gauge, a mixed-up record."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...loads import FloatArray
from ..campaign.binning import BinnedTests
from .layout import Layout
from .noise_floor import NoiseFloor, estimate
from .reference import Reference

#: Robust standard deviations from the prediction of the others beyond which a test is odd.
ODD = 4.0
#: If more than this share of the tests is odd, it is not a matter of single tests.
MOST_ODD = 0.06
#: With fewer tests no one can say which of them is odd.
LEAST_TESTS = 12


def odd_tests(campaign: BinnedTests, columns: FloatArray, floor: NoiseFloor | None) -> list[str]:
    """Return the names of tests whose level no smooth dependence on loads and metadata explains.

    A test is not odd where the others at its setting lie off as well: so are the law, or the scatter, there. `columns`, shape
    (m, p), are the base in the bins; a floor that is not known yet is estimated here.
    """
    tests = len(campaign.tests)
    if tests < LEAST_TESTS:
        return []
    y = campaign.average(campaign.mu)
    if floor is None:
        floor = estimate(campaign, Layout.of(campaign), y, columns)
    off = Reference(campaign, floor, y).surprise(columns)
    far = np.abs(off) > ODD * np.maximum(_of_the_others(off, campaign.setting), 1.0)
    return (
        [campaign.tests[k] for k in np.flatnonzero(far)]
        if 0 < far.sum() <= max(MOST_ODD * tests, 1.0)
        else []
    )


def _of_the_others(off: FloatArray, setting: npt.NDArray[np.intp]) -> FloatArray:
    """Return the root mean square over the other tests at the setting of each test; 0 where it is alone."""
    others = np.bincount(setting)[setting] - 1
    squares = np.maximum(np.bincount(setting, off**2)[setting] - off**2, 0.0)
    return np.sqrt(np.where(others > 0, squares / np.maximum(others, 1), 0.0))


def without_tests(campaign: BinnedTests, names: list[str]) -> BinnedTests:
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
