"""Heat data that depend on temperature: a number, or values at temperatures with straight lines between them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError

FloatArray = npt.NDArray[np.float64]

#: A constant, or pairs (temperature [degC], value); beyond the first and the last pair the value stays.
Property = float | tuple[tuple[float, float], ...]

#: Most pairs of a property.
MAX_PAIRS = 200


def checked_property(value: Any, what: str) -> Property:
    """Return a constant or pairs as floats.

    Raises InputError: not positive and finite, temperatures that do not rise, or no pairs; names `what`.
    """
    if isinstance(value, (int, float, np.number)) and not isinstance(value, bool):
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{what} = {value!r}; allowed: a finite number > 0")
        return float(value)
    if not isinstance(value, Iterable) or isinstance(value, (str, bytes)):
        raise InputError(f"{what} = {value!r:.60}; allowed: a number > 0, or pairs (temperature, value)")
    rows = [tuple(row) if isinstance(row, Iterable) else (row,) for row in value]
    if not 1 <= len(rows) <= MAX_PAIRS or any(len(row) != 2 for row in rows):
        raise InputError(f"{what}: {len(rows)} rows; allowed: 1 to {MAX_PAIRS} pairs (temperature, value)")
    pairs = tuple((float(T), float(v)) for T, v in rows)
    for T, v in pairs:
        if not (math.isfinite(T) and math.isfinite(v) and v > 0):
            raise InputError(f"{what}: {v!r} at {T!r} degC; allowed: finite values > 0")
    for (low, _), (high, _) in pairwise(pairs):
        if not low < high:
            raise InputError(f"{what}: {high:g} degC comes after {low:g} degC; allowed: rising temperatures")
    return pairs[0][1] if len(pairs) == 1 else pairs


def scaled(value: Property, factor: float) -> Property:
    """Return the property times `factor`."""
    if not isinstance(value, tuple):
        return value * factor
    return tuple((T, v * factor) for T, v in value)


def value_at(value: Property, T: npt.ArrayLike) -> FloatArray:
    """Return the property at temperatures [degC]."""
    T = np.asarray(T, dtype=np.float64)
    if not isinstance(value, tuple):
        return np.full(T.shape, value)
    return np.interp(T, *_columns(value))


@cache
def _columns(value: tuple[tuple[float, float], ...]) -> FloatArray:
    """Return temperatures and values, shape (2, n)."""
    return np.array(value).T


def integral(value: Property, T: npt.ArrayLike) -> FloatArray:
    """Return the integral of the property from 0 degC to `T`: the enthalpy, for a heat capacity."""
    T = np.asarray(T, dtype=np.float64)
    if not isinstance(value, tuple):
        return value * T
    known, values = np.array(value).T
    # The first pair is repeated far below, so that one rule serves both ends.
    known = np.concatenate([[min(known[0], 0.0) - 1.0], known])
    values = np.concatenate([values[:1], values])
    sums = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(known) * (values[1:] + values[:-1]))])

    def upto(at: FloatArray) -> FloatArray:
        k = np.clip(np.searchsorted(known, at) - 1, 0, len(known) - 1)
        return sums[k] + 0.5 * (at - known[k]) * (values[k] + np.interp(at, known, values))

    return upto(T) - upto(np.zeros(1))[0]


def mean_between(value: Property, T0: FloatArray, T1: FloatArray) -> FloatArray:
    """Return the mean of the property between two temperatures: the capacity that conserves enthalpy."""
    if not isinstance(value, tuple):
        return value_at(value, T0)
    middle = value_at(value, 0.5 * (T0 + T1))
    change = T1 - T0
    far = np.abs(change) > 1e-3
    rise = integral(value, T1) - integral(value, T0)
    return np.where(far, rise / np.where(far, change, 1.0), middle)
