"""Measurements that end at one value: a logger or an amplifier that reads no further."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.wording import first_names
from ...loads import FloatArray

#: Points in a row that read the same.
IN_A_ROW = 3
#: Share of all points, and times the points at any of the next values, from which on a value is where readings end: a logger that
#: rounds has many points at each of its steps.
LEAST_SHARE, TIMES, NEXT = 0.01, 10.0, 3


def about_clipping(mu: FloatArray, names: npt.NDArray[Any]) -> list[str]:
    """Return a warning for each end of mu, shape (n,), at which it was clipped; `names` are the tests of the points.

    Examples
    --------
    >>> mu = np.minimum(0.1 + 0.02 * np.sin(np.arange(60) / 5.0), 0.115)
    >>> about_clipping(mu, np.full(60, "a"))
    ['14 of 60 points read the largest mu, 0.115 (test a): clipped? friction went beyond it there, and effects look smaller than they are']
    """
    return [*_at_end(mu, names, "largest"), *_at_end(-mu, names, "smallest")]


def _at_end(mu: FloatArray, names: npt.NDArray[Any], end: str) -> list[str]:
    values, counts = np.unique(mu, return_counts=True)
    share = counts[-1] / len(mu)
    if len(values) <= NEXT or share < LEAST_SHARE or counts[-1] <= TIMES * counts[-1 - NEXT : -1].max():
        return []
    at = mu == values[-1]
    # the first of several in a row, in one test
    row = np.logical_and.reduce([at[k : len(at) - IN_A_ROW + 1 + k] for k in range(IN_A_ROW)])
    row &= names[: len(row)] == names[IN_A_ROW - 1 :]
    if not row.any():
        return []
    tests = first_names(list(dict.fromkeys(names[at].astype(str))))
    return [
        f"{counts[-1]} of {len(mu)} points read the {end} mu, {abs(values[-1]):.4g} (test {tests}): clipped? friction went beyond it "
        "there, and effects look smaller than they are"
    ]
