"""Operators that move elements or return sizes. All sizes are those of one contact point."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from .nodes import MAX_ELEMENTS, MAX_RANK, Array, refuse
from .tensors import Canvas, Constant, Symbol, Tensor
from .view import View


def identity(c: Canvas, v: View) -> Tensor:
    """Translate operators that pass their first operand on (Dropout outside training too)."""
    return v.tensor(0)


def constant(c: Canvas, v: View) -> Tensor:
    """Translate Constant in all its spellings."""
    for name, value in v.node.attributes.items():
        if name == "value":
            return Constant(*value)
        if name in {"value_float", "value_floats"}:
            return Constant(np.asarray(value, dtype=np.float64), "float32")
        if name in {"value_int", "value_ints"}:
            return Constant(np.asarray(value, dtype=np.int64), "int64")
    raise refuse(c.where, "a Constant that is no number is not translated")


def shape_of(c: Canvas, v: View) -> Tensor:
    """Translate Shape and Size."""
    shape = v.tensor(0).shape
    if v.op == "Size":
        return Constant(np.asarray(int(np.prod(shape, dtype=int))), "int64")
    end = v.attribute("end", None)
    return Constant(np.asarray(shape[int(v.attribute("start", 0)) : end], dtype=np.int64), "int64")


def _dimensions(v: View, k: int, what: str) -> list[int]:
    values = np.ravel(v.known(k, what))
    if values.size > MAX_RANK:
        raise refuse(v.where, f"{v.op} to {values.size} dimensions, allowed: at most {MAX_RANK}")
    return [int(n) for n in values]


def reshape(c: Canvas, v: View) -> Tensor:
    """Translate Reshape."""
    value = v.tensor(0)
    wanted = _dimensions(v, 1, "the shape")
    if not v.attribute("allowzero", 0):
        wanted = [value.shape[k] if n == 0 and k < len(value.shape) else n for k, n in enumerate(wanted)]
    rest = math.prod(n for n in wanted if n >= 0)
    if wanted.count(-1) == 1 and rest > 0 and value.size % rest == 0:
        wanted = [value.size // rest if n == -1 else n for n in wanted]
        rest = value.size
    if min(wanted, default=0) < 0 or rest != value.size:
        raise refuse(c.where, f"Reshape of {value.shape} to {wanted} does not fit")
    return c.reshape(value, wanted)


def flatten(c: Canvas, v: View) -> Tensor:
    """Translate Flatten."""
    value = v.tensor(0)
    axis = int(v.attribute("axis", 1))
    axis += len(value.shape) if axis < 0 else 0
    head = int(np.prod(value.shape[:axis], dtype=int))
    return c.reshape(value, (head, value.size // head if head else 0))


def squeeze(c: Canvas, v: View) -> Tensor:
    """Translate Squeeze."""
    value = v.tensor(0)
    axes = v.axes(1, len(value.shape))
    if axes is None:
        axes = [k for k, n in enumerate(value.shape) if n == 1]
    if any(value.shape[k] != 1 for k in axes):
        raise refuse(c.where, f"Squeeze of {value.shape} along {axes} does not fit")
    return c.reshape(value, [n for k, n in enumerate(value.shape) if k not in axes])


def unsqueeze(c: Canvas, v: View) -> Tensor:
    """Translate Unsqueeze."""
    value = v.tensor(0)
    found = v.integers(1, "axes") or []
    rank = len(value.shape) + len(found)
    axes = {v.axis(a, rank) for a in found}
    if rank > MAX_RANK or len(axes) != len(found):
        raise refuse(c.where, f"Unsqueeze of {value.shape} along {found} does not fit")
    old = iter(value.shape)
    return c.reshape(value, [1 if k in axes else next(old) for k in range(rank)])


def transpose(c: Canvas, v: View) -> Tensor:
    """Translate Transpose."""
    value = v.tensor(0)
    rank = len(value.shape)
    order = v.integers(None, "perm") or list(range(rank))[::-1]
    if sorted(order) != list(range(rank)):
        raise refuse(c.where, f"Transpose of {value.shape} by {order} does not fit")
    return c.move("Transpose", lambda a: a.transpose(order), value)


def concat(c: Canvas, v: View) -> Tensor:
    """Translate Concat."""
    tensors = v.tensors()
    rank = len(tensors[0].shape)
    axis = v.axis(int(v.attribute("axis", 0)), rank)

    def others(t: Tensor) -> list[int]:
        return [n for k, n in enumerate(t.shape) if k != axis]

    if rank == 0 or any(len(t.shape) != rank or others(t) != others(tensors[0]) for t in tensors):
        shown = ", ".join(str(t.shape) for t in tensors[:4])
        raise refuse(c.where, f"Concat of shapes {shown} does not fit")
    symbolic = any(isinstance(t, Symbol) for t in tensors)
    c.room([sum(t.shape[axis] for t in tensors), *others(tensors[0])], "Concat", symbolic)
    result = c.move("Concat", lambda *a: np.concatenate(a, axis=axis), *tensors)
    real = next((t.kind for t in tensors if t.kind != "int64"), "int64")
    return Constant(result.array, real) if isinstance(result, Constant) else result


def slice_(c: Canvas, v: View) -> Tensor:
    """Translate Slice, with limits as operands or (before operator set 10) attributes."""
    value = v.tensor(0)
    rank = len(value.shape)
    as_inputs = v.opset >= 10
    starts = v.integers(1 if as_inputs else None, "starts") or []
    ends = v.integers(2 if as_inputs else None, "ends") or []
    given = v.integers(3 if as_inputs else None, "axes")
    axes = [v.axis(a, rank) for a in (range(len(starts)) if given is None else given)]
    steps = (v.integers(4, "steps") if as_inputs else None) or [1] * len(starts)
    if not len(starts) == len(ends) == len(axes) == len(steps) or 0 in steps:
        raise refuse(c.where, f"Slice from {starts} to {ends} along {axes} by {steps} does not fit")
    parts = [slice(None)] * rank
    for a, start, end, step in zip(axes, starts, ends, steps):
        n = value.shape[a]
        # As the standard says: counted from the back where negative, then held inside the axis.
        first = min(max(start + n if start < 0 else start, 0), n if step > 0 else n - 1)
        last = min(max(end + n if end < 0 else end, -1 if step < 0 else 0), n)
        parts[a] = slice(first, None if last < 0 else last, step)
    return c.move("Slice", lambda a: a[tuple(parts)], value)


def split(c: Canvas, v: View) -> list[Tensor]:
    """Translate Split."""
    value = v.tensor(0)
    axis = v.axis(int(v.attribute("axis", 0)), len(value.shape))
    total, count = value.shape[axis], len(v.node.outputs)
    sizes = v.integers(1 if v.opset >= 13 else None, "split")
    if sizes is None:
        each = -(-total // count)
        sizes = [min(each, total - each * k) for k in range(count)]
    if sum(sizes) != total or min(sizes, default=-1) < 0 or len(sizes) != count:
        raise refuse(c.where, f"Split of {value.shape} into {sizes} along axis {axis} does not fit")
    edges = np.cumsum([0, *sizes]).tolist()
    return [
        c.move("Split", lambda a, p=p, q=q: np.moveaxis(np.moveaxis(a, axis, 0)[p:q], 0, axis), value)
        for p, q in pairwise(edges)
    ]


def _checked_index(v: View, index: Array, size: int) -> Array:
    if index.size and not (-size <= index.min() and index.max() < size):
        raise refuse(v.where, f"{v.op} picks element {int(np.abs(index).max())} of {size}")
    return np.where(index < 0, index + size, index).astype(np.int64)


def gather(c: Canvas, v: View) -> Tensor:
    """Translate Gather and ArrayFeatureExtractor with constant indices."""
    value = v.tensor(0)
    if v.op == "ArrayFeatureExtractor":
        value = c.reshape(value, (1, value.size)) if len(value.shape) < 2 else value
        axis, index = len(value.shape) - 1, np.ravel(v.known(1, "the index"))
    else:
        axis, index = v.axis(int(v.attribute("axis", 0)), len(value.shape)), v.known(1, "the index")
    if not value.shape or index.dtype.kind not in "iu":
        raise refuse(c.where, f"{v.op} of shape {value.shape} is not translated")
    index = _checked_index(v, index, value.shape[axis])
    shape = [*value.shape[:axis], *index.shape, *value.shape[axis + 1 :]]
    c.room(shape, v.op, isinstance(value, Symbol))
    return c.move(v.op, lambda a: np.take(a, index, axis=axis), value)


def constant_of_shape(c: Canvas, v: View) -> Tensor:
    """Translate ConstantOfShape."""
    shape = _dimensions(v, 0, "the shape")
    c.room(shape, "ConstantOfShape")
    value = v.node.attributes.get("value")
    array = np.zeros(1) if value is None else np.ravel(value)
    if array.size != 1:
        raise refuse(c.where, f"ConstantOfShape with {array.size} values, allowed: 1")
    kinds = {"b": "bool", "i": "int64"}
    return Constant(np.full(shape, array[0]), kinds.get(array.dtype.kind, "float32"))


def range_(c: Canvas, v: View) -> Tensor:
    """Translate Range with constant limits."""
    start, limit, step = (float(np.ravel(v.known(k, "a limit"))[0]) for k in range(3))
    count = (limit - start) / step if step else np.inf
    if not count <= MAX_ELEMENTS:
        raise refuse(c.where, f"Range makes {count:.3g} elements, allowed: at most {MAX_ELEMENTS}")
    kind = v.tensor(0).kind
    n = max(int(np.ceil(count)), 0)
    c.room([n], "Range")
    return Constant(c.typed(start + step * np.arange(n), kind), kind)


def expand(c: Canvas, v: View) -> Tensor:
    """Translate Expand."""
    value = v.tensor(0)
    wanted = _dimensions(v, 1, "the shape")
    try:
        shape = np.broadcast_shapes(value.shape, tuple(wanted))
    except ValueError:
        raise refuse(c.where, f"Expand of {value.shape} to {wanted} does not fit") from None
    c.room(shape, "Expand", isinstance(value, Symbol))
    return c.move("Expand", lambda a: np.broadcast_to(a, shape), value)


def tile(c: Canvas, v: View) -> Tensor:
    """Translate Tile."""
    value = v.tensor(0)
    repeats = _dimensions(v, 1, "the repeats")
    if len(repeats) != len(value.shape) or min(repeats, default=0) < 0:
        raise refuse(c.where, f"Tile of {value.shape} by {repeats} does not fit")
    c.room([n * r for n, r in zip(value.shape, repeats)], "Tile", isinstance(value, Symbol))
    return c.move("Tile", lambda a: np.tile(a, repeats), value)


def feature_vector(c: Canvas, v: View) -> Tensor:
    """Translate FeatureVectorizer: columns side by side."""
    tensors = [c.reshape(t, (1, t.size)) for t in v.tensors()]
    c.room([sum(t.size for t in tensors)], "FeatureVectorizer", True)
    return c.move("FeatureVectorizer", lambda *a: np.concatenate(a, axis=1), *tensors)
