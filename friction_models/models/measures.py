"""Predictions of mu by any object that can predict, and their errors over all points and over whole tests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..common import InputError
from ..expressions.parameters import first_line
from ..loads import LOAD_NAMES, FloatArray, TriboLoads

if TYPE_CHECKING:
    import pandas as pd

ALLOWED = (
    f"an object that is fitted, with predict(array[n, {len(LOAD_NAMES)}]) of the loads {', '.join(LOAD_NAMES)} or "
    "predict_frame(data, tests)"
)

#: Squares of larger numbers are beyond all floats.
LARGEST = 1e100

#: Error measures by name; None for the share outside a domain that is not known.
Measures: TypeAlias = dict[str, float | None]


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


def loads_sentence(from_loads: float, rmse: float) -> str:
    """Return what uncertain loads can explain of a root mean square error, in one sentence.

    Examples
    --------
    >>> loads_sentence(0.001, 0.002)
    'Uncertain loads (u_sigma_n, u_psi, u_T) alone would give an RMSE of 0.00100: 25% of the mean square error.'
    """
    share = 1.0 if rmse <= from_loads else (from_loads / rmse) ** 2
    return (
        f"Uncertain loads (u_sigma_n, u_psi, u_T) alone would give an RMSE of {from_loads:.5f}: "
        f"{share:.0%} of the mean square error."
    )


def predict_points(where: str, model: Any, loads: TriboLoads, tests: pd.DataFrame | None) -> FloatArray:
    """Return mu of a model at loads, shape (n,): with time and metadata where it takes them, for its memory.

    Raises InputError: an object that cannot predict, or does not give one finite value a point; `where` names
    it.

    Examples
    --------
    >>> class Own:
    ...     def predict(self, loads):
    ...         return 0.1 + 0.0 * loads[:, 0]
    >>> predict_points("model 'own'", Own(), TriboLoads.from_array([[50, 20, 500, 0, 1]]), None).tolist()
    [0.1]
    """
    if isinstance(model, type) or not (hasattr(model, "predict") or hasattr(model, "predict_frame")):
        what = f"the class {model.__name__}" if isinstance(model, type) else type(model).__name__
        raise InputError(f"{where}: {what} cannot predict; allowed: {ALLOWED}")
    try:
        if hasattr(model, "predict_frame"):
            given = model.predict_frame(loads.to_frame(), tests)
        else:
            given = model.predict(loads.as_array())
        predicted = np.asarray(given, dtype=float).ravel()
    except InputError:
        raise
    except Exception as error:
        if getattr(model, "family", "") == "fmu":  # an FMU says itself what it refuses
            raise
        raise InputError(
            f"{where}: predict fails ({type(error).__name__}: {first_line(error)}); allowed: {ALLOWED}"
        ) from error
    if predicted.shape != (len(loads),) or not np.isfinite(predicted).all():
        raise InputError(f"{where}: predict gave {predicted.shape} values, allowed: one finite value a point")
    if np.abs(predicted).max(initial=0.0) > LARGEST:
        raise InputError(
            f"{where}: predict gave {predicted[np.argmax(np.abs(predicted))]:.3g}; allowed: friction coefficients"
        )
    return predicted
