"""mu after sliding: what a model that remembers gives when it got to a point by sliding there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from ..loads import LOAD_NAMES, FloatArray

#: Steps on the way: states change smoothly, and over the steps the loads are those of the end.
STEPS = 40
_SD = LOAD_NAMES.index("sd")


def remembers(model: Any) -> bool:
    """Whether a model has states that change while it slides."""
    return bool(getattr(model, "states", ())) and hasattr(model, "predict_frame")


def after_sliding(model: Any, loads: FloatArray) -> FloatArray:
    """Return mu, shape (n,), at loads of shape (n, 5), each reached from fresh contact by sliding its `sd` at its other loads.

    For a model without memory that is ``model.predict(loads)``.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> after_sliding(ConstantFriction(0.08), np.array([[50.0, 20.0, 500.0, 30.0, 1.0]])).tolist()
    [0.08]
    """
    if not remembers(model):
        return np.asarray(model.predict(loads), dtype=float)
    way = np.repeat(loads, STEPS + 1, axis=0)
    way[:, _SD] *= np.tile(np.linspace(0.0, 1.0, STEPS + 1), len(loads))
    frame = pd.DataFrame(way, columns=list(LOAD_NAMES))
    # Each point is the last one of a test of its own.
    frame["test_id"] = np.repeat([f"p{k}" for k in range(len(loads))], STEPS + 1)
    return np.asarray(model.predict_frame(frame), dtype=float)[STEPS :: STEPS + 1]
