"""Gaps: ranges of a load in which no test measured."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .contract import FloatArray

#: No value in this share of the range of a load is a gap.
GAP = 0.3


def gap_places(values: FloatArray) -> npt.NDArray[np.intp]:
    """Return after how many of the sorted `values`, shape (n,), each gap begins.

    Examples
    --------
    >>> gap_places(np.array([0.0, 0.1, 0.5, 1.0])).tolist()
    [2, 3]
    """
    return np.flatnonzero(np.diff(values) > GAP * (values[-1] - values[0])) + 1
