"""How well tests can be predicted from one another: a flexible reference that no formula limits.

Smooth curves along each load, along the distance, along what the contact has been through and along metadata, and products of
two of them (of metadata only with loads: a law may differ from batch to batch), with Gaussian priors; tests have an offset of their
own. Metadata that the measurements do not need is left out: a column that says nothing changes nothing. Gaussian process
regression; Rasmussen, Williams: Gaussian Processes for Machine Learning (2006), section 2.7.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_solve

from ...loads import FloatArray
from ...loads.splits import Mask
from ..campaign.binned_tests import BinnedTests
from .layout import Layout
from .noise_floor import NoiseFloor, Whitener, independent_columns
from .reference_curves import reference_curves
from .reference_variances import VariancesOfCurves
from .regular import regular_root

#: Tests from which the prior variances are estimated, at most.
MOST_TESTS = 200


class _Prepared(NamedTuple):
    """The least-squares problem of a reference: rows and target in units of the noise, the rows as they are, the prior.

    The first columns, as many as are `free`, are terms without a prior. `metadata` is what the measurements need of it.
    """

    metadata: tuple[str, ...]
    rows: FloatArray
    target: FloatArray
    plain: FloatArray
    precision: FloatArray
    offset: float
    free: int


class Predicted(NamedTuple):
    """What tests of other folds say of mu in each bin, shape (m,)."""

    flexible: FloatArray  #: With the curves.
    alone: FloatArray  #: By the terms alone.
    metadata: tuple[str, ...]  #: Columns of the test table along which there are curves.


class Reference:
    """Flexible prediction of whole tests.

    Drift and sensor noise of the noise floor weigh the bins of a test against one another; `y` is mu in the bins, shape (m,).
    It is `without` some metadata.
    """

    def __init__(
        self, campaign: BinnedTests, floor: NoiseFloor, y: FloatArray, without: frozenset[str] = frozenset()
    ) -> None:
        self.campaign, self.y = campaign, y
        self._floor, self._left_out, self._others = floor, without, dict[frozenset[str], Reference]()
        self.scale = float(np.std(y)) or 1e-9
        #: Quantities along which it has curves: loads, ``distance``, what the contact has been through, metadata.
        self.names, self.curves, self._metadata = reference_curves(campaign, without)
        self.metadata = tuple(self.names[k] for k in self._metadata)
        whiten = Whitener(Layout.of(campaign), replace(floor, test=0.0), self.scale)
        self._starts = campaign.first_bins
        self._white = whiten(np.column_stack([np.ones(len(y)), y, *(c.columns for c in self.curves)]))
        self._whiten = whiten

    def out_of_fold(
        self, terms: FloatArray, fold_of_test: npt.NDArray[np.intp], anew: bool = False
    ) -> Predicted:
        """Return what the tests of the other folds say of mu in each bin.

        `terms`, shape (m, p), are columns with free coefficients beside the curves: base and effects. Both weigh tests and points
        by the same noise. With `anew` the prior variances of each fold come from the other folds, too: it takes as many times
        longer as there are folds, but from all tests they know a little of those that are predicted.
        """
        fold = fold_of_test[self.campaign.test]
        whole = None if anew else self._prepared(terms)
        flexible, alone = np.empty(len(self.y)), np.empty(len(self.y))
        needed: dict[str, None] = {}
        for k in np.unique(fold):
            part = self._prepared(terms, fold != k) if whole is None else whole
            needed.update(dict.fromkeys(part.metadata))
            gram, score = _normal(part, fold != k)
            for values, n in ((flexible, len(gram)), (alone, part.free)):
                b = _solved(part.precision[:n], gram[:n, :n], score[:n])
                values[fold == k] = part.plain[fold == k, :n] @ b
        return Predicted(flexible, alone, tuple(needed))

    def surprise(self, terms: FloatArray, left_out: Mask | None = None) -> FloatArray:
        """Return how far the mean of each test lies from what all others say, in standard deviations, shape (tests,).

        A test far from all others may lie far off: the prediction is the less certain, the farther it reaches. Each test is
        left out alone, so that chance does not say with which others. Tests that are `left_out`, shape (tests,), say nothing of
        any test, nor of the size of the curves.
        """
        out = np.zeros(len(self._starts), dtype=bool) if left_out is None else left_out
        seen = ~out[self.campaign.test]
        part = self._prepared(terms, seen)
        rows, target = part.rows * seen[:, None], part.target * seen
        factor = _root(part.precision, rows.T @ rows)
        b = cho_solve(factor, rows.T @ target)
        left = target - rows @ b
        means = self._means(np.column_stack([part.plain, self.y]))
        far, variance = np.empty(len(means)), np.empty(len(means))
        for k, (start, end) in enumerate(zip(self._starts, [*self._starts[1:], len(left)], strict=True)):
            own, mean = rows[start:end], means[k, :-1]
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
        terms = terms[:, norms > 0] / norms[norms > 0]
        basis = independent_columns(terms)
        # what says the same twice leaves the likelihood of the variances no root
        terms = (basis if basis.shape[1] < terms.shape[1] else terms) * np.sqrt(len(terms))
        rows = np.column_stack([self._whiten(terms), self._white[:, 2:]])
        some = self._some(np.ones(len(rows), dtype=bool) if seen is None else seen)
        one, y, test = self._white[some, 0], self._white[some, 1], self.campaign.test[some]
        variances = VariancesOfCurves(rows[some], one, y, test, self.curves, self.scale)
        theta = variances.most_likely()
        if needless := variances.needless(theta, self._metadata):
            return self._without(self.names[k] for k in needless)._prepared(terms, seen)
        precision, offset, noise = variances.split(theta)
        apart, root = _decorrelated(self._white[:, 0], offset / noise, self._starts), np.sqrt(noise)
        plain = np.column_stack([terms, *(c.columns for c in self.curves)])
        white = apart(rows) / root, apart(self._white[:, 1]) / root
        return _Prepared(self.metadata, *white, plain, precision, offset, terms.shape[1])

    def _some(self, seen: Mask) -> Mask:
        """Return the bins of tests that were seen; of many tests, of as many as are enough, taken evenly from their loads."""
        some = self.campaign.spread(np.unique(self.campaign.test[seen]), MOST_TESTS)
        return np.isin(self.campaign.test, some)

    def _without(self, needless: Iterable[str]) -> Reference:
        """Return the reference without some metadata; others may take their places in products."""
        key = self._left_out.union(needless)
        if key not in self._others:
            self._others[key] = Reference(self.campaign, self._floor, self.y, key)
        return self._others[key]


def _normal(part: _Prepared, chosen: Mask) -> tuple[FloatArray, FloatArray]:
    """Return matrix and right-hand side of the normal equations of some bins, without the prior."""
    rows = part.rows[chosen]
    return rows.T @ rows, rows.T @ part.target[chosen]


def _root(precision: FloatArray, gram: FloatArray) -> tuple[FloatArray, bool]:
    """Return the root of the posterior precision, as `cho_solve` takes it: terms that say the same make it all but singular."""
    return regular_root(gram + np.diag(precision)), True


def _solved(precision: FloatArray, gram: FloatArray, score: FloatArray) -> FloatArray:
    return np.asarray(cho_solve(_root(precision, gram), score))


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
