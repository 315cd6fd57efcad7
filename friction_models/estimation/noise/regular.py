"""Cholesky roots of matrices that rounding may have made singular."""

from __future__ import annotations

import numpy as np

from ...loads import FloatArray

#: What is added to the diagonal of a correlation matrix that has no root, smallest first.
ADDED = (1e-13, 1e-11, 1e-9, 1e-7)


def regular_root(matrix: FloatArray) -> FloatArray:
    """Return the lower Cholesky root of a positive semidefinite matrix, shape (..., n, n).

    Columns of a design that say the same leave directions of which a matrix holds nothing but rounding. Such a matrix, and in a
    stack those beside it, gets a share of its diagonal added, the smallest that is enough: what is resolved does not change.

    Examples
    --------
    >>> regular_root(np.array([[4.0, 2.0], [2.0, 5.0]])).tolist()
    [[2.0, 0.0], [1.0, 2.0]]
    >>> regular_root(np.array([[4.0, 2.0], [2.0, 1.0]])).round(4).tolist()
    [[2.0, 0.0], [1.0, 0.0]]
    """
    for share in (0.0, *ADDED):
        try:
            return np.asarray(np.linalg.cholesky(matrix * (1.0 + share * np.eye(matrix.shape[-1]))))
        except np.linalg.LinAlgError:
            continue
    raise np.linalg.LinAlgError("a matrix that is no covariance has no root")
