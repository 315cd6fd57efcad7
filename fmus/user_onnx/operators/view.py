"""Inputs and attributes of one node, as its translation needs them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .nodes import Array, ForeignNode, refuse
from .tensors import Constant, Tensor


@dataclass(frozen=True)
class View:
    """A node with its operands looked up, None for one that is left out; `opset` is that of the standard operators."""

    node: ForeignNode
    inputs: list[Tensor | None]
    opset: int
    where: str

    @property
    def op(self) -> str:
        """Name of the operator."""
        return self.node.op

    def attribute(self, name: str, default: Any) -> Any:
        """Return an attribute; it must be of the type of its default, where that is given."""
        value = self.node.attributes.get(name, default)
        if isinstance(value, float) and name not in self.node.attributes:
            value = float(np.float32(value))  # attributes are float32, also those left out
        if isinstance(default, int | float) and not isinstance(value, int | float):
            raise refuse(self.where, f"attribute {name!r} of {self.op} is {value!r:.40}, allowed: a number")
        if isinstance(value, float) and np.isnan(value):
            raise refuse(self.where, f"attribute {name!r} of {self.op} is NaN, allowed: a number")
        return value

    def optional(self, k: int) -> Tensor | None:
        """Return operand k, None where it is left out."""
        return self.inputs[k] if k < len(self.inputs) else None

    def tensor(self, k: int) -> Tensor:
        """Return operand k, which must be there."""
        found = self.optional(k)
        if found is None:
            raise refuse(self.where, f"{self.op} lacks its operand {k}")
        return found

    def tensors(self) -> list[Tensor]:
        """Return all operands; at least one."""
        found = [t for t in self.inputs if t is not None]
        if not found:
            raise refuse(self.where, f"{self.op} has no operand")
        return found

    def known(self, k: int, what: str) -> Array:
        """Return operand k, which must be constant."""
        found = self.tensor(k)
        if not isinstance(found, Constant):
            raise refuse(self.where, f"{what} of {self.op} is computed from the loads, allowed: a constant")
        return found.array

    def integers(self, k: int | None, name: str) -> list[int] | None:
        """Return whole numbers from operand k or, in older operator sets, from an attribute; None without."""
        if k is not None and self.optional(k) is not None:
            values = np.ravel(self.known(k, name))
            if values.size > 64:
                raise refuse(
                    self.where, f"{name} of {self.op} has {values.size} numbers, allowed: at most 64"
                )
            return [int(x) for x in values]
        stored = self.node.attributes.get(name)
        if stored is None:
            return None
        return [int(x) for x in (stored if isinstance(stored, list | tuple | np.ndarray) else [stored])]

    def axis(self, value: int, rank: int) -> int:
        """Return an axis counted from the front."""
        if not -rank <= value < max(rank, 1):
            raise refuse(self.where, f"axis {value} of {self.op} with {rank} dimensions does not exist")
        return value % rank if rank else 0

    def axes(self, k: int | None, rank: int) -> list[int] | None:
        """Return axes counted from the front; None where they are left out."""
        found = self.integers(k, "axes")
        return None if found is None else [self.axis(a, rank) for a in found]
