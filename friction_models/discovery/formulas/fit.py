"""Terms fitted in the bins: amplitudes and base inside, shape parameters outside."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ...effects.empirical.effect import Empirical
from ...loads import FloatArray
from .bins import Bins

#: Evaluations of the residual's derivative in one fit.
MOST_STEPS = 12

Weigh = Callable[[FloatArray], FloatArray]
Shapes = list[dict[str, float]]


@dataclass(frozen=True)
class Fitted:
    """Terms after a fit to all tests."""

    shapes: Shapes
    amplitudes: FloatArray  #: Shape (effects,).


def fit(
    bins: Bins, weigh: Weigh, effects: Sequence[Empirical], start: Sequence[Mapping[str, float]]
) -> Fitted:
    """Fit terms beside the model, from the shape parameters `start` of each on.

    `weigh` turns bin means into numbers of the same weight.
    """
    problem = _Problem(bins, weigh, effects, start)
    shapes = problem.shapes()
    return Fitted(shapes, problem.amplitudes(shapes))


class _Problem:
    def __init__(
        self, bins: Bins, weigh: Weigh, effects: Sequence[Empirical], start: Sequence[Mapping[str, float]]
    ) -> None:
        self.bins, self.weigh, self.effects, self.start = bins, weigh, effects, start
        self.free = [(k, s) for k, e in enumerate(effects) for s in e.free_shapes]
        grids = [e.grids(bins.spans) for e in effects]
        limits = [[s.inner(v) for v in effects[k].limits(s, grids[k][s.name])] for k, s in self.free]
        self.low, self.high = np.array(limits, dtype=np.float64).reshape(-1, 2).T
        self.q = np.linalg.qr(weigh(bins.columns))[0]
        self.target = self._beside(weigh(bins.y))

    def _beside(self, values: FloatArray) -> FloatArray:
        """Return what the model leaves of weighed values."""
        return np.asarray(values - self.q @ (self.q.T @ values))

    def _terms(self, shapes: Shapes) -> FloatArray:
        """Return what the model leaves of the terms, shape (m, effects)."""
        columns = [self.bins.evaluate(e, s) for e, s in zip(self.effects, shapes, strict=True)]
        return self._beside(self.weigh(np.column_stack(columns)))

    def amplitudes(self, shapes: Shapes) -> FloatArray:
        """Return the amplitudes that fit best."""
        return np.asarray(np.linalg.lstsq(self._terms(shapes), self.target, rcond=1e-9)[0])

    def shapes(self) -> Shapes:
        """Return the shape parameters that fit best."""
        if not self.free:
            return [dict(s) for s in self.start]

        def at(theta: FloatArray) -> Shapes:
            shapes = [dict(s) for s in self.start]
            for (k, s), value in zip(self.free, theta, strict=True):
                shapes[k][s.name] = s.outer(float(value))
            return shapes

        def rest(theta: FloatArray, size: float = 0.0) -> FloatArray:
            shapes = at(theta)
            c = self._terms(shapes)
            doubts = [size * e.doubt(s, self.bins.spans) for e, s in zip(self.effects, shapes, strict=True)]
            return np.r_[self.target - c @ np.linalg.lstsq(c, self.target, rcond=1e-9)[0], doubts]

        begin = np.array([s.inner(self.start[k][s.name]) for k, s in self.free])
        solver: Any = least_squares
        begin = np.clip(begin, self.low + 1e-9, self.high - 1e-9)
        size = float(np.sqrt(np.mean(rest(begin) ** 2)))
        found = solver(
            lambda theta: rest(theta, size),
            begin,
            bounds=(self.low, self.high),
            diff_step=1e-4,
            max_nfev=MOST_STEPS,
            xtol=1e-4,
            ftol=1e-5,
        )
        return at(found.x)
