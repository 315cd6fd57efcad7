"""How well tests can be predicted from one another: a flexible reference that no formula limits.

Smooth curves along each load, along the distance, along what the contact has been through and along metadata, and products of
two of them (of metadata only with loads: a law may differ from batch to batch), with Gaussian priors;
tests have an offset of their own. Each product has a size of its own: what belongs to two quantities together need not show along either. The prior variances follow from the restricted likelihood (Gaussian process
regression; Rasmussen, Williams: Gaussian Processes for Machine Learning (2006), sections 2.7 and 5.4.1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve
from scipy.linalg.lapack import dpotrf, dpotri
from scipy.optimize import minimize

from ...loads import FloatArray
from ...loads.splits import Mask
from ..campaign.binning import Campaign
from .noise_floor import Layout, NoiseFloor, Whitener
from .reference_curves import reference_curves

#: Tests from which the prior variances are estimated, at most.
MOST_TESTS = 200
#: Prior of the natural logarithm of the variances, mean and spread: of curves and offsets over the variance of mu; of
#: products over the product of the variances of both curves; of noise over that of the floor, which is known from within tests.
PRIOR = {"curve": (-3.0, 2.0), "product": (-0.5, 2.0), "offset": (-1.0, 2.0), "noise": (0.0, 0.7)}


class _Prepared(NamedTuple):
    """The least-squares problem of a reference: rows and target in units of the noise, the rows as they are, the prior."""

    rows: FloatArray
    target: FloatArray
    plain: FloatArray
    precision: FloatArray
    offset: float


class Reference:
    """Flexible prediction of whole tests.

    Parameters
    ----------
    campaign : Campaign
    floor : NoiseFloor
        Its drift and sensor noise weigh the bins of a test against one another.
    y : ndarray, shape (m,)
        Bin means of mu.

    Attributes
    ----------
    names : list of str
        Quantities along which it has curves: loads, ``distance``, what the contact has been through, metadata.
    """

    def __init__(self, campaign: Campaign, floor: NoiseFloor, y: FloatArray) -> None:
        self.campaign, self.y = campaign, y
        self.scale = float(np.std(y)) or 1e-9
        self.names, self.curves = reference_curves(campaign)
        whiten = Whitener(Layout.of(campaign), replace(floor, test=0.0), self.scale)
        self._starts = np.flatnonzero(np.r_[True, np.diff(campaign.test) != 0])
        self._white = whiten(np.column_stack([np.ones(len(y)), y, *(c.columns for c in self.curves)]))
        self._whiten = whiten

    def out_of_fold(
        self, terms: FloatArray, fold_of_test: npt.NDArray[np.intp], anew: bool = False
    ) -> FloatArray:
        """Return what the tests of the other folds say of mu in each bin, shape (m,).

        Parameters
        ----------
        terms : ndarray, shape (m, p)
            Columns with free coefficients beside the curves: base and effects.
        fold_of_test : ndarray of int, shape (tests,)
        anew : bool
            Whether the prior variances of each fold come from the other folds, too. It takes as many times longer as there are
            folds; from all tests they know a little of those that are predicted.
        """
        fold = fold_of_test[self.campaign.test]
        predicted, folds = np.empty(len(self.y)), np.unique(fold)
        if anew:
            for k in folds:
                part = self._prepared(terms, fold != k)
                predicted[fold == k] = part.plain[fold == k] @ _solved(part, *_normal(part, fold != k))
            return predicted
        part = self._prepared(terms)
        normal = [_normal(part, fold == k) for k in folds]
        grams, scores = np.array([g for g, _ in normal]), np.array([s for _, s in normal])
        for k in folds:
            others = folds != k
            b = _solved(part, grams[others].sum(axis=0), scores[others].sum(axis=0))
            predicted[fold == k] = part.plain[fold == k] @ b
        return predicted

    def surprise(self, terms: FloatArray) -> FloatArray:
        """Return how far the mean of each test lies from what all others say, in standard deviations, shape (tests,).

        A test far from all others may lie far off: the prediction is the less certain, the farther it reaches. Each test is
        left out alone, so that chance does not say with which others.
        """
        part = self._prepared(terms)
        factor = cho_factor(part.rows.T @ part.rows + np.diag(part.precision))
        b = cho_solve(factor, part.rows.T @ part.target)
        left = part.target - part.rows @ b
        means = self._means(np.column_stack([part.plain, self.y]))
        far, variance = np.empty(len(means)), np.empty(len(means))
        for k, (start, end) in enumerate(zip(self._starts, [*self._starts[1:], len(left)], strict=True)):
            own, mean = part.rows[start:end], means[k, :-1]
            along = cho_solve(factor, np.column_stack([own.T, mean]))
            # what the fit takes from the test itself is taken back (Sherman, Morrison, Woodbury)
            without = np.linalg.solve(np.eye(end - start) - own @ along[:, :-1], own @ along[:, [-1]])[:, 0]
            far[k] = means[k, -1] - mean @ b + without @ left[start:end]
            variance[k] = part.offset + mean @ along[:, -1] + without @ (own @ along[:, -1])
        z = far / np.sqrt(np.maximum(variance, part.offset))
        return np.asarray(z / max(1.4826 * float(np.median(np.abs(z))), 1e-300))

    def _means(self, columns: FloatArray) -> FloatArray:
        """Return the means of columns in the bins over each test, weighted by points."""
        count = self.campaign.count
        weight = np.add.reduceat(count, self._starts)
        return np.asarray(np.add.reduceat(count[:, None] * columns, self._starts, axis=0) / weight[:, None])

    def _prepared(self, terms: FloatArray, seen: Mask | None = None) -> _Prepared:
        """Return the rows of terms and curves in units of the noise, with the prior variances of largest posterior density.

        These variances come from the bins that are `seen`, by default all.
        """
        norms = np.linalg.norm(terms, axis=0)
        terms = terms[:, norms > 0] / norms[norms > 0] * np.sqrt(len(terms))
        rows = np.column_stack([self._whiten(terms), self._white[:, 2:]])
        theta = self._variances(
            rows, terms.shape[1], np.ones(len(rows), dtype=bool) if seen is None else seen
        )
        precision, offset, noise = self._split(theta, terms.shape[1])
        apart, root = _decorrelated(self._white[:, 0], offset / noise, self._starts), np.sqrt(noise)
        plain = np.column_stack([terms, *(c.columns for c in self.curves)])
        return _Prepared(apart(rows) / root, apart(self._white[:, 1]) / root, plain, precision, offset)

    def _split(self, theta: FloatArray, free: int) -> tuple[FloatArray, float, float]:
        """Return the prior precision of every coefficient, and the variances of offsets and noise."""
        *curves, offset, noise = theta
        products = iter(curves[len(self.names) :])
        sizes = [
            np.exp(sum(curves[k] for k in c.of) + (next(products) if len(c.of) > 1 else 0.0))
            for c in self.curves
        ]
        own = [np.full(c.columns.shape[1], 1.0 / (s * self.scale**2)) for c, s in zip(self.curves, sizes)]
        # the white rows carry the noise of the floor: `noise` is a factor on it
        return (
            np.concatenate([np.full(free, 1e-8 / self.scale**2), *own]),
            float(np.exp(offset)) * self.scale**2,
            float(np.exp(noise)),
        )

    def _variances(self, rows: FloatArray, free: int, seen: Mask) -> FloatArray:
        """Return the logarithms of the prior variances with the largest posterior density."""
        own, count = np.unique(self.campaign.test[seen]), len(self.names)
        some = own[np.unique(np.linspace(0, len(own) - 1, min(len(own), MOST_TESTS)).astype(int))]
        chosen = np.isin(self.campaign.test, some)
        rows, one, y = rows[chosen], self._white[chosen, 0], self._white[chosen, 1]
        starts = np.flatnonzero(np.r_[True, np.diff(self.campaign.test[chosen]) != 0])
        per_test = np.add.reduceat(one[:, None] * rows, starts, axis=0)
        gram, score, square = rows.T @ rows, rows.T @ y, float(y @ y)
        size, level = np.add.reduceat(one**2, starts), np.add.reduceat(one * y, starts)
        edges = np.cumsum([free, *(c.columns.shape[1] for c in self.curves)])
        pairs = len(self.curves) - count
        kinds = [*["curve"] * count, *["product"] * pairs, "offset", "noise"]
        mean, spread = np.array([PRIOR[k] for k in kinds]).T

        def criterion(theta: FloatArray) -> tuple[float, FloatArray]:
            """Return minus twice the log posterior density, and its gradient."""
            precision, offset, noise = self._split(theta, free)
            k = offset / (noise + offset * size)
            A = (gram - per_test.T @ (k[:, None] * per_test)) / noise + np.diag(precision)
            c = (score - per_test.T @ (k * level)) / noise
            root, failed = dpotrf(A, lower=1)
            if failed:
                return 1e12, np.zeros_like(theta)
            lower = np.tril(dpotri(root, lower=1)[0])
            inverse = lower + np.tril(lower, -1).T
            b = inverse @ c
            fit = (square - float(k @ level**2)) / noise - float(c @ b)
            value = len(y) * np.log(noise) + np.sum(np.log1p(offset * size / noise)) + fit
            value += 2.0 * np.sum(np.log(np.diag(root))) - np.sum(np.log(precision))
            gradient = np.zeros_like(theta)
            own = precision * (np.diag(inverse) + b**2)
            for j, (curves, low, high) in enumerate(zip(self.curves, edges[:-1], edges[1:], strict=True)):
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
            rest = square - 2.0 * float(score @ b) + float(b @ gram @ b)
            spent = float(np.sum(inverse * gram)) - float(twice @ np.sum(along * per_test, axis=1))
            by_noise = (len(y) - float(k @ size)) / noise
            by_noise -= (spent + rest - float(twice @ left**2)) / noise**2
            gradient[-1] = noise * by_noise
            z = (theta - mean) / spread
            return float(value + z @ z), gradient + 2.0 * z / spread

        bounds = [(-9.0, 4.0)] * count + [(-9.0, 6.0)] * pairs + [(-9.0, 4.0), (-2.0, 3.0)]
        best = minimize(criterion, mean, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 40})
        return np.asarray(best.x)


def _normal(part: _Prepared, chosen: Mask) -> tuple[FloatArray, FloatArray]:
    """Return matrix and right-hand side of the normal equations of some bins, without the prior."""
    rows = part.rows[chosen]
    return rows.T @ rows, rows.T @ part.target[chosen]


def _solved(part: _Prepared, gram: FloatArray, score: FloatArray) -> FloatArray:
    return np.asarray(cho_solve(cho_factor(gram + np.diag(part.precision)), score))


def _decorrelated(
    one: FloatArray, ratio: float, starts: npt.NDArray[np.intp]
) -> Callable[[FloatArray], FloatArray]:
    """Return a function that takes the common offset of a test from whitened rows."""
    size = np.add.reduceat(one**2, starts)
    share = (1.0 - 1.0 / np.sqrt(1.0 + ratio * size)) / np.maximum(size, 1e-300)
    test = np.repeat(np.arange(len(starts)), np.diff(np.r_[starts, len(one)]))

    def apply(rows: FloatArray) -> FloatArray:
        flat = rows.reshape(len(rows), -1)
        common = np.add.reduceat(one[:, None] * flat, starts, axis=0)
        return (flat - one[:, None] * (share[:, None] * common)[test]).reshape(rows.shape)

    return apply
