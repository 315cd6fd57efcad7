"""How large the curves of the flexible reference may be: prior variances, and metadata that the measurements do not need.

The variances have the largest posterior density under the restricted likelihood (Gaussian process regression; Rasmussen, Williams:
Gaussian Processes for Machine Learning (2006), section 5.4.1). Each product has a size of its own: what belongs to two quantities
together need not show along either.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import numpy.typing as npt
from scipy.linalg.lapack import dpotrf, dpotri
from scipy.optimize import minimize

from ...loads import FloatArray
from .reference_curves import Curves

#: Prior of the natural logarithm of the variances, mean and spread: of curves and offsets over the variance of mu; of
#: products over the product of the variances of both curves; of noise over that of the floor, which is known from within tests.
PRIOR = {"curve": (-3.0, 2.0), "product": (-0.5, 2.0), "offset": (-1.0, 2.0), "noise": (0.0, 0.7)}
#: What metadata must be worth, as twice the logarithm of a density: strong evidence (Kass, Raftery, J. Am. Stat. Assoc. 90 (1995) 773).
STRONG = 6.0
#: Logarithm of a variance that is nothing.
NOTHING = -40.0


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
        widths = [c.columns.shape[1] for c in curves]
        self._free = rows.shape[1] - sum(widths)
        self._edges = np.cumsum([self._free, *widths])
        starts = np.flatnonzero(np.r_[True, np.diff(test) != 0])
        self._per_test = np.add.reduceat(one[:, None] * rows, starts, axis=0)
        self._gram, self._score, self._square = rows.T @ rows, rows.T @ y, float(y @ y)
        self._size, self._level = np.add.reduceat(one**2, starts), np.add.reduceat(one * y, starts)
        self._mains = sum(len(c.of) == 1 for c in curves)
        kinds = ["curve" if len(c.of) == 1 else "product" for c in curves]
        self._mean, self._spread = np.array([PRIOR[k] for k in [*kinds, "offset", "noise"]]).T

    def split(self, theta: FloatArray) -> tuple[FloatArray, float, float]:
        """Return the prior precision of every coefficient, and the variances of offsets and noise."""
        *curves, offset, noise = theta
        products = iter(curves[self._mains :])
        sizes = [
            np.exp(sum(curves[k] for k in c.of) + (next(products) if len(c.of) > 1 else 0.0))
            for c in self.curves
        ]
        own = [np.full(c.columns.shape[1], 1.0 / (s * self.scale**2)) for c, s in zip(self.curves, sizes)]
        # the white rows carry the noise of the floor: `noise` is a factor on it
        return (
            np.concatenate([np.full(self._free, 1e-8 / self.scale**2), *own]),
            float(np.exp(offset)) * self.scale**2,
            float(np.exp(noise)),
        )

    def most_likely(self) -> FloatArray:
        """Return ``theta`` with the largest posterior density."""

        def criterion(theta: FloatArray) -> tuple[float, FloatArray]:
            value, gradient = self._likelihood(theta)
            z = (theta - self._mean) / self._spread
            return float(value + z @ z), gradient + 2.0 * z / self._spread

        pairs = len(self.curves) - self._mains
        bounds = [(-9.0, 4.0)] * self._mains + [(-9.0, 6.0)] * pairs + [(-9.0, 4.0), (-2.0, 3.0)]
        start = self._mean
        best = minimize(criterion, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 40})
        return np.asarray(best.x)

    def needless(self, theta: FloatArray, among: Collection[int]) -> list[int]:
        """Return the quantities without which the measurements are about as likely; of two that say the same, one stays.

        `theta` is that of largest posterior density; `among` are quantities, by their places in `Curves.of`, no two of which
        share a product.
        """
        own = {k: [j for j, c in enumerate(self.curves) if k in c.of] for k in among}
        given = ((theta - self._mean) / self._spread) ** 2
        found: list[int] = []
        while own:
            likely, tried = self._likelihood(theta)[0], {}
            for k, places in own.items():
                without = theta.copy()
                without[k] = NOTHING
                worth = self._likelihood(without)[0] - likely - float(np.sum(given[places]))
                tried[k] = worth, without
            least = min(tried, key=lambda k: tried[k][0])
            if tried[least][0] >= STRONG:
                break
            theta = tried[least][1]
            found.append(least)
            del own[least]
        return found

    def _likelihood(self, theta: FloatArray) -> tuple[float, FloatArray]:
        """Return minus twice the restricted log-likelihood, and its gradient."""
        precision, offset, noise = self.split(theta)
        per_test, gram, size, level = self._per_test, self._gram, self._size, self._level
        k = offset / (noise + offset * size)
        A = (gram - per_test.T @ (k[:, None] * per_test)) / noise + np.diag(precision)
        c = (self._score - per_test.T @ (k * level)) / noise
        root, failed = dpotrf(A, lower=1)
        if failed:
            return 1e12, np.zeros_like(theta)
        lower = np.tril(dpotri(root, lower=1)[0])
        inverse = lower + np.tril(lower, -1).T
        b = inverse @ c
        fit = (self._square - float(k @ level**2)) / noise - float(c @ b)
        value = self._count * np.log(noise) + np.sum(np.log1p(offset * size / noise)) + fit
        value += 2.0 * np.sum(np.log(np.diag(root))) - np.sum(np.log(precision))
        gradient = np.zeros_like(theta)
        own = precision * (np.diag(inverse) + b**2)
        for j, (curves, low, high) in enumerate(
            zip(self.curves, self._edges[:-1], self._edges[1:], strict=True)
        ):
            slope = (high - low) - float(own[low:high].sum())
            for main in curves.of:
                gradient[main] += slope
            if len(curves.of) > 1:
                gradient[j] += slope
        # noise: V = noise I + offset u u' in each test
        along = per_test @ inverse
        left = level - per_test @ b
        total = noise + offset * size
        by_offset = size / total - np.sum(along * per_test, axis=1) / total**2 - (left / total) ** 2
        gradient[-2] = offset * float(by_offset.sum())
        twice = 2.0 * k - k**2 * size
        rest = self._square - 2.0 * float(self._score @ b) + float(b @ gram @ b)
        spent = float(np.sum(inverse * gram)) - float(twice @ np.sum(along * per_test, axis=1))
        by_noise = (self._count - float(k @ size)) / noise
        by_noise -= (spent + rest - float(twice @ left**2)) / noise**2
        gradient[-1] = noise * by_noise
        return float(value), gradient
