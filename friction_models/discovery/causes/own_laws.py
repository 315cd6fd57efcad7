"""Tests of one level of a column of the test table that follow a load, or the distance, in a way of their own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.special import stdtr

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.metadata import is_text
from ...loads import FloatArray
from ...loads.splits import Mask

#: Fewest tests of a level, and of all others.
LEAST_TESTS = 5
#: Chance below which it is told, over all levels and loads that are looked at.
BY_CHANCE = 0.01


class _Line(NamedTuple):
    """A straight line that the tests follow along something."""

    along: str  #: What it is, in words.
    columns: FloatArray  #: The last one is its slope, shape (tests, k).
    values: FloatArray  #: Shape (tests,).


def with_own_laws(campaign: BinnedTests, residual: FloatArray) -> list[str]:
    """Return in words which levels of text columns have tests that follow something otherwise than all others do.

    `residual`, shape (m,), is what is left of mu in the bins. Of the loads and the distance only the one that says it most surely is named.
    """
    lines = [*_between_tests(campaign, residual), *_along_tests(campaign, residual)]
    levels = [
        (f"{name} {label}", own)
        for name in sorted(campaign.system)
        if is_text(campaign.loads, name)
        for label, own in _levels(campaign, name)
    ]
    limit = BY_CHANCE / max(len(levels) * len(lines), 1)
    surest = [
        (level, *min((_chance(line, own), k) for k, line in enumerate(lines)))
        for level, own in levels
        if lines
    ]
    return [
        f"what is left of the tests of {level} changes with {lines[k].along} otherwise than what is left of all others: they follow a law of "
        "their own, which no offset of a level is; diagnose them apart"
        for level, chance, k in surest
        if chance < limit
    ]


def _levels(campaign: BinnedTests, name: str) -> Iterator[tuple[str, Mask]]:
    """Yield the levels of a column with the tests that have them, where these and the others are enough."""
    labels = campaign.loads.context_column(name)
    codes = campaign.of_tests(campaign.metadata(name))
    for level in np.unique(codes):
        own = codes == level
        if labels is not None and LEAST_TESTS <= own.sum() <= len(own) - LEAST_TESTS:
            yield str(labels[campaign.point_starts[own][0]]), own


def _between_tests(campaign: BinnedTests, residual: FloatArray) -> Iterator[_Line]:
    """Yield the lines that the means of the tests follow along the loads that set them apart."""
    for name, load in campaign.levels.items():
        if campaign.sets_apart(name):
            z = (load - load.mean()) / max(float(load.std()), 1e-300)
            yield _Line(name, np.column_stack([np.ones(len(z)), z]), campaign.of_tests(residual))


def _along_tests(campaign: BinnedTests, residual: FloatArray) -> Iterator[_Line]:
    """Yield the mean rise along the tests, if all are records."""
    last = np.bincount(campaign.test) - 1
    if last.min() >= 2:
        share = campaign.slot / last[campaign.test]
        about = share - campaign.of_tests(share)[campaign.test]
        rise = campaign.of_tests(about * residual) / campaign.of_tests(about**2)
        yield _Line("the distance", np.ones((len(rise), 1)), rise)


def _chance(line: _Line, own: Mask) -> float:
    """Return the chance of so different slopes of some tests and of all others, each with the scatter of its own (Welch's t test)."""
    (slope, square, freedom), (other, other_square, other_freedom) = (
        _slope(line.columns[tests], line.values[tests]) for tests in (own, ~own)
    )
    both = square + other_square
    if not 0.0 < both < np.inf:
        return 1.0
    free = both**2 / (square**2 / freedom + other_square**2 / other_freedom)
    return float(2.0 * stdtr(free, -abs(slope - other) / np.sqrt(both)))


def _slope(columns: FloatArray, values: FloatArray) -> tuple[float, float, int]:
    """Return the factor of the last of some columns, its squared standard error, infinite where others say the same, and its freedom."""
    q, r = np.linalg.qr(columns)
    freedom = len(values) - columns.shape[1]
    size = abs(float(r[-1, -1]))
    if size < 1e-6 * np.linalg.norm(columns[:, -1]):
        return 0.0, np.inf, freedom
    rest = float(np.sum((values - q @ (q.T @ values)) ** 2)) / freedom
    return float(q[:, -1] @ values) / float(r[-1, -1]), rest / size**2, freedom
