"""Operators that multiply matrices, reduce over axes, or normalise."""

from __future__ import annotations

from typing import Any

import numpy as np

from .nodes import refuse
from .tensors import Canvas, Constant, Tensor, reduced
from .view import View


def matmul(c: Canvas, v: View) -> Tensor:
    """Translate MatMul."""
    return c.matmul(v.tensor(0), v.tensor(1), "MatMul")


def gemm(c: Canvas, v: View) -> Tensor:
    """Translate Gemm: ``alpha A B + beta C`` with transposed operands where told."""
    a, b = v.tensor(0), v.tensor(1)
    if len(a.shape) != 2 or len(b.shape) != 2:
        raise refuse(c.where, f"Gemm of shapes {a.shape} and {b.shape} does not fit")
    if v.attribute("transA", 0):
        a = c.move("Gemm", np.transpose, a)
    if v.attribute("transB", 0):
        b = c.move("Gemm", np.transpose, b)
    alpha, beta = float(v.attribute("alpha", 1.0)), float(v.attribute("beta", 1.0))
    if alpha != 1.0:
        if isinstance(b, Constant):
            b = Constant(alpha * b.array, b.kind)
        else:
            b = c.each("Gemm", lambda p: alpha * p, b)
    bias = v.optional(2)
    if bias is not None and isinstance(bias, Constant) and isinstance(b, Constant) and a.shape[0] == 1:
        try:
            row = np.broadcast_to(beta * bias.array, (1, b.shape[1])).ravel()
        except ValueError:
            raise refuse(
                c.where, f"Gemm adds {bias.shape} to {(1, b.shape[1])}, which does not fit"
            ) from None
        return c.affine(a, b.array, row, "Gemm")
    product = c.matmul(a, b, "Gemm")
    if bias is None or beta == 0.0:
        return product
    return c.each("Gemm", lambda p, q: p + beta * q, product, bias)


def reduce(c: Canvas, v: View) -> Tensor:
    """Translate the reductions."""
    value, name = v.tensor(0), v.op.removeprefix("Reduce")
    rank = len(value.shape)
    axes = v.axes(1, rank)
    if axes is None or not axes:
        if v.attribute("noop_with_empty_axes", 0):
            return value
        axes = list(range(rank))
    hold = bool(v.attribute("keepdims", 1))
    count = int(np.prod([value.shape[k] for k in axes], dtype=int))
    if name in {"Max", "Min"}:
        return c.extreme(value, axes, hold, name == "Max", v.op)
    if name == "Prod":
        return _product(c, value, axes, hold, v.op)
    if name == "LogSumExp":
        return _log_sum_exp(c, value, axes, hold)
    if name in {"SumSquare", "L2"}:
        value = c.each(v.op, lambda a: a * a, value)
    elif name == "L1":
        value = c.each(v.op, c.x.abs, value)
    result = c.total(value, axes, hold, v.op)
    if name == "Mean":
        result = c.each(v.op, lambda a: a * (1.0 / count) if not c.exact else a / float(count), result)
    elif name == "L2":
        result = c.each(v.op, c.x.sqrt, result)
    elif name == "LogSum":
        result = c.each(v.op, c.x.log, result)
    return result


def _product(c: Canvas, value: Tensor, axes: list[int], hold: bool, what: str) -> Tensor:
    rest = [k for k in range(len(value.shape)) if k not in axes]
    count = int(np.prod([value.shape[k] for k in axes], dtype=int))
    if not 0 < count <= 64:
        raise refuse(c.where, f"{what} over {count} elements, allowed: 1 to 64")
    order = [*rest, *axes]
    flat = c.move(what, lambda a: a.transpose(order).reshape(-1, count), value)
    result = c.move(what, lambda a: a[:, 0], flat)
    for k in range(1, count):
        result = c.each(what, lambda a, b: a * b, result, c.move(what, lambda a, k=k: a[:, k], flat))
    return c.reshape(result, reduced(value.shape, axes, hold))


