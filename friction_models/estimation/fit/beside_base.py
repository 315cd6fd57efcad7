"""Least squares of columns beside those of a base: what the base alone needs is computed once for all columns that are tried."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from ...loads import FloatArray

#: Of the largest singular value: below it, columns are the same.
SAME = 1e-10
#: Share of the variation of an effect that a base must leave, for its amplitude to be known.
LEAST_SEEN = 1e-4


class BesideBase:
    """The columns of a base, shape (m, p), of which the first is the level, and a target, shape (m,); both whitened."""

    def __init__(self, base: FloatArray, target: FloatArray) -> None:
        norms = np.maximum(np.linalg.norm(base, axis=0), 1e-300)
        u, s, vt = np.linalg.svd(base / norms, full_matrices=False)
        known = s > SAME * s[0]
        self._span, self._level = u[:, known], base[:, 0] / norms[0]
        self._inverse = (vt[known].T / s[known]) @ u[:, known].T / norms[:, None]
        self._target, self.left = target, self._without(target)

    def _without(self, values: FloatArray) -> FloatArray:
        return np.asarray(values - self._span @ (self._span.T @ values))

    def columns(self, values: FloatArray) -> Columns:
        """Return whitened columns of effects, shape (m, k), as they are fitted beside the base.

        The amplitude of one that hardly varies beside the base would be large, cancelled by its slopes: that one is nothing.
        """
        beside = self._without(values)
        varies = np.sum(values**2, axis=0) - (self._level @ values) ** 2
        seen = np.sum(beside**2, axis=0) > LEAST_SEEN * varies
        return Columns(self, values * seen, beside * seen)

    def coefficients(self, others: FloatArray) -> FloatArray:
        """Return the coefficients of the base, shape (p,), beside what the others are together, shape (m,)."""
        return np.asarray(self._inverse @ (self._target - others))


class Columns:
    """Columns of effects beside a base; amplitudes are those of columns of norm one."""

    def __init__(self, base: BesideBase, whole: FloatArray, beside: FloatArray) -> None:
        size = np.linalg.norm(whole, axis=0)
        # a column that is not seen has no size: what rounding makes of its amplitude must not grow
        self.scale = np.where(size > 0.0, size, 1.0)
        self._base, self._whole, self._beside = base, whole / self.scale, beside / self.scale
        self._triangle = np.linalg.qr(np.column_stack([self._beside, base.left])).R
        self._restraint = np.zeros(len(size))
        #: By how much each amplitude is drawn towards zero, shape (k,), without what restrains it.
        self.pull = np.zeros(len(size))

    def restrain(self, sizes: FloatArray) -> None:
        """Draw each amplitude of the columns as given towards zero: times its size, shape (k,), it is a residual in units of the usual one."""
        # not from the last row: levels add up to the base, and of what they leave rounding would take some along their last one
        rest = self._triangle[:, -1] - self._triangle[:, :-1] @ self.amplitudes()
        self._restraint = float(np.linalg.norm(rest)) / np.sqrt(len(self._base.left)) * sizes / self.scale
        self._add_rows(self._restraint)

    def drawn(self, amplitudes: FloatArray) -> FloatArray:
        """Return the residuals by which amplitudes are restrained, shape (k,)."""
        return np.asarray(self._restraint * amplitudes)

    def draw(self, pull: FloatArray) -> None:
        """Draw each amplitude towards zero, by so much as a row of the problem, shape (k,)."""
        self.pull = pull
        self._add_rows(pull)

    def _add_rows(self, pull: FloatArray) -> None:
        self._triangle = np.vstack([self._triangle, np.column_stack([np.diag(pull), np.zeros(len(pull))])])

    def amplitudes(self, low: FloatArray | None = None, high: FloatArray | None = None) -> FloatArray:
        """Return the amplitudes of least squares, within bounds, shape (k,) each, where these are given."""
        matrix, target = self._triangle[:, :-1], self._triangle[:, -1]
        x = np.asarray(np.linalg.lstsq(matrix, target, rcond=SAME)[0])
        if low is None or high is None or not np.any((x < low) | (x > high)):
            return x
        return np.asarray(lsq_linear(matrix, target, (low, high), method="bvls").x)

    def base(self, amplitudes: FloatArray) -> FloatArray:
        """Return the coefficients of the base beside these amplitudes, shape (p,)."""
        return self._base.coefficients(self._whole @ amplitudes)

    def rest(self, amplitudes: FloatArray) -> FloatArray:
        """Return what base and columns leave of the target, shape (m,)."""
        return np.asarray(self._base.left - self._beside @ amplitudes)
