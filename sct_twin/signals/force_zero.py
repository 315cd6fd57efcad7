"""Readings of the force cells without load, before and after a test."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from friction_models.loads import FloatArray

from .motion import Motion
from .uncertainty import mean_std

#: A zero is the median of so many samples at least.
MIN_SAMPLES = 5
#: Samples before the detected load that already may be under load.
_MARGIN = 10
#: Load that counts as none, over the largest.
_FREE = 0.02


@dataclass(frozen=True, eq=False)
class ForceZero:
    """The zero of one cell."""

    #: Unloaded reading before the load (0 where there is none) and after the test [N].
    before: float
    after: float | None
    #: Zero and its standard uncertainty at every sample [N], shape (n,).
    values: FloatArray
    std: FloatArray
    #: Change of the zero [N/s]: between both ends, or over the unloaded samples there are.
    drift: float | None


@dataclass(frozen=True, eq=False)
class Zeros:
    """The zeros of both cells, and the unloaded samples before the load."""

    F_n: ForceZero
    F_r: ForceZero
    rows_before: np.ndarray


def force_zeros(
    t: FloatArray,
    F_n: FloatArray,
    F_r: FloatArray,
    motion: Motion,
    load_start: int,
    end: int,
    stated: bool = False,
) -> Zeros:
    """Return the zeros of both cells, linear in time where both ends of the test are seen.

    - `t`, `F_n`, `F_r`, shape (n,): time [s] and readings [N].
    - `motion`: says when the plate stands: a plate that is driven back needs a force.
    - `load_start`, `end`: first sample under load, first sample after sliding.
    - `stated`: whether the start of the load is stated and needs no margin.
    """
    before = np.arange(max(0, load_start - (0 if stated else _MARGIN)))
    if len(before) < MIN_SAMPLES:
        before = before[:0]
    base = float(np.median(F_n[before])) if len(before) else float(F_n.min())
    after = np.arange(end, len(F_n))
    free = np.abs(F_n[after] - base) < _FREE * (float(F_n[:end].max()) - base)
    # What is unloaded to the end of the record; the first samples of it still spring back.
    first = len(free) - int(np.argmin(free[::-1])) if not free.all() else 0
    after = after[min(len(after), first + _MARGIN) :]
    after = after[motion.standing()[after]] if len(after) else after
    if len(after) < MIN_SAMPLES:
        after = after[:0]
    return Zeros(_zero(t, F_n, before, after), _zero(t, F_r, before, after), before)


def drift(t: FloatArray, values: FloatArray, rows: np.ndarray) -> float | None:
    """Return the slope of the unloaded signal [1/s], from a line through its samples; None if too few."""
    if len(rows) < 20:
        return None
    time = t[rows] - t[rows].mean()
    return float((time @ (values[rows] - values[rows].mean())) / (time @ time))


def _zero(t: FloatArray, values: FloatArray, before: np.ndarray, after: np.ndarray) -> ForceZero:
    count = len(t)
    first = float(np.median(values[before])) if len(before) else 0.0
    std = mean_std(values[before]) if len(before) else 0.0
    if not len(after):
        slope = drift(t, values, before)
        return ForceZero(first, None, np.full(count, first), np.full(count, std), slope)
    last, last_std = float(np.median(values[after])), mean_std(values[after])
    if not len(before):
        slope = drift(t, values, after)
        return ForceZero(0.0, last, np.full(count, last), np.full(count, last_std), slope)
    begin, close = float(t[before].mean()), float(t[after].mean())
    share = np.clip((t - begin) / (close - begin), 0.0, 1.0)
    return ForceZero(
        first,
        last,
        first + share * (last - first),
        np.hypot((1.0 - share) * std, share * last_std),
        (last - first) / (close - begin),
    )
