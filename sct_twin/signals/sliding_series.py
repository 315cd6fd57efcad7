"""Friction at equal distances of sliding, with its standard uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from .sliding_phase import TestSignals
from .uncertainty import LONGEST_NOISE, excess, local_variance, noise_memory

#: Part of the distance over which noise is judged.
STEADY = (0.15, 0.9)


@dataclass(frozen=True, eq=False)
class SlidingSeries:
    """Friction at equal distances of sliding; all arrays of shape (n,)."""

    #: Time since sliding began [s], distance [mm] and speed [mm/s] of sliding.
    t: FloatArray
    sd: FloatArray
    v_rel: FloatArray
    #: Normal force and friction force [N].
    F_n: FloatArray
    friction: FloatArray
    #: Standard uncertainty of mu from noise: independent from point to point where a point holds samples of
    #: its own.
    noise_std: FloatArray
    #: Standard uncertainty of mu that all points of the test share: zeros of the cells, and what is stated
    #: about the cells.
    common_std: FloatArray

    @property
    def mu(self) -> FloatArray:
        """Coefficient of friction, never negative."""
        return np.maximum(self.friction / self.F_n, 0.0)

    @property
    def mu_std(self) -> FloatArray:
        """Standard uncertainty of mu: noise inside the point and what the whole test shares."""
        return np.hypot(self.noise_std, self.common_std)


class Bins:
    """Means over equal distances of a signal that is sampled at distances x, straight lines between.

    A point at distance g stands for g +- spacing/2, whether that holds one sample in fifty or a part of
    the way between two samples.

    - `x`, shape (n,): distances of the samples, increasing [mm].
    - `count`: number of points, the first at `spacing` [mm].
    """

    def __init__(self, x: FloatArray, spacing: float, count: int) -> None:
        self.count = count
        edges = spacing * (np.arange(count + 1) + 0.5)
        inner = x[(x > edges[0]) & (x < edges[-1])]
        nodes = np.sort(np.concatenate([edges, inner]))
        low, high = nodes[:-1], nodes[1:]
        middle = 0.5 * (low + high)
        self.sample = np.clip(np.searchsorted(x, middle, side="right") - 1, 0, len(x) - 2)
        self.bin = np.clip(np.searchsorted(edges, middle, side="right") - 1, 0, count - 1)
        share = (high - low) / spacing
        self.right = share * (middle - x[self.sample]) / (x[self.sample + 1] - x[self.sample])
        self.left = share - self.right

    def mean(self, values: FloatArray) -> FloatArray:
        """Return the mean of a signal in every bin."""
        parts = self.left * values[self.sample] + self.right * values[self.sample + 1]
        return np.asarray(np.bincount(self.bin, parts, self.count), dtype=np.float64)

    def variance(self, variance: FloatArray) -> FloatArray:
        """Return the variance of every mean, for independent samples of the given variances."""
        i, left, right = self.sample, self.left, self.right
        parts = left**2 * variance[i] + right**2 * variance[i + 1]
        # Inside a bin a sample ends one straight line and begins the next: its weights add up.
        joined = (self.bin[1:] == self.bin[:-1]) & (i[1:] == i[:-1] + 1)
        parts[1:] += np.where(joined, 2.0 * right[:-1] * left[1:] * variance[i[1:]], 0.0)
        return np.asarray(np.bincount(self.bin, parts, self.count), dtype=np.float64)


def resample(signals: TestSignals, spacing: float = 0.1) -> SlidingSeries:
    """Average speed and forces over equal distances of sliding, one point every `spacing` mm.

    Raises InputError: less than ten points of sliding.
    """
    start = signals.slide_start
    sd = signals.sd[start:]
    last = float(sd[-1])
    count = int(np.floor(last / spacing - 0.5 + 1e-9))
    if count < 10:
        raise InputError(f"the test slides {last:g} mm; allowed: at least {10.5 * spacing:g} mm")
    moving = np.concatenate([[True], np.diff(sd) > 1e-9])
    x = sd[moving]

    def sliding(values: FloatArray) -> FloatArray:
        return np.asarray(values[start:][moving])

    bins = Bins(x, spacing, count)
    F_n, friction = sliding(signals.F_n), sliding(signals.friction)
    normal, force = bins.mean(F_n), bins.mean(friction)
    mu = friction / np.where(np.abs(F_n) > 1e-9, F_n, 1e-9)
    # Friction breaks away at the start and the plate may stop at the end: noise is judged between.
    steady = slice(*np.searchsorted(x, (STEADY[0] * last, STEADY[1] * last)))
    usual = float(np.median(np.diff(x[steady]))) if steady.stop - steady.start > 2 else spacing
    variance, correlation = noise_memory(mu[steady], int(LONGEST_NOISE / max(usual, 1e-9)))
    along = local_variance(mu, variance, steady)
    inside = spacing / np.maximum(bins.mean(np.gradient(x)), 1e-12)
    noise = np.sqrt(bins.variance(along) * excess(inside, correlation))
    u_n, u_r = bins.mean(sliding(signals.F_n_std)), bins.mean(sliding(signals.friction_std))
    grid: FloatArray = (spacing * np.arange(1, count + 1)).astype(np.float64)
    return SlidingSeries(
        np.interp(grid, x, sliding(signals.t - signals.t[start])),
        grid,
        bins.mean(sliding(signals.v)),
        normal,
        force,
        noise,
        np.hypot(u_r, force / normal * u_n) / np.abs(normal),
    )
