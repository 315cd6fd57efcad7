"""Numbers that users give: refused in one sentence when they cannot be."""

from __future__ import annotations

import numpy as np

from friction_models.loads import InputError


def check_range(where: str, name: str, value: float, low: float, high: float, unit: str) -> None:
    """Raise when a parameter is not a finite number in its range.

    Raises
    ------
    InputError
        Names process, parameter, value and allowed range.
    """
    number = isinstance(value, (int, float, np.floating, np.integer)) and not isinstance(value, bool)
    if not (number and low <= value <= high):
        raise InputError(f"{where}: {name} = {value!r:.60} {unit}; allowed: {low:g} to {high:g} {unit}")
