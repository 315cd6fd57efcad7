"""Cosines of what goes through a known number of periods at most; graphs draw them with the functions of `Ops` alone."""

from __future__ import annotations

from math import factorial, pi

import numpy as np

from .ops import Ops, Value

#: Coefficients of sin(2 pi w) over w, w^3, w^5 ...; beyond them less than 1e-15 is missing at w = 1/4.
_SINE = tuple((-1.0) ** k * (2.0 * pi) ** (2 * k + 1) / factorial(2 * k + 1) for k in range(11))


def cosine(x: Ops, turns: Value, most: int) -> Value:
    """Return cos(2 pi turns), where `turns` is between -most and most (64 or less); beyond it is no cosine.

    A cosine is even and repeats. Where a graph is drawn, the argument is folded and a polynomial follows: no back end needs a
    function of its own.

    Examples
    --------
    >>> import numpy as np
    >>> from friction_models.expressions.ops import NumpyOps
    >>> cosine(NumpyOps(), np.array([0.0, -0.25, 0.5, 7.0, 7.6]), most=8).round(12).tolist()
    [1.0, 0.0, -1.0, 1.0, -0.809016994375]
    """
    if isinstance(turns, np.ndarray):
        return np.cos(2.0 * pi * turns)
    folded, reach = x.abs(turns), 1
    while reach < most:
        reach *= 2
    while reach > 1:  # whole periods are taken off
        reach //= 2
        folded = x.abs(folded - float(reach))
    w = x.abs(folded - 0.5) - 0.25
    square, value = w * w, _SINE[-1]
    for c in reversed(_SINE[:-1]):
        value = value * square + c
    return w * value
