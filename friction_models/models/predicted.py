"""Predictions of mu by any object that can predict: our models, FMUs, scikit-learn regressors, objects of a user."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from ..common import InputError
from ..expressions.parameters import first_line
from ..loads import LOAD_NAMES, FloatArray, TriboLoads

ALLOWED = (
    f"an object that is fitted, with predict(array[n, {len(LOAD_NAMES)}]) of the loads {', '.join(LOAD_NAMES)} or "
    "predict_frame(data, tests)"
)


def predict_points(where: str, model: Any, loads: TriboLoads, tests: pd.DataFrame | None) -> FloatArray:
    """Return mu of a model at loads, shape (n,): with time and metadata where it takes them, for its memory.

    Raises
    ------
    InputError
        An object that cannot predict, or does not give one finite value a point; `where` names it.

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
    return predicted
