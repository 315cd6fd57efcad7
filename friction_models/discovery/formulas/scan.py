"""All terms over their scan values, in the bins: how well each predicts tests that were left out, and how stable it leads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...effects import empirical_effect
from ...effects.base import Effect, EffectContext
from ...effects.empirical_terms import Term
from ...estimation.campaign.binning import Campaign
from ...estimation.noise.noise_floor import Whitener
from ...estimation.search.candidates import OPS
from ...expressions.ops import LoadColumns
from ...loads import LOAD_NAMES, FloatArray
from ..unseen_tests import errors_of_tests

#: Resamples of whole tests.
RESAMPLES = 12
#: Least share of a term, weighed by the noise, that the model must leave.
VISIBLE = 1e-3


@dataclass(frozen=True)
class Scanned:
    """One term after the scan.

    Attributes
    ----------
    term : Term
    effect : Effect
    shape : dict of str to float
        The best scan values over all tests.
    squares : ndarray, shape (tests,)
        Mean squared error of each test by a fit to the tests of the other folds.
    resampled : ndarray, shape (RESAMPLES,)
        Mean squared error, by fits to resamples of the tests, of the tests that were not drawn.
    """

    term: Term
    effect: Effect
    shape: dict[str, float]
    squares: FloatArray
    resampled: FloatArray

    @property
    def error(self) -> float:
        """Mean squared error on unseen tests, every test with the same weight."""
        return float(np.mean(self.squares))


class Bins:
    """Bin means of the loads and of what belongs to the model, and how bins are weighed.

    Parameters
    ----------
    campaign : Campaign
    columns : ndarray, shape (m, p)
        The model and the named effects in the bins: free coefficients.
    y : ndarray, shape (m,)
        Bin means of mu without the fixed part of the model.
    """

    def __init__(self, campaign: Campaign, columns: FloatArray, y: FloatArray) -> None:
        norms = np.linalg.norm(columns, axis=0)
        columns = columns[:, norms > 0] / norms[norms > 0]
        u, s, _ = np.linalg.svd(columns, full_matrices=False)
        self.campaign, self.columns, self.y = campaign, u[:, s > 1e-7 * s[0]], y
        self.loads = LoadColumns(*(campaign.average(c)[:, None] for c in campaign.loads.as_array().T))
        matrix = campaign.loads.as_array()
        self.spans = {
            f"range of {n}": (float(c.min()), float(c.max()))
            for n, c in zip(LOAD_NAMES, matrix.T, strict=True)
        }

    def evaluate(self, effect: Effect, shape: Mapping[str, FloatArray | float]) -> FloatArray:
        """Return the basis of an effect in the bins, shape (m, g)."""
        rows = {n: np.atleast_2d(np.asarray(v, dtype=np.float64)) for n, v in shape.items()}
        rows = {n: v[:, :1] if np.all(v == v[0, 0]) else v for n, v in rows.items()}
        return np.asarray(effect.basis(OPS, self.loads, rows, EffectContext())[0])

    def scan_values(self, effect: Effect) -> dict[str, FloatArray]:
        """Return all sets of shape parameters of an effect, each (g,)."""
        grids = effect.grids(self.spans)
        mesh = np.meshgrid(*grids.values(), indexing="ij")
        return {n: g.ravel() for n, g in zip(grids, mesh, strict=True)}


class Scan:
    """Sums over whole tests, from which fits to any choice of tests follow at once.

    Parameters
    ----------
    bins : Bins
    whiten : Whitener
    fold_of_test : ndarray of int, shape (tests,)
    seed : int
        Of the resamples.
    """

    def __init__(self, bins: Bins, whiten: Whitener, fold_of_test: npt.NDArray[np.intp], seed: int) -> None:
        self.bins, self.whiten, self.fold = bins, whiten, fold_of_test
        tests = len(fold_of_test)
        self.folds = np.unique(fold_of_test)
        draws = np.random.default_rng([seed, 7]).integers(tests, size=(RESAMPLES, tests))
        resamples = np.array([np.bincount(d, minlength=tests) for d in draws], dtype=np.float64)
        left = (fold_of_test[None, :] != self.folds[:, None]).astype(np.float64)
        #: How often each test counts: in the fit for each fold, in each resample, in all.
        self.weights = np.vstack([left, resamples, np.ones(tests)])
        campaign = bins.campaign
        #: Bins of the tests that each fit leaves out, and the weight of a bin in its test.
        self.held = [np.flatnonzero(w[campaign.test] == 0.0) for w in self.weights[:-1]]
        self.share = campaign.count / np.bincount(campaign.test, campaign.count)[campaign.test]
        white = self._white(np.column_stack([bins.columns, bins.y]))
        both = np.swapaxes(white, 1, 2) @ white
        #: Base and mu of each test, turned so that a matrix product sums over the bins; shape (tests, p + 1, slots).
        self.turned = np.ascontiguousarray(np.swapaxes(white, 1, 2))
        self.G = np.tensordot(self.weights, both[:, :-1, :-1], 1)
        self.z = np.tensordot(self.weights, both[:, :-1, -1], 1)
        ridge = 1e-12 * np.trace(self.G, axis1=1, axis2=2)[:, None, None] * np.eye(len(self.G[0]))
        self.inverse = np.linalg.inv(self.G + ridge)
        self.b = np.einsum("rpq,rq->rp", self.inverse, self.z)

    def _white(self, values: FloatArray) -> FloatArray:
        """Return whitened values, shape (tests, slots, k)."""
        return self.whiten.inverse @ self.whiten.layout.pad(values)

    def __call__(self, terms: Sequence[Term]) -> list[Scanned]:
        """Return the terms that can be seen beside the model, the smallest error on unseen tests first."""
        found = [s for t in terms if (s := self._one(t)) is not None]
        return sorted(found, key=lambda s: s.error)

    def without(self) -> FloatArray:
        """Return the mean squared error of each test without a term."""
        residual = np.empty(len(self.bins.y))
        for k, held in enumerate(self.held[: len(self.folds)]):
            residual[held] = self.bins.y[held] - self.bins.columns[held] @ self.b[k]
        return errors_of_tests(self.bins.campaign, residual).total

    def _one(self, term: Term) -> Scanned | None:
        effect = empirical_effect(str(term))()
        shapes = self.bins.scan_values(effect)
        C = self.bins.evaluate(effect, shapes)
        white = self._white(C)
        sums = np.tensordot(self.weights, self.turned @ white, 1)
        bc = sums[:, :-1]
        along = np.einsum("rpq,rqg->rpg", self.inverse, bc)
        whole = self.weights @ np.einsum("tsg,tsg->tg", white, white)
        norm = whole - np.einsum("rpg,rpg->rg", bc, along)
        score = sums[:, -1] - np.einsum("rpg,rp->rg", along, self.z)
        usable = norm > np.maximum(VISIBLE * whole, 1e-12)
        a = np.where(usable, score / np.where(usable, norm, 1.0), 0.0)
        gain = a * np.where(usable, score, 0.0)
        best = np.argmax(gain, axis=1)
        if not gain[-1, best[-1]] > 0.0:
            return None
        residual = np.empty(len(self.bins.y))
        resampled = np.empty(RESAMPLES)
        for k, held in enumerate(self.held):
            size = a[k, best[k]]
            b = self.b[k] - size * along[k, :, best[k]]
            rest = self.bins.y[held] - self.bins.columns[held] @ b - size * C[held, best[k]]
            if k < len(self.folds):
                residual[held] = rest
            else:
                resampled[k - len(self.folds)] = self.share[held] @ rest**2 / self.share[held].sum()
        shape = {n: float(v[best[-1]]) for n, v in shapes.items()}
        squares = errors_of_tests(self.bins.campaign, residual).total
        return Scanned(term, effect, shape, squares, resampled)
