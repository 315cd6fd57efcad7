"""Levels of metadata: texts as numbers 0, 1, 2 ... in alphabetical order."""

from __future__ import annotations

from ...expressions.ops import Ops, Value

#: Levels that are tried.
MOST = 60


def at_level(x: Ops, value: Value, level: Value) -> Value:
    """Return 1 where metadata has a level, else 0.

    Examples
    --------
    >>> import numpy as np
    >>> from friction_models.estimation.search.candidates import OPS
    >>> at_level(OPS, np.array([0.0, 1.0, 2.0]), 1.0).tolist()
    [0.0, 1.0, 0.0]
    """
    return x.relu(1.0 - x.abs(value - level))
