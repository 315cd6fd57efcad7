"""Metadata that sets tests apart, found before the noise is judged: scatter between tests must not hold what the test table explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import fdtrc

from ...loads import FloatArray
from ..campaign.binned_tests import BinnedTests
from ..noise.noise_floor import independent_columns
from .base_law import BaseLaw
from .candidates import Candidate
from .search_round import flexible_mean
from .unseen_loads import driven_by_load

#: Level of all F tests of one step together.
LEVEL = 0.01
#: Most columns of metadata that are taken, one after the other.
MOST = 2
#: Tests that must be left beside all columns.
SPARE = 4
#: Tests that a flexible mean must leave to stand in the place of the base.
FLEXIBLE = 10


def metadata_that_sets_tests_apart(
    campaign: BinnedTests, base: BaseLaw, candidates: Sequence[Candidate], known: FloatArray | None = None
) -> FloatArray:
    """Return columns in the bins of effects of metadata that explain levels of tests beside a flexible mean, shape (m, k).

    So do columns that are `known` by now, shape (m, j).

    F tests of mean friction of whole tests, stepwise, at a Bonferroni level (Draper, Smith: Applied Regression Analysis
    (1998), chapter 6). Each level of a column, or shape of an effect, counts as a test, and so do all levels together. Where a
    flexible mean would leave few tests, the base stands in its place.
    """
    effects = [c for c in candidates if not driven_by_load(c.effect)]
    system = [c.columns[:, k] for c in effects for k in range(c.columns.shape[1])]
    system += [c.columns[:, :, 0] for c in effects if c.columns.shape[1] > 1]
    apart = np.empty((len(campaign.starts), 0))
    if not system:
        return apart
    named = apart if known is None else known
    y = campaign.of_tests(campaign.average(campaign.mu - base.offset))
    mean = _levels_of(campaign, flexible_mean(campaign, base.columns), named)
    if len(y) - mean.shape[1] < FLEXIBLE:
        mean = _levels_of(campaign, campaign.average(base.columns), named)
    for _ in range(MOST):
        best: tuple[float, FloatArray] | None = None
        for columns in system:
            p = chance_beside(y, mean, _of_tests(campaign, columns))
            if p < LEVEL / len(system) and (best is None or p < best[0]):
                best = p, columns
        if best is None:
            break
        apart = np.column_stack([apart, best[1]])
        mean = independent_columns(np.column_stack([mean, _of_tests(campaign, best[1])]))
    return apart


def _levels_of(campaign: BinnedTests, *columns: FloatArray) -> FloatArray:
    """Return what columns in the bins say of the level of each test, without what they say twice."""
    return independent_columns(_of_tests(campaign, np.column_stack(columns)))


def _of_tests(campaign: BinnedTests, columns: FloatArray) -> FloatArray:
    return np.column_stack([campaign.of_tests(c) for c in columns.T])


def chance_beside(y: FloatArray, mean: FloatArray, columns: FloatArray, spare: int = SPARE) -> float:
    """Return the p-value of the F test of columns, shape (tests, k), beside a mean in orthonormal columns, shape (tests, p).

    It is 1 where fewer than `spare` tests are left.
    """
    whole = independent_columns(np.column_stack([mean, columns]))
    more, left = whole.shape[1] - mean.shape[1], len(y) - whole.shape[1]
    if more < 1 or left < spare:
        return 1.0
    without, beside = (float(np.sum((y - q @ (q.T @ y)) ** 2)) for q in (mean, whole))
    ratio = max(without - beside, 0.0) / more / max(beside / left, 1e-300)
    return float(fdtrc(more, left, ratio))
