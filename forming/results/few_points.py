"""When too few points touch a tool for means over the contact to be trusted."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

#: Points in contact, on average over the steps with contact, below which means over them are not to be trusted.
FEWEST = 10


def few_points(active: npt.NDArray[np.bool_]) -> str:
    """Return a sentence where so few points touch a tool that means over them say little; else an empty text.

    `active`, shape (n, n_points): points in contact at each step. Steps in which no point touches do not count.

    >>> few_points(np.arange(80) < np.array([[6], [8]]))[:58]
    'Only 7 of 80 points touch a tool, on average over the run:'
    >>> few_points(np.ones((2, 80), dtype=bool))
    ''
    """
    touching = active.sum(axis=1)
    if not touching.any():
        return ""
    count = float(touching[touching > 0].mean())
    if count >= FEWEST:
        return ""
    return (
        f"Only {count:.2g} of {active.shape[1]} points touch a tool, on average over the run: medians, means and stated errors "
        f"over so few are not to be trusted (at least {FEWEST}: a longer stroke, or more points)."
    )
