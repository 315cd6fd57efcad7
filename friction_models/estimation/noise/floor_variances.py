"""How large the parts of the noise are: restricted maximum likelihood around a flexible mean (Patterson, Thompson, Biometrika 58 (1971)).

The covariance of the bin means of one test is ``s_b^2 1 1' + s_d^2 exp(-|dsd|/l) + diag(s_w^2/n)``: an offset of the test (specimen,
lubricant), a slow drift along it, and sensor noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import expit, logit

from ...loads import FloatArray
from .layout import Layout, inverse_of_roots
from .newton import UNSOLVED, Likelihood, most_likely

#: Natural logarithms of the least and largest: scatter of tests, drift, and noise of a bin of one point, over the scatter of what
#: the mean leaves; between them, the length of the drift over that of a test.
LEAST = np.array([-9.0, -9.0, -4.0, -7.0])
LARGEST = np.array([3.0, 3.0, 2.0, 4.0])
#: Where the search starts: both standard deviations, and the length. The noise of the bins is seen in the points.
USUAL = (0.8, 0.3, 0.15)
#: From smaller parts the search would not come back: their slope is nothing.
LEAST_START, LEAST_NOISE = 0.05, 0.002
#: One over the variance of the logarithm of the length, which is about its usual value where little is said of it: a drift that is
#: longer than its test is an offset.
LENGTH_PRIOR = 1.0
#: First and largest step between the limits (logits), and the slope at which the search ends.
STEPS, LEAST_SLOPE = (0.5, 2.0), 0.2


class Variances(NamedTuple):
    """Standard deviations of mu, and the correlation length of the drift [mm]."""

    test: float
    drift: float
    length: float
    bin_sensor: float  #: Of a bin of one point.


class _Solved(NamedTuple):
    """What variances leave of mu, and what it takes to move them."""

    sizes: Variances
    white: FloatArray  #: Variances of the bins by themselves, 0 where there is none, shape (tests, slots).
    #: Change of the covariance with the logarithm of the length, shape (tests, slots, slots).
    by_length: FloatArray
    #: Columns of the mean, weighed by the inverse of the covariance, shape (tests, slots, p).
    towards: FloatArray
    covariance: FloatArray  #: Of the coefficients of the mean, shape (p, p).
    left: FloatArray  #: What the mean leaves of mu, weighed, shape (tests, slots, 1).


class VariancesOfFloor:
    """Finds the variances of bin means `y`, shape (m,), around a mean in the span of the columns `mean`, shape (m, p).

    `scale` is the standard deviation of what the mean leaves. Of fewer than three tests the scatter between them is nothing.
    """

    def __init__(self, layout: Layout, y: FloatArray, mean: FloatArray, scale: float) -> None:
        self._layout, self._scale = layout, scale
        self.known = len(layout.present) >= 3
        self._drifts = layout.shape[1] > 2
        longest = [float(g[p].max()) for g, p in zip(layout.gaps, layout.present, strict=True)]
        self._length = max(float(np.median(longest)), 1e-9)
        self._stacked = layout.pad(np.column_stack([y, mean]))
        self._both = np.where(layout.present[:, :, None] & layout.present[:, None, :], 1.0, 0.0)
        self._gaps = self._both * layout.gaps / self._length
        self._apart = np.where(self._both > 0.0, self._gaps, np.inf)
        # New memory for large arrays takes longer than what is computed in them.
        self._slow, self._S, self._roots, self._P = (np.zeros_like(self._both) for _ in range(4))

    def most_likely(self, noise: float, earlier: Variances | None = None) -> Variances:
        """Return the variances, from those of an `earlier` estimate, or from the `noise` of a bin of one point."""
        least = [LEAST_START, LEAST_START, 0.0, LEAST_NOISE]
        if earlier is None:
            start = np.array([*USUAL, noise / self._scale])
        else:
            start = np.array(earlier) / [self._scale, self._scale, self._length, self._scale]
        start = np.maximum(start, least)
        share = (np.log(start) - LEAST) / (LARGEST - LEAST)
        found = most_likely(self._at, logit(np.clip(share, 0.02, 0.98)), STEPS, LEAST_SLOPE)
        return self._sizes(found)

    def _sizes(self, theta: FloatArray) -> Variances:
        test, drift, length, sensor = np.exp(LEAST + (LARGEST - LEAST) * expit(theta))
        return Variances(
            float(test) * self._scale if self.known else 0.0,
            float(drift) * self._scale if self._drifts else 0.0,
            float(length) * self._length,
            float(sensor) * self._scale,
        )

    def _at(self, theta: FloatArray) -> Likelihood:
        """Return minus the restricted log-likelihood of variances between their limits, with that of the prior."""
        sizes = self._sizes(theta)
        relative = sizes.length / self._length
        white = self._covariance(sizes, relative)
        try:
            root = np.linalg.cholesky(self._S)
            inverse_of_roots(root, self._roots)
            np.matmul(np.swapaxes(self._roots, 1, 2), self._roots, out=self._P)
            solved = self._P @ self._stacked
            gram = np.tensordot(self._stacked, solved, ((0, 1), (0, 1)))
            inner = np.linalg.cholesky(gram[1:, 1:])
        except np.linalg.LinAlgError:
            return Likelihood(UNSOLVED, np.zeros(4), lambda: np.eye(4))
        covariance = np.asarray(np.linalg.inv(gram[1:, 1:]), dtype=np.float64)
        along = covariance @ gram[1:, 0]
        rest = float(gram[0, 0] - gram[1:, 0] @ along)
        log_det = 2.0 * np.sum(np.log(np.einsum("tii->ti", root)))
        ratio = float(np.log(relative / USUAL[2]))
        value = 0.5 * (log_det + rest + LENGTH_PRIOR * ratio**2) + np.sum(np.log(np.diag(inner)))
        towards = solved[:, :, 1:]
        left = (solved[:, :, 0] - towards @ along)[:, :, None]
        solution = _Solved(sizes, white, self._gaps * self._slow / relative, towards, covariance, left)
        # before the slope, which overwrites the inverse
        curvature, slope = self._information(solution), self._slope(solution)
        curvature[2, 2] += LENGTH_PRIOR
        slope[2] += LENGTH_PRIOR * ratio
        share = expit(theta)
        inner_slope = (LARGEST - LEAST) * share * (1.0 - share)
        curvature *= inner_slope[:, None] * inner_slope
        return Likelihood(float(value), slope * inner_slope, lambda: curvature)

    def _covariance(self, sizes: Variances, relative: float) -> FloatArray:
        """Write the covariance of every test, and its slow part; return the variances of the bins by themselves, shape (tests, slots)."""
        layout, slow, S = self._layout, self._slow, self._S
        np.multiply(self._apart, -1.0 / relative, out=slow)
        np.exp(slow, out=slow)
        np.multiply(slow, sizes.drift**2, out=slow)
        # of two tests, too little for what it is: their covariance must stay regular
        np.multiply(self._both, max(sizes.test, 1e-4 * self._scale) ** 2, out=S)
        np.add(S, slow, out=S)
        white: FloatArray = np.where(layout.present, sizes.bin_sensor**2 * layout.weight, 0.0)
        index = np.arange(S.shape[1])
        S[:, index, index] += np.where(layout.present, white, 1.0)
        return white

    def _information(self, at: _Solved) -> FloatArray:
        """Return the average of expected and observed curvature (Gilmour, Thompson, Cullis, Biometrics 51 (1995) 1440)."""
        # what each logarithm of a size changes in the covariance, times what is left of mu
        changed = np.concatenate(
            [
                2.0 * at.sizes.test**2 * (self._both @ at.left),
                2.0 * (self._slow @ at.left),
                at.by_length @ at.left,
                2.0 * at.white[:, :, None] * at.left,
            ],
            axis=2,
        )
        by_mean = np.tensordot(at.towards, changed, ((0, 1), (0, 1)))
        found = np.tensordot(changed, self._P @ changed, ((0, 1), (0, 1)))
        return np.asarray(0.5 * (found - by_mean.T @ at.covariance @ by_mean))

    def _slope(self, at: _Solved) -> FloatArray:
        """Return the gradient; the inverse of the covariance is lost."""
        P = self._P
        # d/dS of the criterion is (P - P y y' P)/2 with P = S^-1 - S^-1 X (X' S^-1 X)^-1 X' S^-1
        weighed = np.concatenate([at.towards @ at.covariance, at.left], axis=2)
        np.matmul(weighed, np.swapaxes(np.concatenate([at.towards, at.left], axis=2), 1, 2), out=self._S)
        np.subtract(P, self._S, out=P)
        return np.array(
            [
                at.sizes.test**2 * float(np.vdot(P, self._both)),
                float(np.vdot(P, self._slow)),
                0.5 * float(np.vdot(P, at.by_length)),
                float(np.sum(np.einsum("tii->ti", P) * at.white)),
            ]
        )
