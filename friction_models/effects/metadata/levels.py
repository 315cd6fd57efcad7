"""Levels of metadata: texts as numbers 0, 1, 2 ... in alphabetical order, of which each may have an offset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...expressions.ops import Ops, Value
from ..parameters import Amplitude

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


def at_levels(x: Ops, value: Value, number: int) -> tuple[Value, ...]:
    """Return `at_level` of the first so many levels.

    Examples
    --------
    >>> import numpy as np
    >>> from friction_models.estimation.search.candidates import OPS
    >>> [part.tolist() for part in at_levels(OPS, np.array([0.0, 1.0]), 2)]
    [[1.0, 0.0], [0.0, 1.0]]
    """
    return tuple(at_level(x, value, float(level)) for level in range(number))


def with_offsets(symbol: str, column: str, labels: Sequence[str]) -> dict[str, Any]:
    """Return what an effect declares that has an offset for each label of a column, pooled by a fit.

    Examples
    --------
    >>> declared = with_offsets("c", "operator", ["anna", "bert"])
    >>> declared["equation"], [a.name for a in declared["amplitudes"]]
    ('mu += c[operator], 0 for another operator', ['c[anna]', 'c[bert]'])
    """
    return {
        "labels": tuple(labels),
        "pooled": True,
        "equation": f"mu += {symbol}[{column}], 0 for another {column}",
        "amplitudes": tuple(Amplitude(f"{symbol}[{k}]", "1", f"offset of {k}", 0, 0.0) for k in labels),
    }
