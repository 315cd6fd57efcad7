"""Methods of effects, called with a check of what they return: users write effects, too."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...common import InputError
from ...effects.base import Effect
from ...loads import FloatArray


def called(effect: Effect, part: str, count: int, *given: Any) -> tuple[FloatArray, ...]:
    """Return the result of a method of an effect.

    Raises InputError: the method raised, or gives anything else than `count` arrays of numbers.
    """
    where = f"effect {effect.name!r}: {part}"
    try:
        columns = tuple(np.asarray(c, dtype=np.float64) for c in getattr(effect, part)(*given))
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


def shaped(effect: Effect, part: str, values: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Return what a method of an effect gives, broadcast to `size`. Raises InputError: it has another shape."""
    try:
        return np.broadcast_to(values, size)
    except ValueError:
        raise InputError(
            f"effect {effect.name!r}: {part} gives the shape {values.shape}; allowed: {size}, or one that broadcasts to it"
        ) from None
