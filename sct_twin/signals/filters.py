"""Filters of measured signals: low-pass without phase shift, running means, single samples that stand out.

The low-pass is that of `scipy.signal.sosfiltfilt(butter(2, ...), ...)`, without loading `scipy.signal`, which costs
every process of a campaign 30 MB.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from friction_models.loads import FloatArray

#: Corner between the differentiated position (below) and the integrated acceleration (above) [Hz].
CORNER_HZ = 10.0
#: A low-pass needs a sampling rate of so many times its corner; below it is left out.
RATE_OVER_CORNER = 2.4
#: A sample is a spike when it stands out of its neighbourhood by so many standard deviations.
SPIKE = 10.0
#: Samples on each side that are the neighbourhood.
_REACH = 3
#: Samples over which noise is taken to be the same.
_BLOCK = 32
_PIECE = 1_000_000


def can_smooth(count: int, dt: float, corner: float) -> bool:
    """Whether a signal is sampled fast enough, and long enough, for a low-pass with this corner [Hz].

    A corner of 10 Hz needs more than 24 samples a second:

    >>> can_smooth(100, dt=0.01, corner=10.0), can_smooth(100, dt=0.05, corner=10.0)
    (True, False)
    """
    return 1.0 / dt > RATE_OVER_CORNER * corner and count >= 16


def smooth(values: FloatArray, dt: float, corner: float = CORNER_HZ) -> FloatArray:
    """Low-pass without phase shift: Butterworth of second order, forwards and backwards.

    Samples are `dt` [s] apart; at the `corner` [Hz] half of the amplitude is left. Where the rate or the number of samples
    is too low for it, the values themselves are returned.
    """
    if not can_smooth(len(values), dt, corner):
        return values
    return low_pass(values, dt, corner, min(len(values) - 1, int(0.5 / (dt * corner)) * 6))


def running_mean(values: FloatArray, width: int) -> FloatArray:
    """Return the mean over `width` samples around each, zeros beyond the ends; its cost is that of one pass.

    >>> running_mean(np.array([3.0, 3.0, 6.0, 3.0, 3.0]), 3).round(6).tolist()[1:4]
    [4.0, 4.0, 4.0]
    """
    from scipy.ndimage import uniform_filter1d  # the twin as an FMU starts without it

    return np.asarray(uniform_filter1d(values, width, mode="constant"))


def integral(values: FloatArray, dx: float | None = None, x: FloatArray | None = None) -> FloatArray:
    """Return the cumulative trapezoidal integral, 0 at the first point.

    >>> integral(np.array([1.0, 1.0, 3.0]), dx=0.5).tolist()
    [0.0, 0.5, 1.5]
    """
    steps = np.diff(x) if x is not None else np.full(len(values) - 1, 1.0 if dx is None else dx)
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * steps)])


def noise_of(values: FloatArray) -> float:
    """Return the standard deviation of white noise on a smooth signal, from its second differences.

    A straight line has no noise:

    >>> noise_of(np.arange(10.0))
    0.0
    """
    if len(values) < 5:
        return 0.0
    second = np.diff(values[: 4 * _PIECE], 2)
    return 1.4826 * float(np.median(np.abs(second))) / float(np.sqrt(6.0))


def spike_rows(values: FloatArray) -> np.ndarray:
    """Return the samples that stand out of their seven neighbours by more than `SPIKE` times the noise.

    Hampel's rule: the distance to the median of the neighbourhood against the usual noise. A step or a
    ramp has no such samples, however steep; a break-away peak of two or three samples has, see
    `signals.process`.

    >>> values = np.tile([0.0, 0.1, 0.1, 0.0], 25)
    >>> values[40] = 50.0
    >>> spike_rows(values).tolist()
    [40]
    """
    count = len(values)
    if count < 2 * _REACH + 2:
        return np.zeros(0, dtype=np.int64)
    found = []
    for start in range(0, count, _PIECE):
        low, high = max(0, start - _BLOCK), min(count, start + _PIECE + _BLOCK)
        found.append(low + _spikes(values[low:high]))
    return np.unique(np.concatenate(found))


def _spikes(values: FloatArray) -> np.ndarray:
    count = len(values)
    noise = _local_noise(values)
    # Most samples are ruled out by their steps alone; the median is taken at the others.
    edge = np.flatnonzero(np.abs(np.diff(values)) > 0.5 * SPIKE * noise[1:])
    near = edge[:, None] + np.arange(-1, _REACH)[None, :]
    rows = np.unique(near[(near >= 0) & (near < count)])
    around = np.clip(rows[:, None] + np.arange(-_REACH, _REACH + 1)[None, :], 0, count - 1)
    out = np.abs(values[rows] - np.median(values[around], axis=1)) > SPIKE * noise[rows]
    return np.asarray(rows[out])


def _local_noise(values: FloatArray) -> FloatArray:
    """Return the standard deviation of the noise at every sample: the largest of three blocks around it.

    Friction is far noisier than the unloaded cell, so that one figure for a whole test would find spikes
    all over the sliding.
    """
    from scipy.ndimage import maximum_filter1d

    count = len(values)
    second = np.abs(np.diff(values, 2))
    blocks = max(1, len(second) // _BLOCK)
    parts = second[: blocks * _BLOCK].reshape(blocks, -1)
    usual = 1.4826 / np.sqrt(6.0) * np.median(parts, axis=1)
    usual = maximum_filter1d(usual, 3, mode="nearest")
    # A signal that repeats its last reading: one step of its resolution is its noise.
    steps = np.abs(np.diff(values))
    resolution = float(steps[steps > 0.0].min()) if (steps > 0.0).any() else np.inf
    along = np.repeat(np.where(usual > 0.0, usual, resolution), _BLOCK)[:count]
    return np.concatenate([along, np.full(count - len(along), along[-1])])


def without(values: FloatArray, rows: np.ndarray) -> FloatArray:
    """Return the signal with some samples replaced by a line between the ones around them.

    >>> without(np.array([1.0, 2.0, 99.0, 4.0]), np.array([2])).tolist()
    [1.0, 2.0, 3.0, 4.0]
    """
    if not len(rows):
        return values
    good = np.ones(len(values), dtype=bool)
    good[rows] = False
    repaired = values.copy()
    repaired[rows] = np.interp(rows, np.flatnonzero(good), values[good])
    return repaired


def low_pass(values: FloatArray, dt: float, corner: float, padding: int) -> FloatArray:
    """Return samples, `dt` [s] apart, after the filter; the corner [Hz] is below half the sampling rate.

    - `padding`: samples by which the signal is continued at both ends, mirrored at its end points; below n.

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
