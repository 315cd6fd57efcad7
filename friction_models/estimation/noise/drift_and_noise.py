"""Covariance of a drift and of noise in the bins of all tests, in a time that grows with their number.

A drift whose correlation falls exponentially with the distance is a Markov process: the inverse of its correlation is tridiagonal
(Rue, Held: Gaussian Markov Random Fields (2005), chapter 1). With it, sums over all bins take the place of matrices of each test.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dpttrf, dpttrs

from ...loads import FloatArray

#: Least distance between two bins, over the correlation length: of bins at one place the correlation has no inverse.
LEAST_STEP = 1e-6


class DriftAndNoise:
    """The covariance ``D + d^2 P`` of bins in the order of their tests and distances: ``P_ij = exp(-|s_i - s_j|/l)`` within a test.

    Parameters
    ----------
    steps : array, shape (m - 1,)
        Distances from one bin to the next over the correlation length ``l``; infinite from one test to the next.
    drift : float
        Standard deviation ``d`` of the drift.
    white : array, shape (m,)
        Variances ``D`` of the bins by themselves, above 0.

    Raises
    ------
    numpy.linalg.LinAlgError
        Rounding leaves no solution.

    Examples
    --------
    >>> both = DriftAndNoise(np.array([np.log(2.0)]), 1.0, np.ones(2))
    >>> both.solve(np.array([[2.5], [2.5]])).ravel().round(12).tolist()  # P has 1/2 beside its diagonal
    [1.0, 1.0]
    """

    def __init__(self, steps: FloatArray, drift: float, white: FloatArray) -> None:
        self._variance, self._white = drift**2, white
        inside = np.isfinite(steps)
        e = np.where(inside, np.maximum(steps, LEAST_STEP), 1.0)
        # correlation of each bin with the next, and what of the variance there is not in the bin before
        self._next = np.where(inside, np.exp(-e), 0.0)
        self._fresh = np.where(inside, -np.expm1(-2.0 * e), 1.0)
        known = self._next**2 / self._fresh
        # the inverse of P, then its change with the logarithm of l: the diagonal, and what stands beside it
        own, beside = 1.0 + _in_both(known), -self._next / self._fresh
        self._own_change = _in_both(2.0 * e * known / self._fresh)
        self._beside_change = beside * e * (1.0 + self._next**2) / self._fresh
        self._inverse = _factors(own, beside)
        # the covariance of the drift that is left once mu is known, over d^2: the inverse of P^-1 + d^2 D^-1
        own = own + self._variance / white
        self._posterior = _factors(own, beside)
        pivots, below = self._posterior
        # factors from both ends meet in each bin
        backward = _factors(own[::-1], beside[::-1])[0][::-1]
        self._own_left = 1.0 / (pivots + backward - own)
        self._beside_left = -below * self._own_left[1:]

    @property
    def log_det(self) -> float:
        """Logarithm of the determinant."""
        sums = (self._white, self._fresh, self._posterior[0])
        return float(sum(np.sum(np.log(values)) for values in sums))

    @property
    def inverse_diagonal(self) -> FloatArray:
        """Diagonal of the inverse, shape (m,)."""
        return np.asarray((1.0 - self._variance * self._own_left / self._white) / self._white)

    def solve(self, values: FloatArray) -> FloatArray:
        """Return the inverse times columns, shape (m, k)."""
        white = self._white[:, None]
        weighed = values / white
        return np.asarray(weighed - self._variance * _solved(self._posterior, weighed) / white)

    def correlated(self, values: FloatArray) -> FloatArray:
        """Return ``P`` times columns, shape (m, k)."""
        return _solved(self._inverse, values)

    def changed(self, values: FloatArray) -> FloatArray:
        """Return minus the change of ``P^-1`` with the logarithm of ``l`` times columns, shape (m, k).

        Between two `correlated` it is the change of ``P``.
        """
        own, beside = self._own_change[:, None], self._beside_change[:, None]
        found = own * values
        found[:-1] += beside * values[1:]
        found[1:] += beside * values[:-1]
        return np.asarray(-found)

    def trace_of_change(self) -> float:
        """Return the trace of the inverse times the change of ``d^2 P`` with the logarithm of ``l``."""
        own, beside = 1.0 - self._own_left, self._next - self._beside_left
        return -float(self._own_change @ own + 2.0 * self._beside_change @ beside)


def _in_both(values: FloatArray) -> FloatArray:
    """Return for each bin the sum of what belongs to the steps before and after it, shape (m,)."""
    return np.asarray(np.r_[values, 0.0] + np.r_[0.0, values])


def _factors(own: FloatArray, beside: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the factors of a tridiagonal matrix: pivots, shape (m,), and what stands below ones, shape (m - 1,)."""
    if not len(beside):  # which LAPACK does not take
        return own, beside
    pivots, below, failed = dpttrf(own, beside)
    if failed:
        raise np.linalg.LinAlgError("not positive definite")
    return pivots, below


def _solved(factors: tuple[FloatArray, FloatArray], values: FloatArray) -> FloatArray:
    """Return the inverse of a factored matrix times columns, shape (m, k)."""
    pivots, below = factors
    return np.asarray(dpttrs(pivots, below, values)[0] if len(below) else values / pivots[:, None])
