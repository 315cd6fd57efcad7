"""Values of a foreign graph while it is redrawn: constants, or columns of our own graph.

A foreign tensor that depends on the loads is followed at ONE contact point, so that all its dimensions
are known; its elements, in row-major order, are the columns of one node [n, elements] of our graph.
Whatever only moves elements (reshape, transpose, slice, concatenate ...) is then the same function applied
to element numbers, and at most one Gather in our graph.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from friction_models.expressions.onnx_graph import GraphBuilder, Node, OnnxOps

from .nodes import MAX_ELEMENTS, Array, refuse

#: Most elements of a value that depends on the loads, and of all constants computed on the way.
MAX_WIDTH = 1 << 16
MAX_FOLDED = 1 << 26
TO_FLOAT32, TO_INT64, TO_DOUBLE = 1, 7, 11


@dataclass(frozen=True)
class Constant:
    """A known array (float64, int64 or bool) and the kind that the foreign graph gives it."""

    array: Array
    kind: str

    @property
    def shape(self) -> tuple[int, ...]:
        """Dimensions in the foreign graph."""
        return tuple(self.array.shape)

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(self.array.size)


@dataclass(frozen=True)
class Symbol:
    """A tensor that depends on the loads: columns of `node` in row-major order of `shape`."""

    node: Node
    shape: tuple[int, ...]
    kind: str

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(np.prod(self.shape, dtype=int))


Tensor: TypeAlias = Constant | Symbol


def reduced(shape: Sequence[int], axes: Sequence[int], keep: bool) -> tuple[int, ...]:
    """Return a shape after a reduction over axes, which are 1 with `keep` and gone without."""
    return tuple(1 if k in axes else n for k, n in enumerate(shape) if keep or k not in axes)


class Canvas:
    """Our graph under construction, with the operations on values that all translations share."""

    def __init__(self, graph: GraphBuilder, where: str) -> None:
        self.graph = graph
        self.x = OnnxOps(graph)
        self.where = where
        self.folded = 0
        #: Whether the node at hand must round like float32: its result decides about branches of trees.
        self.exact = False

    # --- sizes ---

    def room(self, shape: Sequence[int], what: str, symbolic: bool = False) -> None:
        """Refuse a result that would be too large, before it is made."""
        size = math.prod(int(n) for n in shape)
        limit = MAX_WIDTH if symbolic else MAX_ELEMENTS
        if size > limit or any(n < 0 for n in shape) or len(shape) > 16:
            raise refuse(self.where, f"{what} makes {size} elements a point, allowed: at most {limit}")
        if not symbolic:
            self.folded += size
        if self.folded > MAX_FOLDED:
            raise refuse(self.where, f"{what}: the constants grow beyond {MAX_FOLDED} elements")

    # --- moving elements ---

    def move(self, what: str, function: Callable[..., Array], *tensors: Tensor) -> Tensor:
        """Apply a function that only moves elements; it is given arrays of the tensors' shapes."""
        kind = tensors[0].kind
        if all(isinstance(t, Constant) for t in tensors):
            result = np.asarray(function(*(t.array for t in tensors)))  # type: ignore[union-attr]
            self.room(result.shape, what)
            return Constant(result, kind)
        numbers, first = [], 0
        for t in tensors:
            numbers.append(np.arange(first, first + t.size).reshape(t.shape))
            first += t.size
        index = np.asarray(function(*numbers))
        self.room(index.shape, what, symbolic=True)
        return self.pick(tensors, index, kind)

    def pick(self, tensors: Sequence[Tensor], index: Array, kind: str) -> Tensor:
        """Return the elements `index` of the tensors' elements counted one after the other."""
        flat = index.ravel()
        bounds = np.cumsum([0, *(t.size for t in tensors)])
        used = [k for k in range(len(tensors)) if ((flat >= bounds[k]) & (flat < bounds[k + 1])).any()]
        if all(isinstance(tensors[k], Constant) for k in used):
            every = [np.ravel(t.array) if isinstance(t, Constant) else np.zeros(t.size) for t in tensors]
            values = np.concatenate([*every, np.empty(0)])[flat].reshape(index.shape)
            return Constant(values.astype(tensors[used[0]].array.dtype if used else np.float64), kind)  # type: ignore[union-attr]
        # Renumber within the tensors that are used, put them side by side, gather.
        start, shift = 0, np.zeros(flat.size, dtype=np.int64)
        for k in used:
            inside = (flat >= bounds[k]) & (flat < bounds[k + 1])
            shift[inside] = start - bounds[k]
            start += tensors[k].size
        flat = flat + shift
        symbol = next(t for t in tensors if isinstance(t, Symbol))
        parts = [self.columns(tensors[k], symbol) for k in used]
        node = parts[0] if len(parts) == 1 else self.x.concat(parts)
        if not np.array_equal(flat, np.arange(start)):
            node = self.graph.op("Gather", node, self.graph.constant(flat, np.int64), axis=1)
        return Symbol(node, tuple(int(n) for n in index.shape), kind)

    def columns(self, tensor: Tensor, like: Symbol) -> Node:
        """Return the elements of a tensor as columns [n, elements] with as many rows as `like`."""
        if isinstance(tensor, Symbol):
            return tensor.node
        first = self.number(like).node
        zero = self.x.column(first, 0) * 0.0
        return zero + np.asarray(tensor.array, dtype=np.float64).reshape(1, -1)

    def reshape(self, tensor: Tensor, shape: Sequence[int]) -> Tensor:
        """Return the same elements in other dimensions."""
        if isinstance(tensor, Constant):
            return Constant(tensor.array.reshape(tuple(shape)), tensor.kind)
        return replace(tensor, shape=tuple(int(n) for n in shape))

    # --- element by element ---

    def each(self, what: str, function: Callable[..., Any], *tensors: Tensor, kind: str = "") -> Tensor:
        """Apply a formula to every element; `function` gets nodes, or numbers and arrays where constant."""
        try:
            shape = np.broadcast_shapes(*(t.shape for t in tensors))
        except ValueError:
            shown = ", ".join(str(t.shape) for t in tensors)
            raise refuse(self.where, f"{what} of shapes {shown} that do not fit") from None
        symbolic = any(isinstance(t, Symbol) for t in tensors)
        self.room(shape, what, symbolic)
        kind = kind or tensors[0].kind
        if not symbolic:
            with np.errstate(all="ignore"):
                result = np.asarray(function(*(t.array for t in tensors)))  # type: ignore[union-attr]
            return Constant(self.typed(np.broadcast_to(result, shape), kind), kind)
        operands = [self._spread(t, shape, what) for t in tensors]
        return self.stepped(Symbol(function(*operands), tuple(int(n) for n in shape), kind))

    def _spread(self, tensor: Tensor, shape: tuple[int, ...], what: str) -> Any:
        size = int(np.prod(shape, dtype=int))
        if isinstance(tensor, Constant):
            if tensor.kind == "bool":
                return self.graph.constant(np.broadcast_to(tensor.array, shape).reshape(1, size), np.bool_)
            if tensor.size == 1:
                return float(tensor.array.ravel()[0])
            return np.broadcast_to(tensor.array, shape).reshape(1, size).astype(np.float64)
        if tensor.size in (1, size):
            return tensor.node
        spread = self.move(what, lambda a: np.broadcast_to(a, shape), tensor)
        assert isinstance(spread, Symbol)
        return spread.node

    @staticmethod
    def typed(array: Array, kind: str) -> Array:
        """Return an array in the type that stands for a kind."""
        types = {"bool": np.bool_, "int64": np.int64}
        return np.asarray(array).astype(types.get(kind, np.float64))

    # --- precision and types ---

    def stepped(self, tensor: Tensor) -> Tensor:
        """Round an intermediate result to float32 where branches of trees depend on it."""
        return self.rounded(tensor) if self.exact else tensor

    def rounded(self, tensor: Tensor) -> Tensor:
        """Return values rounded to float32, where that is their kind."""
        if tensor.kind != "float32":
            return tensor
        if isinstance(tensor, Constant):
            with np.errstate(over="ignore"):
                return Constant(tensor.array.astype(np.float32).astype(np.float64), tensor.kind)
        single = self.graph.op("Cast", tensor.node, to=TO_FLOAT32)
        return replace(tensor, node=self.graph.op("Cast", single, to=TO_DOUBLE))

    def number(self, tensor: Symbol) -> Symbol:
        """Return a Boolean as 0 or 1."""
        if tensor.kind != "bool":
            return tensor
        return Symbol(self.graph.op("Cast", tensor.node, to=TO_DOUBLE), tensor.shape, "float64")

    def truncated(self, node: Node) -> Node:
        """Return values without their fraction, still double."""
        return self.graph.op("Cast", self.graph.op("Cast", node, to=TO_INT64), to=TO_DOUBLE)

    # --- sums of products ---

    def matmul(self, a: Tensor, b: Tensor, what: str) -> Tensor:
        """Return ``a @ b`` as NumPy defines it, one of both a constant or both small."""
        if len(a.shape) == 0 or len(b.shape) == 0:
            raise refuse(self.where, f"{what} of shapes {a.shape} and {b.shape} that do not fit")
        left = self.reshape(a, (1, *a.shape)) if len(a.shape) == 1 else a
        right = self.reshape(b, (*b.shape, 1)) if len(b.shape) == 1 else b
        if left.shape[-1] != right.shape[-2] or (len(right.shape) > 2 and max(right.shape[:-2]) > 1):
            raise refuse(self.where, f"{what} of shapes {a.shape} and {b.shape} is not translated")
        head, inner, width = left.shape[:-1], left.shape[-1], right.shape[-1]
        rows = int(np.prod(head, dtype=int))
        shape = [*(1,) * max(0, len(right.shape) - len(left.shape)), *head, width]
        if len(a.shape) == 1:
            del shape[-2]
        if len(b.shape) == 1:
            del shape[-1]
        flat_left = self.reshape(left, (rows, inner))
        flat_right = self.reshape(right, (inner, width))
        symbolic = isinstance(a, Symbol) or isinstance(b, Symbol)
        self.room((rows, width), what, symbolic)
        if isinstance(flat_left, Constant) and isinstance(flat_right, Constant):
            return Constant((flat_left.array @ flat_right.array).reshape(shape), a.kind)
        if isinstance(flat_left, Symbol) and isinstance(flat_right, Constant):
            product: Tensor = self._rows_by(flat_left, flat_right.array)
        elif isinstance(flat_right, Symbol) and isinstance(flat_left, Constant):
            turned = self.move(what, np.transpose, flat_right)
            assert isinstance(turned, Symbol)
            product = self.move(what, np.transpose, self._rows_by(turned, flat_left.array.T))
        else:
            self.room((rows, inner, width), what, symbolic=True)
            first = self.reshape(flat_left, (rows, 1, inner))
            second = self.reshape(self.move(what, np.transpose, flat_right), (1, width, inner))
            product = self.total(self.each(what, lambda p, q: p * q, first, second), (2,), False, what)
        return self.stepped(self.reshape(product, shape))

    def affine(self, a: Tensor, weights: Array, bias: Array, what: str) -> Tensor:
        """Return ``a @ weights + bias`` for one row `a`: one node of our graph."""
        if isinstance(a, Constant) or self.exact or a.shape != (1, weights.shape[0]):
            product = self.matmul(a, Constant(weights, a.kind), what)
            return self.each(what, lambda p, q: p + q, product, Constant(bias.reshape(1, -1), a.kind))
        return Symbol(self.x.matmul(self.number(a).node, weights, bias), (1, weights.shape[1]), a.kind)

    def _rows_by(self, left: Symbol, weights: Array) -> Symbol:
        """Multiply every row of a point's matrix by constant weights."""
        rows, width = left.shape[0], weights.shape[1]
        weights = np.asarray(weights, dtype=np.float64)
        node = self.number(left).node
        if rows == 1:
            return Symbol(self.x.matmul(node, weights), (1, width), left.kind)
        inner = left.shape[1]
        parts = []
        for r in range(rows):
            own = self.graph.constant(np.arange(r * inner, (r + 1) * inner), np.int64)
            parts.append(self.x.matmul(self.graph.op("Gather", node, own, axis=1), weights))
        return Symbol(self.x.concat(parts), (rows, width), left.kind)

    def total(self, tensor: Tensor, axes: Sequence[int], keep: bool, what: str) -> Tensor:
        """Return the sum over axes."""
        rank = len(tensor.shape)
        axes = sorted({int(a) % rank for a in axes}) if rank else []
        kept, shape = reduced(tensor.shape, axes, True), reduced(tensor.shape, axes, keep)
        if isinstance(tensor, Constant):
            return Constant(np.asarray(tensor.array.sum(axis=tuple(axes))).reshape(shape), tensor.kind)
        size = int(np.prod(kept, dtype=int))
        node = self.number(tensor).node
        if size == tensor.size:
            return Symbol(node, shape, tensor.kind)
        if size == 1:
            return self.stepped(Symbol(self.x.reduce_sum(node), shape, tensor.kind))
        target = np.broadcast_to(np.arange(size).reshape(kept), tensor.shape).ravel()
        self.room((tensor.size, size), what, symbolic=False)
        ones = np.zeros((tensor.size, size))
        ones[np.arange(tensor.size), target] = 1.0
        return self.stepped(Symbol(self.x.matmul(node, ones), shape, tensor.kind))

    def extreme(self, tensor: Tensor, axes: Sequence[int], keep: bool, largest: bool, what: str) -> Tensor:
        """Return the largest or smallest element over axes, by halving."""
        rank = len(tensor.shape)
        axes = sorted({int(a) % rank for a in axes}) if rank else []
        order = [k for k in range(rank) if k not in axes] + axes
        inner = int(np.prod([tensor.shape[k] for k in axes], dtype=int))
        if inner == 0:
            raise refuse(self.where, f"{what} over nothing is not translated")
        value = self.move(what, lambda a: a.transpose(order).reshape(-1, inner), tensor)
        function = self.x.maximum if largest else self.x.minimum
        while value.shape[1] > 1:
            half = value.shape[1] // 2
            first = self.move(what, lambda a, h=half: a[:, :h], value)
            second = self.move(what, lambda a, h=half: a[:, h : 2 * h], value)
            odd = self.move(what, lambda a, h=half: a[:, 2 * h :], value)
            value = self.each(what, function, first, second)
            if odd.size:
                value = self.move(what, lambda a, b: np.concatenate([a, b], axis=1), value, odd)
        return self.reshape(value, reduced(tensor.shape, axes, keep))
