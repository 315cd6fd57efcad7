"""A test with more friction than others heats itself more: its contact temperature carries its own offset.

Where the temperature of a contact follows from the other loads and from friction itself, tests that ran hotter than their
loads let expect are tests of higher friction. A law of temperature, or a free curve along it, would take that for an effect.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..loads import FloatArray
from .binning import Campaign
from .curves import transformed

#: Share of the variance of the logarithm of the heating that the other loads must explain: else it was set, not caused.
CAUSED = 0.8
#: Tests for each number that is fitted, at least.
TESTS_A_NUMBER = 1.5
#: Heating below this share of the median one counts as this share.
LEAST_HEATING = 0.02
#: Temperatures of the table of tests from which the heating starts.
STARTS = ("T_tool", "T_specimen")


def without_own_heat(campaign: Campaign) -> Campaign:
    """Return the campaign with the temperatures that tests of usual friction would have had.

    The heating of each test is scaled to what its loads let expect; how it runs along the test stays. Where the
    temperature was not measured, does not follow from the other loads, or tests are too few, the campaign is returned as it is.

    Parameters
    ----------
    campaign : Campaign
    """
    factor = _factors(campaign)
    if factor is None:
        return campaign
    start, scale = (np.repeat(v, np.bincount(campaign.point_test)) for v in factor)
    T = start + (campaign.loads.T - start) * scale
    return replace(campaign, loads=replace(campaign.loads, T=T), integrated={}, smooth=None)


def _factors(campaign: Campaign) -> tuple[FloatArray, FloatArray] | None:
    """Return for each test where its heating starts [degC], and the factor that makes it that of usual friction."""
    if "T" in campaign.absent or not campaign.varies("T"):
        return None
    weight = np.bincount(campaign.test, campaign.count)

    def level(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(campaign.test, campaign.count * values) / weight)

    binned = campaign.average(campaign.loads.T)
    first = np.flatnonzero(np.r_[True, np.diff(campaign.test) > 0])
    known = [campaign.system[n][campaign.starts[first], 0] for n in STARTS if n in campaign.system]
    start = np.mean(known, axis=0) if known else binned[first]
    heating = level(binned) - start
    middle = float(np.median(heating))
    if not middle > 0.0:
        return None
    heating = np.maximum(heating, LEAST_HEATING * middle)
    causes = [level(transformed(campaign, n)) for n in ("v_rel", "sigma_n", "psi") if campaign.varies(n)]
    causes += known
    varied = [(c - c.mean()) / c.std() for c in causes if c.std() > 1e-6 * max(1e-12, float(np.abs(c).max()))]
    columns = [np.ones(len(heating)), *varied, *(c**2 for c in varied)]
    columns += [a * b for k, a in enumerate(varied) for b in varied[:k]]
    if len(heating) < TESTS_A_NUMBER * len(columns):
        columns = columns[: 1 + len(varied)]
    if len(heating) < TESTS_A_NUMBER * len(columns) or not varied:
        return None
    # a sensor or a tool off by some K matters less, the more a test heats
    root = np.sqrt(heating)
    matrix, target = np.column_stack(columns), np.log(heating)
    rest = target - matrix @ np.linalg.lstsq(root[:, None] * matrix, root * target, rcond=1e-9)[0]
    around = target - np.average(target, weights=heating)
    if np.average(rest**2, weights=heating) > (1.0 - CAUSED) * np.average(around**2, weights=heating):
        return None
    return start, np.exp(-rest)
