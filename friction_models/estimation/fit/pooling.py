"""Offsets of levels that are shrunk towards zero by the scatter within and between levels (random effects)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...loads import FloatArray

#: Least and largest ratio of the scatter within levels to that between them; the least keeps the mean of the offsets at zero.
LEAST, MOST = 1e-6, 1e6


def shrinkage(values: FloatArray, member: FloatArray) -> FloatArray:
    """Return ``s^2 / (n tau^2)`` for every level: the mean of its n values is divided by one more than this.

    There is one value a test, shape (n,); `member`, shape (n, levels), is 1 where a test belongs to a level, else 0. The
    variances within and between levels, s^2 and tau^2, are those of the analysis of variance with unequal numbers (Searle,
    Casella, McCulloch: Variance Components (1992), section 3.6).

    Examples
    --------
    Two levels far apart keep their means; where levels differ by chance, nothing is left:

    >>> member = np.repeat(np.eye(2), 3, axis=0)
    >>> shrinkage(np.array([0.0, 1.0, 2.0, 10.0, 11.0, 12.0]), member).round(4).tolist()
    [0.0067, 0.0067]
    >>> shrinkage(np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0]), member).tolist()
    [1000000.0, 1000000.0]
    """
    number = member.sum(axis=0)
    some = number > 0
    tests, levels = float(number.sum()), int(some.sum())
    if levels < 2 or tests <= levels:
        return np.full(len(number), MOST)
    means = member.T @ values / np.maximum(number, 1.0)
    inside = member.sum(axis=1) > 0
    within = float(np.sum((values - member @ means)[inside] ** 2)) / (tests - levels)
    grand = float(number @ means) / tests
    between = float(number @ (means - grand) ** 2) / (levels - 1)
    size = (tests - float(number @ number) / tests) / (levels - 1)
    variance = max((between - within) / size, 0.0)
    ratio = within / np.maximum(number * variance, 1e-300)
    return np.asarray(np.where(some, np.clip(ratio, LEAST, MOST), MOST))


def by_test(values: FloatArray, count: FloatArray, test: npt.NDArray[np.intp]) -> FloatArray:
    """Return the means over tests of averages in bins, shape (m,) or (m, k).

    Examples
    --------
    >>> by_test(np.array([1.0, 2.0, 5.0]), np.ones(3), np.array([0, 0, 1])).tolist()
    [1.5, 5.0]
    """
    weight = np.bincount(test, count)
    if values.ndim == 1:
        return np.asarray(np.bincount(test, count * values) / weight)
    return np.column_stack([np.bincount(test, count * column) / weight for column in values.T])
