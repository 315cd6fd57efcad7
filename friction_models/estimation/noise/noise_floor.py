"""Noise floor: what no model of the loads can explain, with a test as the unit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NotRequired, TypedDict

import numpy as np
from scipy.special import chdtri

from ...loads import FloatArray
from ..campaign.binned_tests import BinnedTests
from .floor_variances import Variances, VariancesOfFloor
from .layout import Layout, inverse_of_roots

#: Relative to the scatter of the data; keeps the covariance regular on noise-free input.
FLOOR = 1e-4
#: Enough tests for an estimate; of more, as many are taken evenly.
MOST_TESTS = 160


class RepeatsNumbers(TypedDict):
    """Scatter of tests at the same settings, with its 95 % interval."""

    settings: int
    tests: int
    scatter: float
    interval: list[float]
    p_value: float
    exact: NotRequired[bool]  #: Not in files of earlier versions.


class FloorFromLoads(TypedDict):
    """RMS of mu that the stated uncertainties of the loads give the model, in all and of each load by itself."""

    total: float
    by_load: dict[str, float]


class NoiseFloorNumbers(TypedDict):
    """A noise floor as files and reports hold it.

    ``source`` says what identifies the total: ``repeats`` of tests, a flexible ``reference`` that predicts unseen tests better
    than the model, the ``model`` that predicts them as well, or ``unknown`` where there are too few tests. ``hardly_better``
    stands where the reference predicts better than the ``model`` for certain, but by too little to count. ``shares`` are those of
    test scatter, drift and sensor in the square of an average, where they come near the total.
    """

    sensor: float
    test: float
    drift: float
    total: float
    interval: list[float]
    source: NotRequired[str]
    hardly_better: NotRequired[bool]
    shares: NotRequired[dict[str, float]]
    repeats: NotRequired[RepeatsNumbers]
    from_loads: NotRequired[FloorFromLoads]


@dataclass(frozen=True)
class NoiseFloor:
    """Standard deviations of mu that no function of the loads explains."""

    sensor: float  #: White noise of a point.
    test: float  #: Scatter between tests.
    drift: float  #: Slow drift within a test.
    drift_length: float  #: Its correlation length [mm].
    interval: tuple[float, float]  #: 95 % interval of `total`.
    #: White noise of a bin of one point as the covariance uses it (holds what points share).
    bin_sensor: float
    known: bool = True  #: Whether there were enough tests to estimate the scatter between them.

    @property
    def total(self) -> float:
        """Noise floor of a point: all three together."""
        return float(np.sqrt(self.sensor**2 + self.test**2 + self.drift**2))

    def to_dict(self) -> NoiseFloorNumbers:
        """Return what files and reports hold of it."""
        return {
            "sensor": self.sensor,
            "test": self.test,
            "drift": self.drift,
            "total": self.total,
            "interval": list(self.interval),
        }


class Whitener:
    """Turns correlated bin means into independent numbers of variance one."""

    def __init__(self, layout: Layout, floor: NoiseFloor, scale: float) -> None:
        self.layout = layout
        tiny = FLOOR * scale
        S = layout.covariance(
            np.hypot(floor.test, tiny), floor.drift, floor.drift_length, np.hypot(floor.bin_sensor, tiny)
        )
        self.inverse = inverse_of_roots(np.asarray(np.linalg.cholesky(S)))

    def isolation(self, residual: FloatArray) -> FloatArray:
        """Return how far each bin lies off what the other bins of its test predict, in standard deviations."""
        precision = np.swapaxes(self.inverse, 1, 2) @ self.inverse
        pulled = (precision @ self.layout.pad(residual[:, None]))[self.layout.test, self.layout.slot, 0]
        return pulled / np.sqrt(np.einsum("tii->ti", precision)[self.layout.test, self.layout.slot])

    def __call__(self, values: FloatArray) -> FloatArray:
        """Return whitened `values`, shape (m,) or (m, k)."""
        flat = values.reshape(len(values), -1)
        white = (self.inverse @ self.layout.pad(flat))[self.layout.test, self.layout.slot]
        return white.reshape(values.shape)


def estimate(
    campaign: BinnedTests, layout: Layout, y: FloatArray, mean: FloatArray, start: NoiseFloor | None = None
) -> NoiseFloor:
    """Estimate the noise floor by REML around a mean in the span of the columns `mean`, shape (m, p).

    `y`, shape (m,), are bin means of mu, or of a residual; an earlier estimate may be the `start`.
    """
    if len(campaign.tests) > MOST_TESTS:
        some = campaign.spread(np.arange(len(campaign.tests)), MOST_TESTS)
        layout, rows = layout.subset(some)
        y, mean = y[rows], mean[rows]
    mean = independent_columns(mean)
    residual = y - mean @ np.linalg.lstsq(mean, y, rcond=None)[0]
    variances = VariancesOfFloor(layout, y, mean, max(float(np.std(residual)), 1e-9))
    noise = sensor_noise(campaign, campaign.mu)
    earlier = Variances(start.test, start.drift, start.drift_length, start.bin_sensor) if start else None
    test, drift, length, bin_sensor = variances.most_likely(noise, earlier)
    sensor = noise if campaign.count.max() > 1 else bin_sensor
    floor = NoiseFloor(sensor, test, drift, length, (0.0, 0.0), bin_sensor, variances.known)
    return replace(floor, interval=_interval(floor, len(layout.present), mean.shape[1]))


def _interval(floor: NoiseFloor, tests: int, columns: int) -> tuple[float, float]:
    """Return a 95 % interval of the total: the scatter between tests dominates it (chi-square)."""
    between = max(tests - min(columns, tests // 3) - 1, 1)
    lower = between / float(chdtri(between, 0.025))
    upper = between / float(chdtri(between, 0.975))
    slow = floor.test**2 + floor.drift**2
    return (
        float(np.sqrt(floor.sensor**2 + slow * lower)),
        float(np.sqrt(floor.sensor**2 + slow * min(upper, 1e4))),
    )


def sensor_noise(campaign: BinnedTests, values: FloatArray) -> float:
    """Return the white noise of `values` at the points, shape (n,), from second differences (robust); low for interpolated points."""
    same = campaign.point_test
    second = np.diff(values, 2)[(same[2:] == same[:-2])]
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0)) if second.size else 0.0


def independent_columns(columns: FloatArray, tolerance: float = 1e-7) -> FloatArray:
    """Return an orthonormal basis of the column space, without directions that are numerically nothing."""
    norms = np.linalg.norm(columns, axis=0)
    u, s, _ = np.linalg.svd(columns[:, norms > 0] / norms[norms > 0], full_matrices=False)
    return u[:, s > tolerance * s[0]]
