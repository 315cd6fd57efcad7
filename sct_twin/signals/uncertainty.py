"""Uncertainty of friction: noise inside a point, correlated noise, zeros of the force cells."""

from __future__ import annotations

import numpy as np

from friction_models.loads import FloatArray

from .filters import running_mean

#: What changes over a longer distance counts as friction, what changes within it as noise [mm]; but as
#: noise in any case what changes within four samples.
LONGEST_NOISE = 0.5
_SHORTEST_LAGS = 4
#: Lags at which differences are compared [samples].
_LAGS = (1, 2, 4, 8, 16)


def noise_memory(values: FloatArray, longest: int) -> tuple[float, float]:
    """Return variance and correlation from sample to sample of the noise on a slowly changing signal.

    The mean square of ``x[i+k] - 2 x[i] + x[i-k]``, over six, is ``g0 - 4/3 gk + 1/3 g2k`` with the
    autocovariances g of the noise; lines drop out. White noise gives g0 at every lag. Noise that
    remembers gives less at short lags; the rise gives the correlation of an autoregressive process of
    first order.

    - `longest`: largest lag [samples] at which what changes still counts as noise.
    """
    squares = []
    for lag in _LAGS:
        if lag > max(longest, _SHORTEST_LAGS) or len(values) < 6 * lag + 4:
            break
        second = values[2 * lag :] - 2.0 * values[lag:-lag] + values[: -2 * lag]
        usual = 1.4826 * float(np.median(np.abs(second)))
        limit = 4.0 * usual if usual > 0.0 else float(np.abs(second).max())
        # A break-away or a step of the speed is not noise.
        squares.append(float(np.mean(np.minimum(second * second, limit * limit))) / 6.0)
    if not squares or max(squares) <= 0.0:
        return 0.0, 0.0
    found = np.array(squares)
    if found[0] > 0.85 * found.max():
        return float(found[0]), 0.0
    lags = np.array(_LAGS[: len(found)])
    best = (np.inf, 0.0, 0.0)
    for correlation in np.arange(0.02, 0.97, 0.02):
        shape = 1.0 - 4.0 / 3.0 * correlation**lags + correlation ** (2 * lags) / 3.0
        variance = float(found @ shape / (shape @ shape))
        best = min(best, (float(np.sum((found - variance * shape) ** 2)), variance, float(correlation)))
    return best[1], best[2]


def excess(count: FloatArray, correlation: float) -> FloatArray:
    """Return the variance of a mean over `count` samples, relative to samples without memory.

    Of an autoregressive process of first order with correlation r:
    ``(1 + r)/(1 - r) - 2 r (1 - r^n) / (n (1 - r)^2)``, 1 at n = 1.

    Samples without memory add nothing; with a correlation of 0.5 a long mean has three times the variance:

    >>> excess(np.array([100.0]), 0.0).tolist()
    [1.0]
    >>> excess(np.array([1e9]), 0.5).round(6).tolist()
    [3.0]
    """
    n, r = np.maximum(count, 1.0), correlation
    return np.asarray((1.0 + r) / (1.0 - r) - 2.0 * r * (1.0 - r**n) / (n * (1.0 - r) ** 2))


def mean_std(values: FloatArray) -> float:
    """Return the standard uncertainty of the median of a signal at rest, memory of its noise included."""
    if len(values) < 2:
        return 0.0
    spread = values - np.median(values)
    usual = 1.4826 * float(np.median(np.abs(spread)))
    centred = np.clip(spread, -4.0 * usual, 4.0 * usual) if usual > 0.0 else spread
    variance = float(np.mean(centred * centred))
    if variance == 0.0:
        return 0.0
    total, count = 1.0, len(centred)
    for lag in range(1, min(50, count // 4)):
        correlation = float(np.mean(centred[lag:] * centred[:-lag])) / variance
        # The first correlations are those of the noise; what is within their own scatter is not counted.
        if correlation < 2.0 / np.sqrt(count):
            break
        total += 2.0 * correlation
    # The median of normal noise scatters 1.25 times as much as the mean.
    return 1.2533 * float(np.sqrt(variance * total / count))


def local_variance(values: FloatArray, variance: float, steady: slice) -> FloatArray:
    """Return the variance of the noise along a signal, with the given mean over `steady`: pressure may change."""
    count = len(values)
    if count < 60 or variance == 0.0 or steady.stop - steady.start < 10:
        return np.full(count, variance)
    second = np.diff(values, 2)
    limit = 4.0 * 1.4826 * float(np.median(np.abs(second[steady])))
    square = np.pad(np.minimum(second * second, limit * limit), 1, mode="edge")
    width = max(50, count // 4)
    ones = running_mean(np.ones(count), width)
    along = running_mean(square, width) / ones
    mean = float(along[steady].mean())
    return along * (variance / mean) if mean > 0.0 else np.full(count, variance)
