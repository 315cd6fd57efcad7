"""How large the curves of the flexible reference may be: prior variances, and metadata that the measurements do not need.

The variances have the largest posterior density under the restricted likelihood (Gaussian process regression; Rasmussen, Williams:
Gaussian Processes for Machine Learning (2006), section 5.4.1). Each product has a size of its own: what belongs to two quantities
together need not show along either.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag
from scipy.linalg.lapack import dpotrf, dpotrs, dtrtri, dtrtrs

from ...loads import FloatArray
from .newton import UNSOLVED, Likelihood, most_likely
from .reference_curves import Curves

#: Prior of the natural logarithm of the variances, mean and spread: of curves and offsets over the variance of mu; of
#: products over the product of the variances of both curves; of noise over that of the floor, which is known from within tests.
PRIOR = {"curve": (-3.0, 2.0), "product": (-0.5, 2.0), "offset": (-1.0, 2.0), "noise": (0.0, 0.7)}
#: Strong evidence, as twice the logarithm of a ratio of densities, which metadata must be worth (Kass, Raftery, J. Am. Stat. Assoc. 90 (1995) 773).
STRONG = 6.0
#: Logarithm of a variance that is nothing.
NOTHING = -40.0
#: First and largest step of the search for them, and the slope at which it ends.
STEPS, LEAST_SLOPE = (2.0, 8.0), 0.1


class _Solved(NamedTuple):
    """Coefficients of terms and curves for given variances."""

    precision: FloatArray  #: Of the prior, for each coefficient.
    offset: float
    noise: float
    k: FloatArray  #: Of each test, what the inverse of its covariance loses by the offset: (1 - k u u') / noise.
    gram: FloatArray  #: Products of all columns, weighed by the inverse of the covariance.
    root: FloatArray  #: Lower Cholesky root of the posterior precision, zero above the diagonal.
    b: FloatArray  #: Posterior mean of the coefficients.
    left: FloatArray  #: Sum over each test of what these leave of mu.
    rest: float  #: Sum of the squares of what they leave in the bins.
    value: float  #: Minus twice the restricted log-likelihood of the variances.


class VariancesOfCurves:
    """Logarithms of the prior variances ``theta``: of curves and products in their order, of the offsets of tests, of the noise.

    `rows`, shape (m, free + columns of all curves), are free terms, then curves, whitened; `one` and `y`, shape (m,), are ones
    and mu, whitened the same way; `test` is that of each row, in order. Curves along one quantity, in the order of the
    quantities, stand before products. `scale` is the standard deviation of mu.
    """

    def __init__(
        self,
        rows: FloatArray,
        one: FloatArray,
        y: FloatArray,
        test: npt.NDArray[np.intp],
        curves: Sequence[Curves],
        scale: float,
    ) -> None:
        self.curves, self.scale, self._count = curves, scale, len(y)
        self._widths = [c.columns.shape[1] for c in curves]
        self._free = rows.shape[1] - sum(self._widths)
        self._first = np.cumsum([self._free, *self._widths[:-1]])
        starts = np.flatnonzero(np.r_[True, np.diff(test) != 0])
        self._per_test = np.add.reduceat(one[:, None] * rows, starts, axis=0)
        self._gram, self._score, self._square = rows.T @ rows, rows.T @ y, float(y @ y)
        self._size, self._level = np.add.reduceat(one**2, starts), np.add.reduceat(one * y, starts)
        self._mains = sum(len(c.of) == 1 for c in curves)
        # the logarithm of the variance of each block as a sum of entries of theta
        self._sums = np.eye(len(curves))
        for j, c in enumerate(curves):
            self._sums[j, list(c.of)] = 1.0
        kinds = ["curve" if len(c.of) == 1 else "product" for c in curves]
        self._mean, self._spread = np.array([PRIOR[k] for k in [*kinds, "offset", "noise"]]).T

    def split(self, theta: FloatArray) -> tuple[FloatArray, float, float]:
        """Return the prior precision of every coefficient, and the variances of offsets and noise."""
        own = np.repeat(np.exp(-self._sums @ theta[:-2]), self._widths)
        offset, noise = np.exp(theta[-2:])
        # the white rows carry the noise of the floor: `noise` is a factor on it
        return (
            np.r_[np.full(self._free, 1e-8), own] / self.scale**2,
            float(offset) * self.scale**2,
            float(noise),
        )

    def most_likely(self) -> FloatArray:
        """Return ``theta`` with the largest posterior density."""
        # from smaller curves the scatter of tests takes the place of those that bend several times, and keeps it
        start = self._mean.copy()
        start[: self._mains] += self._spread[: self._mains]
        start[-2] -= self._spread[-2]

        def at(theta: FloatArray) -> Likelihood:
            z = (theta - self._mean) / self._spread
            prior = np.diag(2.0 / self._spread**2)
            if (found := self._at(theta)) is None:
                return Likelihood(UNSOLVED, np.zeros_like(theta), lambda: prior)
            return Likelihood(
                found.value + float(z @ z),
                self._slope(found) + 2.0 * z / self._spread,
                lambda: prior + self._information(found),
            )

        return most_likely(at, start, STEPS, LEAST_SLOPE)

    def needless(self, theta: FloatArray, among: Collection[int]) -> list[int]:
        """Return the quantities without which the measurements are about as likely; of two that say the same, one stays.

        `theta` is that of largest posterior density; `among` are quantities, by their places in `Curves.of`, no two of which
        share a product.
        """
        own = {k: [j for j, c in enumerate(self.curves) if k in c.of] for k in among}
        given = ((theta - self._mean) / self._spread) ** 2
        found: list[int] = []
        while own and (at := self._at(theta)):
            inverse_root = dtrtri(at.root, lower=1)[0]
            worth = {k: self._worth(at, inverse_root, of) - float(np.sum(given[of])) for k, of in own.items()}
            least = min(worth, key=lambda k: worth[k])
            if worth[least] >= STRONG:
                break
            theta = theta.copy()
            theta[least] = NOTHING
            found.append(least)
            del own[least]
        return found

    def _worth(self, at: _Solved, inverse_root: FloatArray, curves: Sequence[int]) -> float:
        """Return by how much minus twice the restricted log-likelihood rises without some curves."""
        of = np.repeat(np.arange(len(self.curves)), self._widths)
        own = self._free + np.flatnonzero(np.isin(of, curves))
        units = np.sqrt(at.precision[own])  # of the prior
        root, b = inverse_root[:, own] * units, at.b[own] * units
        covariance = root.T @ root
        return float(np.linalg.slogdet(covariance)[1] + b @ np.linalg.solve(covariance, b))

    def _at(self, theta: FloatArray) -> _Solved | None:
        """Return the coefficients for given variances, and how likely these are; None where rounding leaves no solution."""
        precision, offset, noise = self.split(theta)
        per_test, size, level = self._per_test, self._size, self._level
        k = offset / (noise + offset * size)
        own = np.sqrt(k)[:, None] * per_test
        gram = (self._gram - own.T @ own) / noise
        A = gram.copy()
        A[np.diag_indices_from(A)] += precision
        c = (self._score - per_test.T @ (k * level)) / noise
        root, failed = dpotrf(A, lower=1)
        if failed:
            return None
        b = dpotrs(root, c, lower=1)[0]
        fit = (self._square - float(k @ level**2)) / noise - float(c @ b)
        value = self._count * np.log(noise) + np.sum(np.log1p(offset * size / noise)) + fit
        value += 2.0 * np.sum(np.log(np.diag(root))) - np.sum(np.log(precision))
        left = level - per_test @ b
        rest = self._square - 2.0 * float(self._score @ b) + float(b @ self._gram @ b)
        return _Solved(precision, offset, noise, k, gram, root, b, left, rest, float(value))

    def _slope(self, at: _Solved) -> FloatArray:
        """Return the gradient of minus twice the restricted log-likelihood."""
        precision, offset, noise, k, b = at.precision, at.offset, at.noise, at.k, at.b
        per_test, size = self._per_test, self._size
        gradient = np.empty(len(self.curves) + 2)
        inverse_root = dtrtri(at.root, lower=1)[0]
        variance = np.sum(inverse_root**2, axis=0)
        used = np.add.reduceat(precision * (variance + b**2), self._first)
        gradient[:-2] = self._sums.T @ (self._widths - used)
        # noise: V = noise I + offset u u' in each test
        left, total = at.left, noise + offset * size
        spent_by_test = np.sum((per_test @ inverse_root.T) ** 2, axis=1)
        by_offset = size / total - spent_by_test / total**2 - (left / total) ** 2
        gradient[-2] = offset * float(by_offset.sum())
        twice = 2.0 * k - k**2 * size
        # trace of posterior covariance times Gram matrix, which differs from the inverse of the covariance by prior and offsets
        spent = noise * (len(b) - float(precision @ variance)) + float((k - twice) @ spent_by_test)
        by_noise = (self._count - float(k @ size)) / noise
        by_noise -= (spent + at.rest - float(twice @ left**2)) / noise**2
        gradient[-1] = noise * by_noise
        return gradient

    def _information(self, at: _Solved) -> FloatArray:
        """Return the average of expected and observed curvature of minus twice the restricted log-likelihood.

        Gilmour, Thompson, Cullis, Biometrics 51 (1995) 1440: what curves, offsets and noise make of mu, weighed by the inverse of
        the covariance without the free terms. It is positive definite, and takes no matrix but that of the solution.
        """
        offset, noise, b = at.offset, at.noise, at.b
        total = noise + offset * self._size
        mean = at.left / total  # of each test, what is left of mu, weighed
        own = offset * mean
        each = np.zeros((len(b), len(self.curves)))
        each[np.arange(self._free, len(b)), np.repeat(np.arange(len(self.curves)), self._widths)] = b[
            self._free :
        ]
        by_offset = self._per_test.T @ (own / total)
        columns = np.column_stack([at.gram @ each, by_offset, at.precision * b - by_offset])
        found = np.empty((columns.shape[1],) * 2)
        found[:-2] = each.T @ columns
        found[:, :-2] = found[:-2].T
        found[-2, -2] = float(own**2 @ (self._size / total))
        found[-2, -1] = found[-1, -2] = noise * float(own @ (mean / total))
        square = at.rest - 2.0 * float(own @ at.left) + float(own**2 @ self._size)
        found[-1, -1] = square / noise - noise * float(at.k @ mean**2)
        rows = dtrtrs(at.root, columns, lower=1)[0]
        found -= rows.T @ rows
        sums = block_diag(self._sums, np.eye(2))
        return np.asarray(sums.T @ found @ sums)
