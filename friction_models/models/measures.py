"""Error measures of a prediction of mu, over all points and over whole tests."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..loads import FloatArray


def error_measures(
    mu: FloatArray, predicted: FloatArray, groups: npt.NDArray[np.str_] | None = None
) -> dict[str, float]:
    """Return error measures of `predicted` against `mu`, both of shape (n,).

    Returns
    -------
    dict
        ``mae``, ``rmse``, ``bias`` (mean of predicted - measured) and ``max_error`` over the points,
        ``points``; with `groups` also ``tests`` and ``mae_worst_test``, the largest MAE of one test.

    Examples
    --------
    >>> measures = error_measures(np.array([0.5, 0.5]), np.array([0.75, 0.25]))
    >>> measures["mae"], measures["bias"], measures["points"]
    (0.25, 0.0, 2)
    """
    error = predicted - mu
    measures = {
        "mae": float(np.mean(np.abs(error))),
        "rmse": float(np.sqrt(np.mean(error**2))),
        "bias": float(np.mean(error)),
        "max_error": float(np.max(np.abs(error))),
        "points": len(error),
    }
    if groups is not None:
        _, test = np.unique(groups, return_inverse=True)
        counts = np.bincount(test)
        measures["tests"] = len(counts)
        measures["mae_worst_test"] = float(np.max(np.bincount(test, weights=np.abs(error)) / counts))
    return measures


def range_warning(predicted: FloatArray) -> str:
    """Return a sentence where predicted mu leaves 0 to 1, or an empty text.

    Examples
    --------
    >>> range_warning(np.array([0.05, 1.5]))
    'mu from 0.05 to 1.5, outside 0 to 1'
    """
    low, high = float(predicted.min()), float(predicted.max())
    return "" if low >= 0.0 and high <= 1.0 else f"mu from {low:.3g} to {high:.3g}, outside 0 to 1"
