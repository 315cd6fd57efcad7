"""Shape parameters of effects moved from where they are to the least squares."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ...effects.base import Effect
from ...effects.parameters import ShapeParameter, Spans
from ...loads import FloatArray

Shapes = list[dict[str, float]]
Limits = Callable[[int, ShapeParameter], tuple[float, float]]


def fitted_shapes(
    effects: Sequence[Effect],
    start: Sequence[Mapping[str, float]],
    limits: Limits,
    spans: Spans,
    rest: Callable[[Shapes], FloatArray],
    **solver: Any,
) -> Shapes:
    """Return the shape parameters of effects that fit best, from `start` on.

    Parameters
    ----------
    effects : sequence of Effect
        A level that deviates is no number to be moved, and stays.
    start : sequence of dict
        Shape parameters of each effect.
    limits : callable
        Returns between which values a shape parameter of an effect, given by its number, is sought.
    spans : mapping
        Ranges of the data, beyond which an effect doubts its shape.
    rest : callable
        Returns the weighed residuals for shape parameters, shape (m,).
    **solver
        Tolerances for `scipy.optimize.least_squares`.
    """
    free = [(k, s) for k, e in enumerate(effects) for s in e.free_shapes if s.name != "deviating"]
    if not free:
        return [dict(s) for s in start]
    inner = np.array([[s.inner(v) for v in limits(k, s)] for k, s in free])
    low, high = inner[:, 0], np.maximum(inner[:, 1], inner[:, 0] + 1e-9)

    def at(theta: FloatArray) -> Shapes:
        shapes = [dict(s) for s in start]
        for (k, s), value in zip(free, theta, strict=True):
            shapes[k][s.name] = s.outer(float(value))
        return shapes

    begin = np.clip([s.inner(start[k][s.name]) for k, s in free], low, high)
    # A doubt of one counts as much as a point that is off as usual.
    usual = float(np.sqrt(np.mean(rest(at(begin)) ** 2)))

    def doubted(theta: FloatArray) -> FloatArray:
        shapes = at(theta)
        doubts = [usual * e.doubt(s, spans) for e, s in zip(effects, shapes, strict=True)]
        return np.r_[rest(shapes), doubts]

    solve: Any = least_squares
    return at(solve(doubted, begin, bounds=(low, high), diff_step=1e-4, **solver).x)
