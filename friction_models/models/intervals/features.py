"""What the width of a prediction interval depends on: T, and the logarithms of the other loads."""

from __future__ import annotations

import numpy as np

from ...expressions.ops import NumpyOps, Ops, Value
from ...loads import LOAD_NAMES
from ..domain import Domain

#: Keep the logarithms regular at zero loads: mm/s, MPa, mm.
V_OFFSET, SIGMA_OFFSET, SD_OFFSET = 10.0, 200.0, 2.0


def feature(x: Ops, name: str, column: Value) -> Value:
    """Return what the logarithm of the width is linear in: T, and logarithms of the other loads."""
    offset = {"v_rel": V_OFFSET, "sigma_n": SIGMA_OFFSET, "sd": SD_OFFSET, "psi": 0.0}
    return column if name == "T" else x.log(column + offset[name])


def feature_ranges(domain: Domain) -> list[tuple[float, float]]:
    """Return the smallest and largest `feature` of each load in a domain."""
    x = NumpyOps()
    return [
        (float(feature(x, n, np.array(low))), float(feature(x, n, np.array(high))))
        for n, low, high in zip(LOAD_NAMES, domain.lower, domain.upper)
    ]
