"""How large the parts of the noise are: restricted maximum likelihood around a flexible mean (Patterson, Thompson, Biometrika 58 (1971)).

The covariance of the bin means of one test is ``s_b^2 1 1' + s_d^2 exp(-|dsd|/l) + diag(s_w^2/n)``: an offset of the test (specimen,
lubricant), a slow drift along it, and sensor noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import expit, logit

from ...loads import FloatArray
from .drift_and_noise import DriftAndNoise
from .layout import Layout
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
STEPS, LEAST_SLOPE = (0.5, 2.0), 1.0


class Variances(NamedTuple):
    """Standard deviations of mu, and the correlation length of the drift [mm]."""

    test: float
    drift: float
    length: float
    bin_sensor: float  #: Of a bin of one point.


class _Solved(NamedTuple):
    """What variances leave of mu, and what it takes to move them."""

    sizes: Variances
    white: FloatArray  #: Variances of the bins by themselves, shape (m,).
    slow: DriftAndNoise  #: What changes within tests.
    ones: FloatArray  #: Ones, weighed by the inverse of the covariance within tests, shape (m, 1).
    #: What the inverse of the covariance of each test loses by its offset, shape (tests, 1).
    taken: FloatArray
    #: Columns of the mean, weighed by the inverse of the covariance, and made such that their coefficients are independent,
    #: each with a variance of one, shape (m, p).
    towards: FloatArray
    left: FloatArray  #: What the mean leaves of mu, weighed, shape (m, 1).


class VariancesOfFloor:
    """Finds the variances of bin means `y`, shape (m,), around a mean in the span of the columns `mean`, shape (m, p).

    `scale` is the standard deviation of what the mean leaves. Of fewer than three tests the scatter between them is nothing.
    """

    def __init__(self, layout: Layout, y: FloatArray, mean: FloatArray, scale: float) -> None:
        self._scale = scale
        self.known = len(layout.present) >= 3
        self._drifts = layout.shape[1] > 2
        longest = [float(g[p].max()) for g, p in zip(layout.gaps, layout.present, strict=True)]
        self._length = max(float(np.median(longest)), 1e-9)
        self._columns = np.column_stack([y, mean])
        self._test, slot = layout.test, layout.slot
        next_test = np.diff(self._test) > 0
        self._starts = np.flatnonzero(np.r_[True, next_test])
        gaps = layout.gaps[self._test[:-1], slot[:-1], slot[1:]] / self._length
        self._steps = np.where(next_test, np.inf, gaps)
        self._weight = layout.weight[self._test, slot]

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
        sizes, share = self._sizes(theta), expit(theta)
        ratio = float(np.log(sizes.length / self._length / USUAL[2]))
        inner_slope = (LARGEST - LEAST) * share * (1.0 - share)
        try:
            value, at = self._solved(sizes)
        except np.linalg.LinAlgError:
            return Likelihood(UNSOLVED, np.zeros(4), lambda: np.eye(4))
        slope = self._slope(at)
        slope[2] += LENGTH_PRIOR * ratio

        def curvature() -> FloatArray:
            found = self._information(at)
            found[2, 2] += LENGTH_PRIOR
            return found * inner_slope[:, None] * inner_slope

        return Likelihood(value + 0.5 * LENGTH_PRIOR * ratio**2, slope * inner_slope, curvature)

    def _solved(self, sizes: Variances) -> tuple[float, _Solved]:
        """Return minus the restricted log-likelihood of variances, and what it takes to move them."""
        white = sizes.bin_sensor**2 * self._weight
        slow = DriftAndNoise(self._steps * (self._length / sizes.length), sizes.drift, white)
        weighed = slow.solve(np.column_stack([np.ones(len(white)), self._columns]))
        ones, within = weighed[:, :1], weighed[:, 1:]
        offset, size = self._offset(sizes), self._by_test(ones)
        taken = offset / (1.0 + offset * size)
        solved = self._beside_offsets(within, ones, taken)
        gram = self._columns.T @ solved
        inner = np.linalg.cholesky(gram[1:, 1:])
        towards = solve_triangular(inner, solved[:, 1:].T, lower=True, check_finite=False).T
        along = solve_triangular(inner, gram[1:, 0], lower=True, check_finite=False)
        left = (solved[:, 0] - towards @ along)[:, None]
        rest = float(gram[0, 0] - along @ along)
        log_det = slow.log_det + float(np.sum(np.log1p(offset * size)))
        value = 0.5 * (log_det + rest) + float(np.sum(np.log(np.diag(inner))))
        return value, _Solved(sizes, white, slow, ones, taken, towards, left)

    def _offset(self, sizes: Variances) -> float:
        """Return the variance of the offsets: of two tests, too little for what it is, as their covariance must stay regular."""
        return max(sizes.test, 1e-4 * self._scale) ** 2

    def _by_test(self, values: FloatArray) -> FloatArray:
        """Return the sums of columns over the bins of each test, shape (tests, k)."""
        return np.asarray(np.add.reduceat(values, self._starts, axis=0))

    def _beside_offsets(self, within: FloatArray, ones: FloatArray, taken: FloatArray) -> FloatArray:
        """Return columns, shape (m, k), weighed by the inverse of the covariance, from what it is `within` tests (Sherman, Morrison)."""
        return np.asarray(within - ones * (taken * self._by_test(within))[self._test])

    def _information(self, at: _Solved) -> FloatArray:
        """Return the average of expected and observed curvature (Gilmour, Thompson, Cullis, Biometrics 51 (1995) 1440)."""
        sizes, slow = at.sizes, at.slow
        along = slow.correlated(at.left)
        # what each logarithm of a size changes in the covariance, times what is left of mu
        changed = np.column_stack(
            [
                2.0 * sizes.test**2 * self._by_test(at.left)[self._test],
                2.0 * sizes.drift**2 * along,
                sizes.drift**2 * slow.correlated(slow.changed(along)),
                2.0 * at.white[:, None] * at.left,
            ]
        )
        by_mean = at.towards.T @ changed
        found = changed.T @ self._beside_offsets(slow.solve(changed), at.ones, at.taken)
        return np.asarray(0.5 * (found - by_mean.T @ by_mean))

    def _slope(self, at: _Solved) -> FloatArray:
        """Return the gradient: half of the trace of ``(P - P y y' P) dS``, ``P = S^-1 - S^-1 X (X' S^-1 X)^-1 X' S^-1``."""
        sizes, slow, white, taken = at.sizes, at.slow, at.white, at.taken[:, 0]
        # the matrix in brackets is S^-1 less the squares of these columns
        columns = np.column_stack([at.towards, at.left])
        along = slow.correlated(np.column_stack([columns, at.ones]))
        change = along * slow.changed(along)
        # traces of S^-1 times each change: what it is within tests, less what offsets take from it
        of_ones = np.column_stack([at.ones, white[:, None] * at.ones**2, change[:, -1:]])
        size, by_white, by_length = self._by_test(of_ones).T
        offsets = float(np.sum(size - taken * size**2))
        bins = float(white @ slow.inverse_diagonal - taken @ by_white)
        lengths = slow.trace_of_change() - sizes.drift**2 * float(taken @ by_length)
        drifts = len(white) - bins - self._offset(sizes) * offsets
        return np.array(
            [
                sizes.test**2 * (offsets - float(np.sum(self._by_test(columns) ** 2))),
                drifts - sizes.drift**2 * float(np.sum(columns * along[:, :-1])),
                0.5 * (lengths - sizes.drift**2 * float(np.sum(change[:, :-1]))),
                bins - float(white @ np.sum(columns**2, axis=1)),
            ]
        )
