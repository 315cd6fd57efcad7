"""Checks of numbers that users give."""

from __future__ import annotations

import sys
from typing import Any, TypeGuard

import numpy as np

from .errors import InputError


def is_number(value: Any) -> TypeGuard[float]:
    """Return whether a value is a finite number, of Python or NumPy, that fits into a float; Booleans are none.

    Examples
    --------
    >>> [is_number(value) for value in (1, 2.5, np.int64(3), True, "3", float("inf"), 10**400)]
    [True, True, True, False, False, False, False]
    """
    number = isinstance(value, (int, float, np.floating, np.integer)) and not isinstance(value, bool)
    return number and bool(abs(value) <= sys.float_info.max)


def check_range(where: str, name: str, value: float, low: float, high: float, unit: str) -> None:
    """Raise when a parameter is not a finite number in its range.

    Raises InputError, which names process, parameter, value and allowed range.

    Examples
    --------
    >>> check_range("upsetting", "friction", 0.1, 0.0, 0.5, "1")
    >>> check_range("upsetting", "friction", 0.7, 0.0, 0.5, "1")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: upsetting: friction = 0.7 1; allowed: 0 to 0.5 1
    """
    if not (is_number(value) and low <= value <= high):
        behind = f" {unit}" if unit else ""
        raise InputError(f"{where}: {name} = {value!r:.60}{behind}; allowed: {low:g} to {high:g}{behind}")


def check_flag(where: str, name: str, value: object) -> bool:
    """Return a flag; 0 and 1 count, because co-simulation and tables have numbers only.

    Raises InputError for anything else: text like ``"no"`` would otherwise count as True.

    Examples
    --------
    >>> check_flag("ring", "thermal", 1)
    True
    >>> check_flag("ring", "thermal", "no")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ring: thermal = 'no'; allowed: True or False
    """
    if isinstance(value, (bool, np.bool_, int, float, np.number)) and value in (0, 1):
        return bool(value)
    raise InputError(f"{where}: {name} = {value!r:.60}; allowed: True or False")
