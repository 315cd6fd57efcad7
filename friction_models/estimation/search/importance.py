"""Whether a part of the error is large enough to matter."""

from __future__ import annotations

import numpy as np

from ...loads import FloatArray

#: Least share of the squared error (floor included) that an effect must carry: smaller ones are within the
#: errors of a twin's loads and of no use to a model.
LEAST_SHARE = 0.015


def error_share(rms: float, floor: float) -> float:
    """Return the share of the squared error, noise floor included, that a part of this rms carries."""
    return float(rms**2 / max(rms**2 + floor**2, 1e-300))


def weighted_rms(values: FloatArray, weight: FloatArray) -> float:
    """Return the rms about the weighted mean.

    Examples
    --------
    >>> import numpy as np
    >>> weighted_rms(np.array([1.0, 3.0, 9.0]), np.array([1.0, 1.0, 0.0]))
    1.0
    """
    mean = float(weight @ values / weight.sum())
    return float(np.sqrt(weight @ (values - mean) ** 2 / weight.sum()))
