"""Methods of effects, called with a check of what they return: users write effects, too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...common import InputError
from ...effects.base import Effect
from ...loads import FloatArray

#: Squares of larger numbers are not finite.
LARGEST = 1e150


def called(effect: Effect, part: str, count: int, *given: Any) -> tuple[FloatArray, ...]:
    """Return the result of a method of an effect.

    Raises InputError: the method raised, or gives anything else than `count` arrays of real numbers.
    """
    where = f"effect {effect.name!r}: {part}"
    try:
        columns = tuple(np.asarray(c) for c in getattr(effect, part)(*given))
        if any(np.iscomplexobj(c) for c in columns):
            raise InputError(f"{where} gives complex numbers; allowed: real ones")
        columns = tuple(c.astype(np.float64, copy=False) for c in columns)
    except InputError:
        raise
    except Exception as error:
        told = " ".join(str(error).split())[:200]
        raise InputError(
            f"{where} fails ({type(error).__name__}: {told}); allowed: {count} columns of numbers"
        ) from error
    if len(columns) != count:
        raise InputError(f"{where} gives {len(columns)} columns; allowed: {count}")
    return columns


def finite(
    effect: Effect, what: str, columns: Sequence[FloatArray], shape: Mapping[str, FloatArray | float]
) -> None:
    """Raise InputError if for no set of shape parameters all of what an effect gives at points, shape (n, sets) each, is finite; its squares, too."""
    known = [(np.abs(np.atleast_2d(c)) < LARGEST).all(axis=0) for c in columns]
    if np.logical_and.reduce(np.broadcast_arrays(*known)).any():
        return
    where = ", ".join(f"{n} = {float(np.ravel(v)[0]):.3g}" for n, v in shape.items())
    raise InputError(
        f"effect {effect.name!r}: {what} is not finite{where and f', as with {where}'}; allowed: finite numbers for all shape "
        "parameters within their limits"
    )


def shaped(effect: Effect, part: str, values: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Return what a method of an effect gives, broadcast to `size`. Raises InputError: it has another shape."""
    try:
        return np.broadcast_to(values, size)
    except ValueError:
        raise InputError(
            f"effect {effect.name!r}: {part} gives the shape {values.shape}; allowed: {size}, or one that broadcasts to it"
        ) from None
