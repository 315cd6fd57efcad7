"""Terms fitted in the bins: amplitudes and base inside, shape parameters outside."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...effects.empirical.effect import Empirical
from ...estimation.fit.shape_fit import Shapes, fitted_shapes
from ...loads import FloatArray
from .bins import Bins

#: Evaluations of the residual's derivative in one fit.
MOST_STEPS = 12

Weigh = Callable[[FloatArray], FloatArray]


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
        self.grids = [e.grids(bins.spans) for e in effects]
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
        return fitted_shapes(
            self.effects,
            self.start,
            lambda k, s: self.effects[k].limits(s, self.grids[k][s.name]),
            self.bins.spans,
            self._rest,
            max_nfev=MOST_STEPS,
            xtol=1e-4,
            ftol=1e-5,
        )

    def _rest(self, shapes: Shapes) -> FloatArray:
        """Return what the model and the terms leave."""
        terms = self._terms(shapes)
        return np.asarray(self.target - terms @ np.linalg.lstsq(terms, self.target, rcond=1e-9)[0])
