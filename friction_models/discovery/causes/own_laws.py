"""Tests of one level of a column of the test table that follow a load, or the distance, in a way of their own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.special import stdtr

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.factors import texts_of
from ...estimation.campaign.metadata import is_text
from ...loads import FloatArray
from ...loads.splits import Mask

#: Fewest tests of a level, and of all others, beyond the numbers of a line.
LEAST_BEYOND = 2
#: Chance below which it is told, over all levels and loads that are looked at, also without any one of the tests of the level.
BY_CHANCE = 0.005


class OwnLaw(NamedTuple):
    """A level whose tests follow a straight line of their own."""

    column: str  #: Of the test table.
    level: str
    along: str  #: What they follow, in words.
    predicted: FloatArray  #: What the others of these tests say of each, beyond all other tests, shape (m,); 0 in other tests.


class _Line(NamedTuple):
    """A straight line that the tests follow along something."""

    along: str  #: What it is, in words.
    columns: FloatArray  #: The last one is its slope, shape (tests, k).
    values: FloatArray  #: Shape (tests,).
    course: FloatArray  #: How a value of a test changes along it, shape (m,).


def own_law(campaign: BinnedTests, residual: FloatArray) -> OwnLaw | None:
    """Return the level of a text column whose tests most surely follow something otherwise than all others do; None without any.

    `residual`, shape (m,), is what is left of mu in the bins. Pooled offsets have a level for each batch, and no slope: a coating
    that fails when hot, or late, changes both.
    """
    lines = [*_between_tests(campaign, residual), *_along_tests(campaign, residual)]
    sides = [
        (name, level, own, line)
        for name in sorted(campaign.system)
        if is_text(campaign.loads, name)
        for level, own in _levels(campaign, name)
        for line in lines
        if min(own.sum(), (~own).sum()) >= line.columns.shape[1] + LEAST_BEYOND
    ]
    chances = [_chance(line, own) for _, _, own, line in sides]
    if not chances or min(chances) >= BY_CHANCE / len(chances):
        return None
    name, level, own, line = sides[int(np.argmin(chances))]
    predicted = np.zeros(len(own))
    predicted[own] = _by_others(line.columns[own], line.values[own])
    return OwnLaw(name, level, line.along, predicted[campaign.test] * line.course)


def _levels(campaign: BinnedTests, name: str) -> Iterator[tuple[str, Mask]]:
    """Yield the levels of a column with the tests that have them."""
    labels = texts_of(campaign, name)
    codes = campaign.of_tests(campaign.metadata(name))
    for level in np.unique(codes):
        own = codes == level
        yield str(labels[int(np.argmax(own))]), own


def _between_tests(campaign: BinnedTests, residual: FloatArray) -> Iterator[_Line]:
    """Yield the lines that the means of the tests follow along the loads that set them apart."""
    for name, load in campaign.levels.items():
        if campaign.sets_apart(name):
            z = (load - load.mean()) / max(float(load.std()), 1e-300)
            columns = np.column_stack([np.ones(len(z)), z])
            yield _Line(name, columns, campaign.of_tests(residual), np.ones(len(residual)))


def _along_tests(campaign: BinnedTests, residual: FloatArray) -> Iterator[_Line]:
    """Yield the mean rise along the tests, if all are records."""
    last = np.bincount(campaign.test) - 1
    if last.min() >= 2:
        share = campaign.slot / last[campaign.test]
        about = share - campaign.of_tests(share)[campaign.test]
        rise = campaign.of_tests(about * residual) / campaign.of_tests(about**2)
        yield _Line("the distance", np.ones((len(rise), 1)), rise, about)


def _chance(line: _Line, own: Mask) -> float:
    """Return the chance of the slope that some tests have beyond that of all others, the largest without any one of them."""
    columns = np.column_stack([line.columns, own[:, None] * line.columns])
    chance = _p_value(columns, line.values)
    if chance < BY_CHANCE:
        others = (np.delete(np.arange(len(own)), k) for k in np.flatnonzero(own))
        chance = max(chance, *(_p_value(columns[rows], line.values[rows]) for rows in others))
    return chance


def _p_value(columns: FloatArray, values: FloatArray) -> float:
    """Return the two-sided p-value of the last of some columns (t test); 1 where the others say the same."""
    q, r = np.linalg.qr(columns)
    if abs(r[-1, -1]) < 1e-6 * np.linalg.norm(columns[:, -1]):
        return 1.0
    freedom = len(values) - columns.shape[1]
    rest = float(values @ values - np.sum((q.T @ values) ** 2)) / freedom
    return float(2.0 * stdtr(freedom, -abs(float(q[:, -1] @ values)) / np.sqrt(max(rest, 1e-300))))


def _by_others(columns: FloatArray, values: FloatArray) -> FloatArray:
    """Return what a line through all others says of each value, shape (tests,)."""
    q = np.linalg.qr(columns)[0]
    leverage = np.minimum(np.sum(q**2, axis=1), 1.0 - 1e-9)
    return np.asarray(values - (values - q @ (q.T @ values)) / (1.0 - leverage))