def _log_sum_exp(c: Canvas, value: Tensor, axes: list[int], hold: bool) -> Tensor:
    what = "ReduceLogSumExp"
    top = c.extreme(value, axes, True, True, what)
    powers = c.each(what, lambda a, m: c.x.exp(a - m), value, top)
    total = c.each(what, lambda s, m: c.x.log(s) + m, c.total(powers, axes, True, what), top)
    return c.reshape(total, reduced(value.shape, axes, hold))


def softmax(c: Canvas, v: View) -> Tensor:
    """Translate Softmax and LogSoftmax, without overflow."""
    value = v.tensor(0)
    shape = value.shape
    axis = v.axis(int(v.attribute("axis", 1 if v.opset < 13 else -1)), len(shape))
    if v.opset < 13:  # everything behind the axis counts as one
        head = int(np.prod(shape[:axis], dtype=int))
        value, axis = c.reshape(value, (head, value.size // max(head, 1))), 1
    top = c.extreme(value, [axis], True, True, v.op)
    lowered = c.each(v.op, lambda a, m: a - m, value, top)
    powers = c.each(v.op, c.x.exp, lowered)
    total = c.total(powers, [axis], True, v.op)
    if v.op == "Softmax":
        result = c.each(v.op, lambda a, s: a / s, powers, total)
    else:
        result = c.each(v.op, lambda a, s: a - c.x.log(s), lowered, total)
    return c.reshape(result, shape)


def batch_normalization(c: Canvas, v: View) -> Tensor:
    """Translate BatchNormalization outside training."""
    if v.attribute("training_mode", 0) or len([n for n in v.node.outputs if n]) > 1:
        raise refuse(c.where, "BatchNormalization in training mode is not translated")
    value = v.tensor(0)
    scale, bias, mean, variance = (np.ravel(v.known(k, "a parameter")) for k in range(1, 5))
    channels = value.shape[1] if len(value.shape) > 1 else -1
    if any(p.size != channels for p in (scale, bias, mean, variance)):
        raise refuse(c.where, f"BatchNormalization of {value.shape} with {scale.size} channels does not fit")
    with np.errstate(all="ignore"):
        factor = scale / np.sqrt(variance + float(v.attribute("epsilon", 1e-5)))
    shape = (1, channels, *(1,) * (len(value.shape) - 2))
    parameters = [Constant(p.reshape(shape), value.kind) for p in (mean, factor, bias)]
    return c.each(v.op, lambda a, m, f, b: (a - m) * f + b, value, *parameters)


def layer_normalization(c: Canvas, v: View) -> Tensor:
    """Translate LayerNormalization (and RMSNormalization), first output."""
    if len([n for n in v.node.outputs if n]) > 1:
        raise refuse(c.where, f"{v.op} with more than one output is not translated")
    value = v.tensor(0)
    rank = len(value.shape)
    axes = list(range(v.axis(int(v.attribute("axis", -1)), rank), rank))
    count = float(np.prod([value.shape[k] for k in axes], dtype=int))

    def mean(t: Tensor) -> Tensor:
        return c.each(v.op, lambda a: a / count, c.total(t, axes, True, v.op))

    if v.op == "LayerNormalization":
        value = c.each(v.op, lambda a, m: a - m, value, mean(value))
    epsilon = float(v.attribute("epsilon", 1e-5))

    def divided(a: Any, s: Any) -> Any:
        return a / c.x.sqrt(s + epsilon)

    value = c.each(v.op, divided, value, mean(c.each(v.op, lambda a: a * a, value)))
    if v.optional(1) is not None:
        value = c.each(v.op, lambda a, b: a * b, value, v.tensor(1))
    if v.optional(2) is not None:
        value = c.each(v.op, lambda a, b: a + b, value, v.tensor(2))
    return value
