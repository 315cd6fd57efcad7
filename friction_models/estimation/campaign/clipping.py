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
    """Return a warning for each end of mu, shape (n,), at which it was clipped, or that it never changes; `names` are the tests of the points.

    Examples
    --------
    >>> mu = np.minimum(0.1 + 0.02 * np.sin(np.arange(60) / 5.0), 0.115)
    >>> about_clipping(mu, np.full(60, "a"))
    ['14 of 60 points read the largest mu, 0.115 (test a): clipped? friction went beyond it there, and effects look smaller than they are']
    >>> about_clipping(np.full(60, 0.1), np.full(60, "a"))
    ['mu is 0.1 at all 60 points: measured friction scatters; was the sensor connected?']
    """
    if len(mu) >= IN_A_ROW and mu.min() == mu.max():
        return [
            f"mu is {mu[0]:.4g} at all {len(mu)} points: measured friction scatters; was the sensor connected?"
        ]
    said = []
    for end, sign in (("largest", 1.0), ("smallest", -1.0)):
        at = _at_end(sign * mu, names)
        if at.any():
            tests = first_names(list(dict.fromkeys(names[at].astype(str))))
            said.append(
                f"{at.sum()} of {len(mu)} points read the {end} mu, {abs(mu[at][0]):.4g} (test {tests}): clipped? friction went beyond it "
                "there, and effects look smaller than they are"
            )
    return said


def clipped_share(mu: FloatArray, names: npt.NDArray[Any]) -> float:
    """Return the share of the points at which mu was clipped.

    Examples
    --------
    >>> clipped_share(np.minimum(0.1 + 0.02 * np.sin(np.arange(60) / 5.0), 0.115), np.zeros(60))
    0.23333333333333334
    """
    return float(np.mean(_at_end(mu, names) | _at_end(-mu, names)))


def _at_end(mu: FloatArray, names: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Return at which points readings end at their largest value; nowhere where they do not."""
    values, counts = np.unique(mu, return_counts=True)
    nowhere = np.zeros(len(mu), dtype=bool)
    few = counts[-1] < LEAST_SHARE * len(mu) or len(values) <= NEXT
    if few or counts[-1] <= TIMES * counts[-1 - NEXT : -1].max():
        return nowhere
    at = mu == values[-1]
    # the first of several in a row, in one test
    row = np.logical_and.reduce([at[k : len(at) - IN_A_ROW + 1 + k] for k in range(IN_A_ROW)])
    row &= names[: len(row)] == names[IN_A_ROW - 1 :]
    return np.asarray(at) if row.any() else nowhere
