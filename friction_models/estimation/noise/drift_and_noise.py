"""Covariance of a drift and of noise in the bins of all tests, in a time that grows with their number.

A drift whose correlation falls exponentially with the distance is a Markov process: the inverse of its correlation is tridiagonal
(Rue, Held: Gaussian Markov Random Fields (2005), section 1.1). With it, sums over all bins take the place of matrices of each test.
"""

from __future__ import annotations

from functools import cached_property

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
        rho, self._left = np.where(inside, np.exp(-e), 0.0), np.where(inside, -np.expm1(-2.0 * e), 1.0)
        #: The inverse of P: its diagonal and what stands beside it; the same of its change with the logarithm of l.
        beside = rho**2 / self._left
        own = 1.0 + np.r_[beside, 0.0] + np.r_[0.0, beside]
        self._inverse = _factors(own, -rho / self._left)
        change = 2.0 * e * beside / self._left
        self._change = np.r_[change, 0.0] + np.r_[0.0, change], -rho * e * (1.0 + rho**2) / self._left**2
        self._rho = rho
        # (P^-1 + d^2 D^-1), whose inverse is what is left of P once mu is known
        self._known = own + self._variance / white, -rho / self._left
        self._posterior = _factors(*self._known)

    @property
    def log_det(self) -> float:
        """Logarithm of the determinant."""
        sums = (self._white, self._left, self._posterior[0])
        return float(sum(np.sum(np.log(values)) for values in sums))

    def solve(self, values: FloatArray) -> FloatArray:
        """Return the inverse of the covariance times columns, shape (m, k)."""
        weighed = values / self._white[:, None]
        return np.asarray(weighed - self._variance * _solved(self._posterior, weighed) / self._white[:, None])

    def correlated(self, values: FloatArray) -> FloatArray:
        """Return ``P`` times columns, shape (m, k)."""
        return _solved(self._inverse, values)

    def changed(self, correlated: FloatArray) -> FloatArray:
        """Return minus the change of ``P^-1`` with the logarithm of ``l`` times columns, shape (m, k)."""
        own, beside = (values[:, None] for values in self._change)
        found = own * correlated
        found[:-1] += beside * correlated[1:]
        found[1:] += beside * correlated[:-1]
        return np.asarray(-found)

    @cached_property
    def inverse_diagonal(self) -> FloatArray:
        """Diagonal of the inverse of the covariance, shape (m,)."""
        return np.asarray((1.0 - self._variance * self._left_of_drift / self._white) / self._white)

    @cached_property
    def _left_of_drift(self) -> FloatArray:
        """Diagonal of the inverse of ``P^-1 + d^2 D^-1``: pivots from both ends meet in each bin."""
        own, beside = self._known
        backward = _factors(own[::-1], beside[::-1])[0][::-1]
        return np.asarray(1.0 / (self._posterior[0] + backward - own))

    def trace_of_change(self) -> float:
        """Return the trace of the inverse of the covariance times the change of ``d^2 P`` with the logarithm of ``l``."""
        left = self._left_of_drift
        # beside the diagonal: that of P, and of the inverse of its sum with the noise
        beside = -self._posterior[1][: len(self._rho)] * left[1:]
        own_change, beside_change = self._change
        return -float(own_change @ (1.0 - left) + 2.0 * beside_change @ (self._rho - beside))


def _factors(own: FloatArray, beside: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the factors of a tridiagonal matrix: pivots, shape (m,), and what stands below ones, shape (m - 1,)."""
    # LAPACK wants a number beside the diagonal also where there is none
    pivots, below, failed = dpttrf(own, beside if len(beside) else np.zeros(1))
    if failed:
        raise np.linalg.LinAlgError("not positive definite")
    return pivots, below


def _solved(factors: tuple[FloatArray, FloatArray], values: FloatArray) -> FloatArray:
    """Return the inverse of a factored matrix times columns, shape (m, k)."""
    return np.asarray(dpttrs(*factors, values)[0])
