"""Terms fitted in the bins: amplitudes and base inside, shape parameters outside, tests left out in turn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from ...effects.base import Effect
from ...loads import FloatArray
from ..unseen_tests import errors_of_tests
from .scan import Bins

#: Evaluations of the residual's derivative in one fit.
MOST_STEPS = 12

Weigh = Callable[[FloatArray], FloatArray]
Shapes = list[dict[str, float]]


@dataclass(frozen=True)
class Fitted:
    """Terms after a fit to all tests, and their errors on tests left out.

    Attributes
    ----------
    effects : tuple of Effect
    shapes : list of dict of str to float
    amplitudes : ndarray, shape (effects,)
    squares : ndarray, shape (tests,)
        Mean squared error of each test by a fit to the tests of the other folds.
    """

    effects: tuple[Effect, ...]
    shapes: Shapes
    amplitudes: FloatArray
    squares: FloatArray

    @property
    def error(self) -> float:
        """Mean squared error on unseen tests, every test with the same weight."""
        return float(np.mean(self.squares))


def fit(
    bins: Bins,
    weigh: Weigh,
    fold_of_test: npt.NDArray[np.intp],
    effects: Sequence[Effect],
    start: Sequence[Mapping[str, float]],
) -> Fitted:
    """Fit terms beside the model, from scan values on.

    Parameters
    ----------
    bins : Bins
    weigh : callable
        Turns bin means into numbers of the same weight.
    fold_of_test : ndarray of int, shape (tests,)
    effects : sequence of Effect
    start : sequence of mapping
        Shape parameters of each.
    """
    problem = _Problem(bins, weigh, effects, start)
    every = np.ones(len(bins.y), dtype=bool)
    shapes = problem.shapes_for(every, start)
    amplitudes = problem.coefficients(every, shapes)[-len(effects) :]
    fold = fold_of_test[bins.campaign.test]
    residual = np.empty(len(bins.y))
    for k in np.unique(fold):
        held = fold == k
        own = problem.shapes_for(~held, shapes)
        x = problem.coefficients(~held, own)
        residual[held] = bins.y[held] - np.column_stack([bins.columns, problem.terms(own)])[held] @ x
    return Fitted(tuple(effects), shapes, amplitudes, errors_of_tests(bins.campaign, residual).total)


class _Problem:
    def __init__(
        self, bins: Bins, weigh: Weigh, effects: Sequence[Effect], start: Sequence[Mapping[str, float]]
    ) -> None:
        self.bins, self.weigh, self.effects = bins, weigh, effects
        self.base, self.target = weigh(bins.columns), weigh(bins.y)
        self.free = [(k, s) for k, e in enumerate(effects) for s in e.free_shapes]
        grids = [e.grids(bins.spans) for e in effects]
        limits = [effects[k].limits(s, grids[k][s.name]) for k, s in self.free]
        self.low, self.high = np.log(limits).reshape(-1, 2).T

    def terms(self, shapes: Shapes) -> FloatArray:
        """Return the terms in the bins, shape (m, effects)."""
        return np.column_stack([self.bins.evaluate(e, s) for e, s in zip(self.effects, shapes, strict=True)])

    def coefficients(self, rows: npt.NDArray[np.bool_], shapes: Shapes) -> FloatArray:
        """Return the coefficients of base and terms that fit some bins."""
        matrix = np.column_stack([self.base, self.weigh(self.terms(shapes))])[rows]
        scale = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        return np.linalg.lstsq(matrix / scale, self.target[rows], rcond=1e-9)[0] / scale

    def shapes_for(self, rows: npt.NDArray[np.bool_], start: Sequence[Mapping[str, float]]) -> Shapes:
        """Return the shape parameters that fit some bins best."""
        if not self.free:
            return [dict(s) for s in start]
        q = np.linalg.qr(self.base[rows])[0]
        target = self.target[rows] - q @ (q.T @ self.target[rows])

        def at(theta: FloatArray) -> Shapes:
            shapes = [dict(s) for s in start]
            for (k, s), value in zip(self.free, theta, strict=True):
                shapes[k][s.name] = float(np.exp(value))
            return shapes

        def rest(theta: FloatArray) -> FloatArray:
            c = self.weigh(self.terms(at(theta)))[rows]
            c = c - q @ (q.T @ c)
            return np.asarray(target - c @ np.linalg.lstsq(c, target, rcond=1e-9)[0])

        begin = np.log([start[k][s.name] for k, s in self.free])
        solver: Any = least_squares
        found = solver(
            rest,
            np.clip(begin, self.low + 1e-9, self.high - 1e-9),
            bounds=(self.low, self.high),
            diff_step=1e-4,
            max_nfev=MOST_STEPS,
            xtol=1e-4,
            ftol=1e-5,
        )
        return at(found.x)
