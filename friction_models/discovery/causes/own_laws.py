"""Tests of one level of a column of the test table that follow a load, or the distance, in a way of their own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import stdtr

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.metadata import is_text
from ...loads import FloatArray

#: Fewest tests of a level, and of all others.
LEAST_TESTS = 5
#: Least chance at which it is told, over all levels and loads that are looked at, also without any one of the tests of the level.
BY_CHANCE = 0.001


def with_own_laws(campaign: BinnedTests, residual: FloatArray) -> list[str]:
    """Return for each level of a text column whose tests follow something otherwise than all others what it is, in words.

    `residual`, shape (m,), is what is left of mu in the bins. Of the loads and the distance, the one that tells most for certain stands
    for all. Pooled offsets have a level for each batch, and no slope: a coating that fails when hot, or late, changes both.
    """
    sides = [
        (name, level, own)
        for name in sorted(campaign.system)
        if is_text(campaign.loads, name)
        for level, own in _levels(campaign, name)
    ]
    looks = [*_looks(campaign, residual)]
    limit = BY_CHANCE / max(len(sides) * len(looks), 1)
    found = []
    for name, level, own in sides:
        chances = [_chance(beside, value, along, own) for _, beside, along, value in looks]
        least = int(np.argmin(chances)) if chances else 0
        if chances and chances[least] < limit:
            said, _, _, _ = looks[least]
            found.append(
                f"what is left of the tests of {name} {level} changes with {said} otherwise than what is left of all others: they follow a law of "
                "their own, which no offset of a level is; diagnose them apart"
            )
    return found


def _levels(campaign: BinnedTests, name: str) -> Iterator[tuple[Any, npt.NDArray[np.bool_]]]:
    """Yield the levels of a column with the tests that have them, where these and the others are enough."""
    labels = campaign.loads.context_column(name)
    for level in np.unique(codes := campaign.of_tests(campaign.metadata(name))):
        own = codes == level
        if LEAST_TESTS <= own.sum() <= len(own) - LEAST_TESTS and labels is not None:
            yield labels[campaign.point_starts[own][0]], own


def _looks(
    campaign: BinnedTests, residual: FloatArray
) -> Iterator[tuple[str, FloatArray, FloatArray, FloatArray]]:
    """Yield what friction may follow: its name, what is the same for all tests, what may have another factor in some, and their values."""
    one, level = np.ones(len(campaign.tests)), campaign.of_tests(residual)
    for name, load in campaign.levels.items():
        if campaign.sets_apart(name):
            x = (load - load.mean()) / max(float(load.std()), 1e-300)
            yield name, np.column_stack([one, x]), x, level
    last = np.bincount(campaign.test) - 1
    if last.min() >= 2:
        share = campaign.slot / last[campaign.test]
        along = share - campaign.of_tests(share)[campaign.test]
        rise = campaign.of_tests(along * residual) / campaign.of_tests(along**2)
        yield "the distance", one[:, None], one, rise


def _chance(beside: FloatArray, value: FloatArray, along: FloatArray, own: npt.NDArray[np.bool_]) -> float:
    """Return the chance of a factor of their own that `own` tests have, the largest without any one of them."""
    mark = own.astype(float)
    columns = np.column_stack([beside, mark, mark * along] if np.ptp(along) > 0.0 else [beside, mark])
    whole = _p_value(columns, value)
    if whole >= BY_CHANCE:
        return whole
    without = (np.delete(np.arange(len(value)), k) for k in np.flatnonzero(own))
    return max(whole, *(_p_value(columns[rows], value[rows]) for rows in without))


def _p_value(columns: FloatArray, value: FloatArray) -> float:
    """Return the two-sided p-value of the last of some columns (t test); 1 where the others say the same."""
    q, r = np.linalg.qr(columns)
    if abs(r[-1, -1]) < 1e-6 * np.linalg.norm(columns[:, -1]):
        return 1.0
    size = float(q[:, -1] @ value)
    freedom = len(value) - columns.shape[1]
    rest = float(value @ value - np.sum((q.T @ value) ** 2)) / freedom
    return float(2.0 * stdtr(freedom, -abs(size) / np.sqrt(max(rest, 1e-300))))
