"""Standardisation of the loads: zero mean, unit standard deviation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from ..common import InputError
from ..loads import LOAD_NAMES, FloatArray
from .ops import Ops, Value
from .parameters import Arrays, stored_floats

#: Directions in standardised columns that vary less than this, relative to the widest one, are rounding of the data:
#: what lies along them is not told apart, and gets the solution of least norm.
RESOLUTION = 1e-6


@dataclass(frozen=True)
class Scaling:
    """z = (x - mean) / scale, column by column.

    Examples
    --------
    The second column does not vary and becomes 0:

    >>> matrix = np.array([[1.0, 7.0], [3.0, 7.0]])
    >>> Scaling.of(matrix).apply(matrix).tolist()
    [[-1.0, 0.0], [1.0, 0.0]]
    """

    #: A column that does not vary becomes 0: its value is the mean, its scale 1; shape (k,).
    mean: FloatArray
    scale: FloatArray

    @classmethod
    def of(cls, matrix: FloatArray) -> Self:
        """Return the standardisation of a matrix of shape (n, k)."""
        mean, spread = matrix.mean(axis=0), matrix.std(axis=0)
        # Rounding leaves a spread of about 1e-16 |mean| on a constant column.
        varies = spread > 1e-12 * np.maximum(np.abs(mean), 1.0)
        return cls(np.where(varies, mean, matrix[0]), np.where(varies, spread, 1.0))

    def apply(self, matrix: FloatArray) -> FloatArray:
        """Return the standardised matrix."""
        return (matrix - self.mean) / self.scale

    def columns(self, x: Ops, columns: list[Value]) -> list[Value]:
        """Return standardised columns, with either back end."""
        return [(c - m) * (1.0 / s) for c, m, s in zip(columns, self.mean.tolist(), self.scale.tolist())]

    def arrays(self) -> dict[str, FloatArray]:
        """Return the arrays to store."""
        return {"mean": self.mean, "scale": self.scale}

    @classmethod
    def restore(cls, family: str, arrays: Arrays, k: int) -> Self:
        """Restore what `arrays` returned."""
        mean = stored_floats(family, arrays, "mean", (k,))
        scale = stored_floats(family, arrays, "scale", (k,))
        if not (scale > 0).all():
            raise InputError(f"{family}: array 'scale' holds {scale.min():g}; allowed: numbers above 0")
        return cls(mean, scale)


def centred(
    columns: FloatArray, target: FloatArray, weights: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Return what plain least squares takes for weighted least squares with a constant: columns and target about their means.

    Rows are multiplied by the roots of the weights. Behind them the weighted means of the columns, shape (k,), and of the target;
    columns without weights count as standardised already.

    Examples
    --------
    >>> columns, target, mean, level = centred(np.array([[0.0], [4.0]]), np.array([1.0, 5.0]), np.array([1.5, 0.5]))
    >>> mean.tolist(), level
    ([1.0], 2.0)
    """
    if weights is None:
        level = float(np.mean(target))
        return columns, target - level, np.zeros(columns.shape[1]), level
    mean, level = np.average(columns, axis=0, weights=weights), float(np.average(target, weights=weights))
    root = np.sqrt(weights)
    return root[:, None] * (columns - mean), root * (target - level), mean, level


def unresolved(standardised: FloatArray) -> FloatArray:
    """Return the directions along which standardised columns do not vary beyond rounding, shape (k, directions)."""
    sizes, directions = np.linalg.eigh(standardised.T @ standardised)
    return np.asarray(directions[:, sizes <= RESOLUTION**2 * sizes.max(initial=0.0)])


def not_told_apart(matrix: FloatArray) -> tuple[str, ...]:
    """Return the loads that vary in a matrix of shape (n, 5), yet follow from one another but for rounding.

    Examples
    --------
    Speed and distance grow together, so that no fit can tell them apart:

    >>> loads = np.array([[10, 20, 500, 1, 1], [20, 90, 500, 2, 1], [30, 20, 500, 3, 1], [40, 60, 500, 4, 1.0]])
    >>> not_told_apart(loads)
    ('v_rel', 'sd')
    """
    columns = Scaling.of(matrix).apply(matrix)
    varies = columns.std(axis=0) > 0.5
    shares = np.linalg.norm(unresolved(columns[:, varies]), axis=1)
    return tuple(n for n, share in zip(np.array(LOAD_NAMES)[varies].tolist(), shares) if share > 1e-3)
