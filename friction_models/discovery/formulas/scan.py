"""All terms over their scan values: how well each predicts whole tests that a fit did not see, by sums over tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...effects.empirical.terms import Term
from ...estimation.noise.noise_floor import Whitener
from ...loads import FloatArray
from ..judge.unseen_tests import ErrorsByTest, errors_of_tests
from .bins import Bins

#: Least share of a term, weighed by the noise, that the model must leave.
VISIBLE = 1e-3
#: Terms of largest gain that are tried on unseen tests, for all tests and for each choice of them.
TRIED, ALSO_TRIED = 24, 10
#: Terms of largest gain from which a further one is chosen, beside all of one load.
FURTHER = 110


@dataclass(frozen=True)
class Column:
    """A term at one set of scan values."""

    term: Term
    shape: dict[str, float]
    values: FloatArray  #: In the bins, shape (m,).


@dataclass(frozen=True)
class ChosenTests:
    """A choice of tests to which everything linear is fitted."""

    weight: FloatArray  #: How often each test counts, shape (tests,).
    group: int  #: Number of the choice of tests for which terms are looked for.


@dataclass(frozen=True)
class Tried:
    """One term on tests that a fit did not see."""

    term: Term
    columns: list[Column | None]  #: For each group the best scan values; None where it cannot be seen.
    #: For each fit what it leaves of mu in the bins of tests that it does not count.
    residuals: list[FloatArray]


class Scan:
    """Terms beside a model and beside what was chosen for each group of tests, equally many for each.

    The first fits are those to all tests of each group, in their order.
    """

    def __init__(
        self, bins: Bins, whiten: Whitener, chosen: Sequence[Sequence[Column]], fits: Sequence[ChosenTests]
    ) -> None:
        self.bins, self.whiten, self.fits, self.groups = bins, whiten, fits, len(chosen)
        self.weights = np.array([f.weight for f in fits])
        rows = [bins.columns, *(c.values[:, None] for own in chosen for c in own), bins.y[:, None]]
        self.matrix = np.column_stack(rows)
        base, each = bins.columns.shape[1], len(chosen[0])
        #: Rows of base and chosen terms of each group.
        own = [[*range(base), *range(base + each * g, base + each * (g + 1))] for g in range(len(chosen))]
        self.rows = np.array([own[f.group] for f in fits])
        white = self._white(self.matrix)
        self.turned = np.ascontiguousarray(np.swapaxes(white, 1, 2))
        sums = np.tensordot(self.weights, self.turned @ white, 1)
        at = np.arange(len(fits))[:, None]
        G = sums[at[:, :, None], self.rows[:, :, None], self.rows[:, None, :]]
        ridge = 1e-12 * np.trace(G, axis1=1, axis2=2)[:, None, None] * np.eye(G.shape[1])
        self.inverse = np.linalg.inv(G + ridge)
        self.z = sums[at, self.rows, -1]
        self.b = np.einsum("rpq,rq->rp", self.inverse, self.z)
        self.held = [np.flatnonzero(f.weight[bins.campaign.test] == 0.0) for f in fits]

    def _white(self, values: FloatArray) -> FloatArray:
        """Return whitened values, shape (tests, slots, k)."""
        return self.whiten.inverse @ self.whiten.layout.pad(values)

    def without(self, fit: int) -> FloatArray:
        """Return what a fit without a further term leaves of mu in the bins that it does not count."""
        held = self.held[fit]
        return np.asarray(self.bins.y[held] - self.matrix[held][:, self.rows[fit]] @ self.b[fit])

    def _solved(self, C: FloatArray, fits: slice) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return gains and amplitudes of a term over its scan values, and what it takes from the other rows."""
        white = self._white(C)
        weights = self.weights[fits]
        sums = np.tensordot(weights, self.turned @ white, 1)
        bc = sums[np.arange(len(weights))[:, None], self.rows[fits]]
        along = self.inverse[fits] @ bc
        whole = weights @ np.einsum("tsg,tsg->tg", white, white)
        norm = whole - np.einsum("rpg,rpg->rg", bc, along)
        score = sums[:, -1] - np.einsum("rpg,rp->rg", along, self.z[fits])
        usable = norm > np.maximum(VISIBLE * whole, 1e-12)
        a = np.where(usable, score / np.where(usable, norm, 1.0), 0.0)
        return a * np.where(usable, score, 0.0), a, along

    def promising(self, terms: Sequence[Term]) -> tuple[list[Term], list[Term]]:
        """Return the terms that gain most in the tests of one of the groups, and those of which a further one may be chosen."""
        gains = np.array(
            [self._solved(self.bins.scan(t)[0], slice(self.groups))[0].max(axis=1) for t in terms]
        )
        order = np.argsort(-gains, axis=0, kind="stable")
        kept = set(order[:TRIED, 0]) | set(order[:ALSO_TRIED, 1:].ravel())
        large = set(order[:FURTHER, 0])
        further = [t for k, t in enumerate(terms) if k in large or len(t.loads) == 1]
        return [t for k, t in enumerate(terms) if k in kept and gains[k].max() > 0.0], further

    def one(self, term: Term) -> Tried:
        """Return what a term leaves of the tests that each fit does not count."""
        C, shapes = self.bins.scan(term)
        gain, a, along = self._solved(C, slice(None))
        best = np.argmax(gain, axis=1)
        columns: list[Column | None] = []
        for g in range(self.groups):
            shape = {n: float(v[best[g]]) for n, v in shapes.items()}
            seen = gain[g, best[g]] > 0.0
            columns.append(Column(term, shape, C[:, best[g]].copy()) if seen else None)
        residuals = []
        for k, held in enumerate(self.held):
            size = a[k, best[k]]
            b = self.b[k] - size * along[k, :, best[k]]
            known = self.matrix[held][:, self.rows[k]] @ b
            residuals.append(self.bins.y[held] - known - size * C[held, best[k]])
        return Tried(term, columns, residuals)

    def errors(self, fits: Sequence[int], residuals: Sequence[FloatArray]) -> ErrorsByTest:
        """Return the errors of each test in those bins that several fits do not count; nan for other tests."""
        total = np.full(len(self.bins.y), np.nan)
        for k, values in zip(fits, residuals, strict=True):
            total[self.held[k]] = values
        return errors_of_tests(self.bins.campaign, total)


def folds_left_out(weight: FloatArray, fold: npt.NDArray[np.intp], group: int) -> list[ChosenTests]:
    """Return fits that leave out one fold each of the tests that count."""
    return [ChosenTests(np.where(fold == k, 0.0, weight), group) for k in np.unique(fold[weight > 0.0])]
