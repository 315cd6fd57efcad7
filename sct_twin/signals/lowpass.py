"""Butterworth low-pass of second order, run forwards and backwards: no phase shift.

The same filter as `scipy.signal.sosfiltfilt(butter(2, ...), ...)`, without loading `scipy.signal`, which
costs every process of a campaign 30 MB.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from friction_models.loads import FloatArray


def low_pass(values: FloatArray, dt: float, corner: float, padding: int) -> FloatArray:
    """Return equally spaced samples after the filter.

    - `values`, shape (n,): samples.
    - `dt`: step [s].
    - `corner`: frequency at which half of the amplitude is left [Hz], below half the sampling rate.
    - `padding`: samples by which the signal is continued at both ends, mirrored at its end points; below n.

    Examples
    --------
    A constant signal stays as it is:

    >>> low_pass(np.full(50, 3.0), dt=0.001, corner=50.0, padding=20)[[0, 25, 49]].round(6).tolist()
    [3.0, 3.0, 3.0]
    """
    k = math.tan(math.pi * corner * dt)
    scale = 1.0 / (1.0 + math.sqrt(2.0) * k + k * k)
    a1, a2 = 2.0 * (k * k - 1.0) * scale, (1.0 - math.sqrt(2.0) * k + k * k) * scale
    x = np.asarray(values, dtype=np.float64)
    before = 2.0 * x[0] - x[padding:0:-1]
    after = 2.0 * x[-1] - x[-2 : -padding - 2 : -1]
    y = np.concatenate([before, x, after])
    _section(y, k * k * scale, a1, a2)
    _section(y[::-1], k * k * scale, a1, a2)
    return y[padding : padding + len(x)].copy()


@njit(cache=True)
def _section(y: FloatArray, b: float, a1: float, a2: float) -> None:
    """Filter in place with (b, 2 b, b) over (1, a1, a2), from the state that a constant signal leaves."""
    s2 = (b - a2) * y[0]
    s1 = (2.0 * b - a1) * y[0] + s2
    for i in range(y.shape[0]):
        x = y[i]
        out = b * x + s1
        s1 = 2.0 * b * x - a1 * out + s2
        s2 = b * x - a2 * out
        y[i] = out
