"""Checks of parameters and of stored arrays; errors give the name, the value and what is allowed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..common import InputError
from ..loads import FloatArray

#: What a model stores beside its card, by name.
Arrays: TypeAlias = Mapping[str, npt.NDArray[Any]]


def first_line(error: BaseException) -> str:
    """Return the first line of an error's text, shortened, or its type where it has none."""
    lines = str(error).strip().splitlines()
    return lines[0][:120] if lines else type(error).__name__


def check_number(family: str, name: str, value: Any, lower: float, upper: float) -> float:
    """Return `value` as a float within [lower, upper], or raise `InputError`.

    Examples
    --------
    >>> check_number("polynomial", "ridge", 1, 0.0, 10.0)
    1.0
    >>> check_number("polynomial", "ridge", -1, 0.0, 10.0)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: polynomial: ridge is -1, allowed: a number from 0 to 10
    """
    good = isinstance(value, Real) and not isinstance(value, (bool, np.bool_)) and math.isfinite(value)
    if not good or not lower <= value <= upper:
        raise InputError(f"{family}: {name} is {value!r:.60}, allowed: a number from {lower:g} to {upper:g}")
    return float(value)


def check_integer(family: str, name: str, value: Any, lower: int, upper: int) -> int:
    """Return `value` as an int within [lower, upper], or raise `InputError`.

    Examples
    --------
    >>> check_integer("polynomial", "degree", 2, 1, 4)
    2
    """
    good = isinstance(value, Integral) and not isinstance(value, (bool, np.bool_))
    if not good or not lower <= value <= upper:
        raise InputError(
            f"{family}: {name} is {value!r:.60}, allowed: a whole number from {lower} to {upper}"
        )
    return int(value)


def check_seed(family: str, seed: Any) -> int:
    """Return a seed as every generator of random numbers takes it, or raise `InputError`."""
    return check_integer(family, "seed", seed, 0, 2**32 - 1)


def stored_floats(family: str, arrays: Arrays, name: str, shape: tuple[int | None, ...]) -> FloatArray:
    """Return a stored array as float64 of the given shape (None: any length), all values finite."""
    array = _stored(family, arrays, name, shape, "f")
    if not np.isfinite(array).all():
        raise InputError(
            f"{family}: array {name!r} holds values that are not finite; allowed: finite numbers"
        )
    return np.ascontiguousarray(array, dtype=np.float64)


def stored_integers(
    family: str, arrays: Arrays, name: str, shape: tuple[int | None, ...]
) -> npt.NDArray[np.int64]:
    """Return a stored array as int64 of the given shape (None: any length)."""
    return np.ascontiguousarray(_stored(family, arrays, name, shape, "iu"), dtype=np.int64)


def _stored(
    family: str, arrays: Arrays, name: str, shape: tuple[int | None, ...], kinds: str
) -> npt.NDArray[Any]:
    """Return a stored array after a look at its kind and shape."""
    if name not in arrays:
        raise InputError(
            f"{family}: array {name!r} is missing; present: {', '.join(sorted(arrays)) or 'none'}"
        )
    array = arrays[name]
    fits = array.ndim == len(shape) and all(s is None or s == n for s, n in zip(shape, array.shape))
    if not fits or array.dtype.kind not in kinds:
        wanted = "(" + ", ".join("n" if s is None else str(s) for s in shape) + ")"
        what = "floats" if kinds == "f" else "integers"
        raise InputError(
            f"{family}: array {name!r} is {array.dtype} of shape {array.shape}, allowed: {what} of shape {wanted}"
        )
    return array
