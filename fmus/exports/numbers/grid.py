"""A grid of loads that is refined where linear interpolation between its lines is worst."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from friction_models.loads import FloatArray

#: Random points at which each interval is judged, and how often the grid is tried as a whole.
_JUDGED, _ROUNDS = 48, 6
#: An interval below this part of its axis is not halved any more.
_SHORTEST = 1.0 / 500.0
#: Significant digits of the grid lines: those that are written, so that mu belongs to the lines of the file.
_DIGITS = 9


class Grid:
    """Grid lines of each axis, with the error of linear interpolation in each interval.

    `evaluate` takes points of shape (n, axes) and returns mu of shape (n,). `box` holds the ends of the axes: one of no length
    gets one line. `counts` holds the numbers of evenly spaced lines; None for an axis that is refined.

    Examples
    --------
    >>> grid = Grid(lambda points: points[:, 0] ** 2, [(0.0, 1.0)], [3])
    >>> grid.lines[0], grid.values()
    (array([0. , 0.5, 1. ]), array([0.  , 0.25, 1.  ]))
    >>> grid.interval_error(0, 0.0, 0.5)
    0.0625
    """

    def __init__(
        self,
        evaluate: Callable[[FloatArray], FloatArray],
        box: list[tuple[float, float]],
        counts: list[int | None],
    ) -> None:
        self.evaluate = evaluate
        self.free = [k for k, n in enumerate(counts) if n is None]
        self.lines = [
            _rounded(np.linspace(a, b, n or 2)) if b > a else _rounded(np.array([a]))
            for (a, b), n in zip(box, counts)
        ]
        self.lower = np.array([x[0] for x in self.lines])
        self.upper = np.array([x[-1] for x in self.lines])
        self.rng = np.random.default_rng(30)
        #: Whether `refine` ended at the largest allowed number of rows.
        self.full = False
        self.judged: dict[tuple[int, float, float], float] = {}

    def values(self) -> FloatArray:
        """Return mu on the grid."""
        points = grid_points(self.lines)
        parts = [self.evaluate(p) for p in np.array_split(points, 1 + len(points) // 50_000)]
        return np.concatenate(parts).reshape([len(x) for x in self.lines])

    def interval_error(self, axis: int, lower: float, upper: float) -> float:
        """Return how far linear interpolation along one axis is off inside an interval."""
        key = (axis, lower, upper)
        if key not in self.judged:
            others = self.rng.uniform(self.lower, self.upper, size=(_JUDGED, len(self.lines)))
            # Corners count: laws bend most where the other loads are extreme.
            corner = self.rng.random(others.shape) < 0.5
            ends = np.where(self.rng.random(others.shape) < 0.5, self.lower, self.upper)
            others = np.where(corner, ends, others)
            parts = (0.0, 1.0, 0.25, 0.5, 0.75)
            stack = np.repeat(others[None], len(parts), axis=0)
            for row, part in zip(stack, parts):
                row[:, axis] = lower + part * (upper - lower)
            mu = self.evaluate(stack.reshape(-1, len(self.lines))).reshape(len(parts), -1)
            off = [np.abs(mu[i] - (1 - p) * mu[0] - p * mu[1]).max() for i, p in enumerate(parts) if i > 1]
            self.judged[key] = float(max(off))
        return self.judged[key]

    def refine(self, tolerance: float, max_rows: int) -> None:
        """Halve the worst intervals until the measured error is below the tolerance or the grid is full."""
        share = 0.9 * tolerance
        for _ in range(_ROUNDS):
            if not self._halve_until(share, max_rows) or self.error(self.rng, 4000)[0] <= 0.9 * tolerance:
                return
            share *= 0.7

    def _halve_until(self, share: float, max_rows: int) -> bool:
        """Return whether the errors of the axes, added up, come below `share`; False when the grid is full."""
        while True:
            worst = [(*self._worst(k), k) for k in self.free]
            if sum(error for error, _, _ in worst) <= share:
                return True
            _, middle, axis = max(worst)
            rows = np.prod([len(x) for x in self.lines], dtype=float)
            if rows * (len(self.lines[axis]) + 1) / len(self.lines[axis]) > max_rows:
                self.full = True
                return False
            self.lines[axis] = np.sort(np.append(self.lines[axis], middle))

    def _worst(self, axis: int) -> tuple[float, float]:
        """Return the largest error of an axis among the intervals that can be halved, and where to halve.

        A jump of mu (a tree's) cannot be interpolated away: an interval around it is left alone once it is short.
        """
        lines = self.lines[axis]
        shortest = _SHORTEST * (lines[-1] - lines[0])
        found = [
            (self.interval_error(axis, a, b), float(_rounded(0.5 * (a + b))))
            for a, b in pairwise(lines)
            if b - a > shortest
        ]
        return max(found, default=(0.0, 0.0))

    def error(self, rng: np.random.Generator, count: int) -> tuple[float, float]:
        """Return the largest and the root-mean-square error of multilinear interpolation at random points."""
        points = rng.uniform(self.lower, self.upper, size=(count, len(self.lines)))
        off = interpolated(self.lines, self.values(), points) - self.evaluate(points)
        return float(np.abs(off).max()), float(np.sqrt((off**2).mean()))


def grid_points(lines: Sequence[FloatArray]) -> FloatArray:
    """Return all points of a grid, shape (points, axes); the last axis runs fastest."""
    return np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, len(lines))


def interpolated(lines: Sequence[FloatArray], values: FloatArray, at: FloatArray) -> FloatArray:
    """Return values at points of shape (n, axes): linear between the lines of a grid, those of its edge outside.

    Examples
    --------
    >>> interpolated([np.array([20.0, 40.0]), np.array([1.0])], np.array([[0.1], [0.2]]), np.array([[30.0, 7.0]]))
    array([0.15])
    """
    from scipy.interpolate import RegularGridInterpolator

    varying = [k for k, x in enumerate(lines) if len(x) > 1]
    table = values.reshape([len(lines[k]) for k in varying])
    if not varying:
        return np.full(len(at), float(table))
    inside = [np.clip(at[:, k], lines[k][0], lines[k][-1]) for k in varying]
    return np.asarray(RegularGridInterpolator([lines[k] for k in varying], table)(np.column_stack(inside)))


def _rounded(values: float | FloatArray) -> FloatArray:
    """Return the values with `_DIGITS` significant digits."""
    texts = [f"{x:.{_DIGITS}g}" for x in np.ravel(values)]
    return np.array(texts, dtype=float).reshape(np.shape(values))
