"""Tensors and steps of an ONNX graph, each for the row vector of one contact point."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError

Array = npt.NDArray[Any]
#: Values of one contact point that a node may have: they stand on the stack of the caller's thread.
MAX_VALUES = 1 << 14


@dataclass
class Tensor:
    """A value of the graph, of a shape with the batch dimension 1; `constant` is None where it depends on an input."""

    shape: tuple[int, ...]
    constant: Array | None = None

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(np.prod(self.shape, dtype=int))


class Attributes:
    """The attributes of a node: numbers, texts, lists and arrays by name."""

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def number(self, name: str, default: float) -> float:
        """Return a number."""
        return float(self._values.get(name, default))

    def whole(self, name: str, default: int | None = None) -> int:
        """Return a whole number; without a default it must be there."""
        return int(self._values[name] if default is None else self._values.get(name, default))

    def array(self, name: str) -> Array:
        """Return the numbers of a list, which must be there."""
        return np.ravel(self._values[name])


@dataclass
class Step:
    """One node: operator, attributes, tensors in and out (None stands for an optional input left out)."""

    op: str
    attributes: Attributes
    inputs: list[Tensor | None]
    output: Tensor


@dataclass
class Graph:
    """The steps of a model in an order in which they can be run."""

    inputs: dict[str, Tensor]
    outputs: dict[str, Tensor]
    steps: list[Step] = field(default_factory=list)

    def needed_for(self, name: str) -> list[Step]:
        """Return the steps that the output `name` depends on."""
        wanted = {id(self.outputs[name])}
        kept = []
        for step in reversed(self.steps):
            if id(step.output) in wanted:
                kept.append(step)
                wanted |= {id(t) for t in step.inputs if t is not None}
        return kept[::-1]


def refuse(where: str, what: str) -> InputError:
    """Build the error for a graph that the generator does not translate."""
    return InputError(f"{where}: {what}; pack it with --target python, which runs ONNX Runtime")


@contextmanager
def rules_of(where: str) -> Iterator[None]:
    """Turn what a damaged graph raises anywhere (an attribute, operand or index is missing) into one sentence."""
    try:
        yield
    except InputError:
        raise
    except (ArithmeticError, AssertionError, LookupError, MemoryError, TypeError, ValueError) as error:
        text = " ".join(str(error).split())[:100]
        raise InputError(
            f"{where}: the ONNX graph breaks the rules of its operators ({type(error).__name__}: {text})"
        ) from None


def constant_of(tensor: Tensor | None, what: str, where: str) -> Array:
    """Return the value of a tensor that must be constant (indices, axes, limits)."""
    if tensor is None or tensor.constant is None:
        raise refuse(where, f"{what} is computed in the graph, allowed: a constant")
    return tensor.constant


def broadcast(shapes: Sequence[tuple[int, ...]], op: str, where: str) -> tuple[int, ...]:
    """Return the shape that the operands of an elementwise operator spread to.

    Examples
    --------
    >>> broadcast([(1, 3), (4, 1)], "Add", "law.onnx")
    (4, 3)
    """
    try:
        return tuple(int(n) for n in np.broadcast_shapes(*shapes))
    except ValueError:
        raise InputError(
            f"{where}: operator {op} has operands of shapes {list(shapes)} that do not fit"
        ) from None
