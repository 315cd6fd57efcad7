"""A test with more friction than others heats itself more: its contact temperature carries its own offset.

Where the temperature of a contact follows from the other loads and from friction itself, tests that ran hotter than their
loads let expect are tests of higher friction. A law of temperature, or a free curve along it, would take that for an effect.
"""

from __future__ import annotations

import numpy as np

from ...loads import FloatArray
from ...loads.contract import QUANTITIES
from .binned_tests import BinnedTests
from .curves import transformed

#: Share of the variance of the logarithm of the heating that the other loads must explain: else it was set, not caused.
CAUSED = 0.8
#: Tests for each number that is fitted, at least.
TESTS_A_NUMBER = 3
#: Heating below this share of the median one counts as this share.
LEAST_HEATING = 0.02
#: Share of the longest distance that counts as the start of a test.
START = 0.01
#: Temperatures of the table of tests from which the heating starts.
STARTS = ("T_tool", "T_specimen")


def without_own_heat(campaign: BinnedTests) -> BinnedTests:
    """Return the campaign with the temperatures that tests of usual friction would have had.

    The heating in each bin is scaled to what loads and distance let expect. Where the temperature was not measured, does not
    follow from them, or tests are too few, the campaign is returned as it is.
    """
    found = _usual_heating(campaign)
    if found is None:
        return campaign
    start, factor = found
    # the factor of a bin acts in its middle: between the middles it runs straight, so that no step appears
    middle = campaign.average(np.arange(len(campaign.mu), dtype=float))
    points = np.arange(len(campaign.mu), dtype=float)
    own = np.empty(len(points))
    for test, (a, b) in enumerate(
        zip(campaign.point_starts, np.r_[campaign.point_starts[1:], len(points)], strict=True)
    ):
        bins = campaign.test == test
        own[a:b] = np.interp(points[a:b], middle[bins], factor[bins])
    begin = start[campaign.point_test]
    T = begin + (campaign.loads.T - begin) * own
    limits = QUANTITIES["T"]
    if np.any((limits.lower > T) | (limits.upper < T)):
        return campaign  # what a test starts from is not what its table says
    return campaign.with_load("T", T)


def _usual_heating(campaign: BinnedTests) -> tuple[FloatArray, FloatArray] | None:
    """Return for each test where its heating starts [degC], and for each bin the factor that makes it that of usual friction."""
    if "T" in campaign.absent or not campaign.varies("T"):
        return None
    T = campaign.average(campaign.loads.T)
    known = [campaign.system[n][campaign.point_starts, 0] for n in STARTS if n in campaign.system]
    start = np.mean(known, axis=0) if known else T[campaign.first_bins]
    heating = T - start[campaign.test]
    middle = float(np.median(heating))
    if not middle > 0.0:
        return None
    heating = np.maximum(heating, LEAST_HEATING * middle)
    loads = [transformed(campaign, n) for n in ("v_rel", "sigma_n", "psi") if campaign.varies(n)]
    distance = campaign.average(campaign.distance)
    along = np.log(distance + START * max(float(distance.max()), 1e-9))
    causes = [along, *loads, *(k[campaign.test] for k in known)]
    varied = [(c - c.mean()) / c.std() for c in causes if c.std() > 1e-6 * max(1e-12, float(np.abs(c).max()))]
    if len(campaign.tests) < TESTS_A_NUMBER * (1 + len(varied)) or not varied:
        return None
    # heating is nearly a product of powers; distance, speed and pressure may bend it
    columns = [np.ones(len(heating)), *varied]
    bent = varied[:3]
    if len(campaign.tests) >= TESTS_A_NUMBER * (1 + len(varied) + 6):
        columns += [a * b for k, a in enumerate(bent) for b in bent[: k + 1]]
    # a sensor or a tool off by some K matters less, the more a test heats
    weight = heating * campaign.count
    root = np.sqrt(weight)
    matrix, target = np.column_stack(columns), np.log(heating)
    rest = target - matrix @ np.linalg.lstsq(root[:, None] * matrix, root * target, rcond=1e-9)[0]
    around = target - np.average(target, weights=weight)
    if np.average(rest**2, weights=weight) > (1.0 - CAUSED) * np.average(around**2, weights=weight):
        return None
    return start, np.exp(-np.clip(rest, -1.0, 1.0))
