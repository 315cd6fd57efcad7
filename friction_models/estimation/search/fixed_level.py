"""What a model that is taken as it is may be off by as a whole: a shift, or a factor, as where the force was read with a wrong gain."""

from __future__ import annotations

import numpy as np

from ...loads import FloatArray

#: Standard errors over the tests by which tests left out must prefer a factor to a shift.
PREFERRED = 1.0
#: Predictions that differ by less than this share are the same everywhere: a factor on them is a shift.
SAME = 1e-6
#: Fewest tests of which some can be left out.
LEAST_TESTS = 8


def is_scaled(predicted: FloatArray, measured: FloatArray) -> bool:
    """Return whether tests that are left out prefer a factor on predictions to a shift of them.

    Both are means of mu over each test, shape (tests,).

    Examples
    --------
    >>> predicted, scatter = np.array([0.06, 0.08, 0.1, 0.12] * 3), 1e-4 * (-1.0) ** np.arange(12)
    >>> is_scaled(predicted, 1.25 * predicted + scatter), is_scaled(predicted, predicted + 0.02 + scatter)
    (True, False)
    """
    if len(predicted) < LEAST_TESTS or np.ptp(predicted) <= SAME * float(np.max(np.abs(predicted))):
        return False
    left = measured - predicted
    gain = _left_out(np.ones_like(left), left) - _left_out(predicted, left)
    error = float(np.std(gain, ddof=1)) / len(gain) ** 0.5
    return float(np.mean(gain)) > PREFERRED * max(error, 1e-300)


def _left_out(column: FloatArray, left: FloatArray) -> FloatArray:
    """Return the squared error of each test by the multiple of a column that the others choose, shape (tests,)."""
    products, squares = column * left, column**2
    coefficient = (products.sum() - products) / np.maximum(squares.sum() - squares, 1e-300)
    return np.asarray((left - coefficient * column) ** 2)
