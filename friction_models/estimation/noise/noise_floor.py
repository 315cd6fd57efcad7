"""Noise floor: what no model of the loads can explain, with a test as the unit.

The covariance of the bin means of one test is ``s_b^2 1 1' + s_d^2 exp(-|dsd|/l) + diag(s_w^2/n)``: an offset
of the test (specimen, lubricant), a slow drift along it, and sensor noise. Restricted maximum likelihood
around a flexible mean (Patterson, Thompson, Biometrika 58 (1971)).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NotRequired, TypedDict

import numpy as np
from scipy.optimize import minimize
from scipy.special import chdtri

from ...loads import FloatArray
from ..campaign.binning import BinnedTests
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
    stands where the reference predicts better than the ``model`` for certain, but by too little to count.
    """

    sensor: float
    test: float
    drift: float
    total: float
    interval: list[float]
    source: NotRequired[str]
    hardly_better: NotRequired[bool]
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
        some = np.unique(np.linspace(0, len(campaign.tests) - 1, MOST_TESTS).astype(int))
        layout, rows = layout.subset(some)
        y, mean = y[rows], mean[rows]
    mean = independent_columns(mean)
    residual = y - mean @ np.linalg.lstsq(mean, y, rcond=None)[0]
    scale = max(float(np.std(residual)), 1e-9)
    tests = len(layout.present)
    known = tests >= 3
    length = float(np.median([g[p].max() for g, p in zip(layout.gaps, layout.present, strict=True)]))
    stacked = layout.pad(np.column_stack([y, mean]))
    many = layout.shape[1] > 2

    index = np.arange(layout.shape[1])
    both = np.where(layout.present[:, :, None] & layout.present[:, None, :], 1.0, 0.0)
    gaps = both * layout.gaps / max(length, 1e-9)
    apart = np.where(both > 0.0, gaps, np.inf)
    # New memory for large arrays takes longer than what is computed in them.
    slow, S, whitening, P = (np.zeros_like(both) for _ in range(4))

    def criterion(theta: FloatArray) -> tuple[float, FloatArray]:
        """Return minus the restricted log-likelihood and its gradient."""
        s_b, s_d, relative, s_w = np.exp(np.clip(theta, -16.0, 6.0)) * [scale, scale, 1.0, scale]
        if not known:
            s_b = 1e-4 * scale
        if not many:
            s_d = 0.0
        np.multiply(apart, -1.0 / relative, out=slow)
        np.exp(slow, out=slow)
        np.multiply(slow, s_d**2, out=slow)
        np.multiply(both, s_b**2, out=S)
        np.add(S, slow, out=S)
        diagonal = np.where(layout.present, s_w**2 * layout.weight, 1.0)
        S[:, index, index] += diagonal
        nothing = np.zeros(4)
        try:
            root = np.linalg.cholesky(S)
            inverse_of_roots(root, whitening)
            np.matmul(np.swapaxes(whitening, 1, 2), whitening, out=P)
            solved = P @ stacked
            gram = np.tensordot(stacked, solved, ((0, 1), (0, 1)))
            inner = np.linalg.cholesky(gram[1:, 1:])
        except np.linalg.LinAlgError:
            return 1e12, nothing
        covariance = np.linalg.inv(gram[1:, 1:])
        along = covariance @ gram[1:, 0]
        rest = float(gram[0, 0] - gram[1:, 0] @ along)
        log_det = 2.0 * np.sum(np.log(np.einsum("tii->ti", root)))
        ratio = np.log(relative / 0.15)
        prior = 0.05 * ratio**2  # keeps the length finite where there is no drift
        value = 0.5 * (log_det + rest) + np.sum(np.log(np.diag(inner))) + prior
        # d/dS of the criterion is (P - P y y' P)/2 with P = S^-1 - S^-1 X (X' S^-1 X)^-1 X' S^-1
        towards = solved[:, :, 1:]
        left = solved[:, :, 0] - towards @ along
        by_mean = np.concatenate([towards @ covariance, left[:, :, None]], axis=2)
        np.matmul(by_mean, np.swapaxes(np.concatenate([towards, left[:, :, None]], axis=2), 1, 2), out=S)
        np.subtract(P, S, out=P)
        np.multiply(slow, gaps, out=S)
        by_slow = float(np.vdot(P, slow))
        gradient = np.array(
            [
                s_b**2 * float(np.vdot(P, both)) if known else 0.0,
                by_slow,
                0.5 * float(np.vdot(P, S)) / relative + 0.1 * ratio,
                float(np.sum(np.einsum("tii->ti", P) * np.where(layout.present, diagonal, 0.0))),
            ]
        )
        return float(value), gradient

    within = np.log(max(sensor_noise(campaign, campaign.mu) / scale, 0.02))
    begin = np.array([np.log(0.8), np.log(0.3), np.log(0.15), within])
    if start is not None:
        known_sizes = np.array([start.test, start.drift, 0.0, start.bin_sensor]) / scale
        known_sizes[2] = start.drift_length / max(length, 1e-9)
        begin = np.log(np.maximum(known_sizes, 1e-3))
    bounds = [(-9, 3), (-9, 3), (-4, 2), (-7, 4)]
    low, high = np.array(bounds, dtype=float).T
    best = minimize(
        criterion,
        np.clip(begin, low, high),
        jac=True,
        method="L-BFGS-B",
        bounds=bounds,
        options={"maxiter": 60, "ftol": 1e-6},
    )
    s_b, s_d, relative, s_w = np.exp(best.x) * np.array([scale, scale, 1.0, scale])
    s_b, s_d = (s_b if known else 0.0), (s_d if many else 0.0)
    sensor = sensor_noise(campaign, campaign.mu) if campaign.count.max() > 1 else s_w
    floor = NoiseFloor(
        float(sensor),
        float(s_b),
        float(s_d),
        float(relative * max(length, 1e-9)),
        (0.0, 0.0),
        float(s_w),
        known,
    )
    return replace(floor, interval=_interval(floor, tests, mean.shape[1]))


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
