"""Operators that act element by element, written once for numbers and for nodes of our graph."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .nodes import KINDS, refuse
from .tensors import Canvas, Constant, Symbol, Tensor
from .view import View

#: Coefficients of erf: ``erf(x) / x`` in x^2 below 1, and ``exp(x^2) erfc(x)`` in a variable between -1 and 1
#: for x from 1 to 6; Chebyshev interpolation in 40 digits, 1.1e-16 at most from the true value.
_NEAR = (
    -7.795898827002142e-10,
    1.3720064546777686e-08,
    -1.6208483801871705e-07,
    1.6447424703317362e-06,
    -1.492473690741966e-05,
    0.00012055294904839707,
    -0.0008548325975389692,
    0.0052239776071164225,
    -0.02686617064323777,
    0.11283791670945006,
    -0.37612638903183543,
    1.1283791670955126,
)
_FAR = (
    4.4133850329466983e-13,
    1.8386753405993422e-11,
    -7.45510449620631e-11,
    -2.6260417449824267e-10,
    2.6248030731791732e-09,
    -5.937642934649013e-10,
    -7.00535615043276e-08,
    1.6350179331888476e-07,
    1.9795619117948376e-06,
    -7.3405185545281365e-06,
    -8.079220427446309e-05,
    0.00019713917780504528,
    0.005588816281840148,
    0.03856057042517875,
    0.16189356804102498,
    0.22142954022993183,
)


def _polynomial(variable: Any, coefficients: tuple[float, ...]) -> Any:
    result = variable * coefficients[0] + coefficients[1]
    for c in coefficients[2:]:
        result = result * variable + c
    return result


def erf(x: Any, a: Any) -> Any:
    """Return the error function, within 2.3e-16 of itself; ONNX Runtime has none in float64."""
    size = x.abs(a)
    small = x.maximum(x.minimum(a, 1.0), -1.0)
    near = small * _polynomial(small * small, _NEAR)
    large = x.minimum(x.maximum(size, 1.0), 6.0)
    # 1 / (1 + large / 2) runs from 2/3 to 1/4; shifted and stretched to 1 ... -1.
    t = (1.0 / (1.0 + 0.5 * large) - 0.25) * 4.8 - 1.0
    far = 1.0 - x.exp(-(large * large)) * _polynomial(t, _FAR)
    return x.where(size < 1.0, near, x.where(a < 0.0, -far, far))


def softplus(x: Any, a: Any) -> Any:
    """Return log(1 + exp(a)) without overflow."""
    return x.maximum(a, 0.0) + x.log(1.0 + x.exp(-x.abs(a)))


def expm1_below(x: Any, a: Any) -> Any:
    """Return exp(a) - 1 for a below 0 and 0 above."""
    return x.exp(x.minimum(a, 0.0)) - 1.0


def _gelu(x: Any, a: Any, approximate: str) -> Any:
    if approximate == "tanh":
        return 0.5 * a * (1.0 + x.tanh(math.sqrt(2.0 / math.pi) * (a + 0.044715 * a * a * a)))
    return 0.5 * a * (1.0 + erf(x, a * math.sqrt(0.5)))


def _clamp(x: Any, a: Any, low: float, high: float) -> Any:
    return x.minimum(x.maximum(a, low), high)


def _celu(x: Any, a: Any, alpha: float) -> Any:
    return x.maximum(a, 0.0) + alpha * expm1_below(x, a / alpha)


def _sign(x: Any, a: Any) -> Any:
    return x.where(a > 0.0, 1.0 + 0.0 * a, x.where(a < 0.0, -1.0 + 0.0 * a, 0.0 * a))


#: One operand, with the attributes that the formula takes: names with default values.
FORMULAS: dict[str, tuple[dict[str, float], Callable[..., Any]]] = {
    "Abs": ({}, lambda x, a: x.abs(a)),
    "Cosh": ({}, lambda x, a: 0.5 * (x.exp(a) + x.exp(-a))),
    "Celu": ({"alpha": 1.0}, _celu),
    "Elu": ({"alpha": 1.0}, lambda x, a, alpha: x.maximum(a, 0.0) + alpha * expm1_below(x, a)),
    "Erf": ({}, erf),
    "Exp": ({}, lambda x, a: x.exp(a)),
    "HardSigmoid": (
        {"alpha": 0.2, "beta": 0.5},
        lambda x, a, alpha, beta: _clamp(x, alpha * a + beta, 0.0, 1.0),
    ),
    "HardSwish": ({}, lambda x, a: a * _clamp(x, a * (1.0 / 6.0) + 0.5, 0.0, 1.0)),
    "LeakyRelu": ({"alpha": 0.01}, lambda x, a, alpha: x.where(a < 0.0, alpha * a, a)),
    "Log": ({}, lambda x, a: x.log(a)),
    "Mish": ({}, lambda x, a: a * x.tanh(softplus(x, a))),
    "Neg": ({}, lambda x, a: -a),
    "Reciprocal": ({}, lambda x, a: 1.0 / a),
    "Relu": ({}, lambda x, a: x.relu(a)),
    "Selu": (
        {"alpha": 1.67326319217681884765625, "gamma": 1.05070102214813232421875},
        lambda x, a, alpha, gamma: gamma * (x.maximum(a, 0.0) + alpha * expm1_below(x, a)),
    ),
    "Shrink": (
        {"bias": 0.0, "lambd": 0.5},
        lambda x, a, bias, lambd: x.where(a < -lambd, a + bias, x.where(a > lambd, a - bias, 0.0 * a)),
    ),
    "Sigmoid": ({}, lambda x, a: x.sigmoid(a)),
    "Sign": ({}, _sign),
    "Sinh": ({}, lambda x, a: 0.5 * (x.exp(a) - x.exp(-a))),
    "Softplus": ({}, softplus),
    "Softsign": ({}, lambda x, a: a / (1.0 + x.abs(a))),
    "Sqrt": ({}, lambda x, a: x.sqrt(a)),
    "Swish": ({"alpha": 1.0}, lambda x, a, alpha: a * x.sigmoid(alpha * a)),
    "Tanh": ({}, lambda x, a: x.tanh(a)),
    "ThresholdedRelu": ({"alpha": 1.0}, lambda x, a, alpha: x.where(a > alpha, a, 0.0 * a)),
}
_COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "Less": lambda a, b: a < b,
    "Greater": lambda a, b: a > b,
    "LessOrEqual": lambda a, b: a <= b,
    "GreaterOrEqual": lambda a, b: a >= b,
    "Equal": lambda a, b: ~((a < b) | (a > b)),
}
_BINARY: dict[str, Callable[[Any, Any, Any], Any]] = {
    "Add": lambda x, a, b: a + b,
    "Sub": lambda x, a, b: a - b,
    "Mul": lambda x, a, b: a * b,
    "Div": lambda x, a, b: a / b,
    "Pow": lambda x, a, b: x.power(a, b),
    "Sum": lambda x, a, b: a + b,
    "Max": lambda x, a, b: x.maximum(a, b),
    "Min": lambda x, a, b: x.minimum(a, b),
}


def formula(c: Canvas, v: View) -> Tensor:
    """Translate an operator of `FORMULAS`."""
    defaults, function = FORMULAS[v.op]
    numbers = {k: float(v.attribute(k, d)) for k, d in defaults.items()}
    if v.op == "Celu" and numbers["alpha"] == 0.0:
        raise refuse(c.where, "Celu with alpha 0 is not translated")
    return c.each(v.op, lambda a: function(c.x, a, **numbers), v.tensor(0))


def gelu(c: Canvas, v: View) -> Tensor:
    """Translate Gelu (both forms) and ONNX Runtime's FastGelu and QuickGelu."""
    value = v.tensor(0)
    if v.optional(1) is not None:  # FastGelu and BiasGelu add a bias first
        value = c.each(v.op, lambda a, b: a + b, value, v.tensor(1))
    if v.op == "QuickGelu":
        alpha = float(v.attribute("alpha", 1.702))
        return c.each(v.op, lambda a: a * c.x.sigmoid(alpha * a), value)
    form = "tanh" if v.op == "FastGelu" else str(v.attribute("approximate", "none"))
    return c.each(v.op, lambda a: _gelu(c.x, a, form), value)


def prelu(c: Canvas, v: View) -> Tensor:
    """Translate PRelu: a slope below 0 for every element."""
    return c.each("PRelu", lambda a, s: c.x.where(a < 0.0, s * a, a), v.tensor(0), v.tensor(1))


def binary(c: Canvas, v: View) -> Tensor:
    """Translate arithmetic of two or (Sum, Max, Min, Mean) more operands."""
    op = "Sum" if v.op == "Mean" else v.op
    tensors = v.tensors()
    result = tensors[0]
    for other in tensors[1:]:
        if op == "Div" and result.kind == "int64":
            result = _whole_division(c, result, other)
        else:
            result = c.each(op, lambda a, b: _BINARY[op](c.x, a, b), result, other)
    if v.op == "Mean":
        result = c.each("Mean", lambda a: a / float(len(tensors)), result)
    return result


def _whole_division(c: Canvas, a: Tensor, b: Tensor) -> Tensor:
    if isinstance(a, Constant) and isinstance(b, Constant):
        if (b.array == 0).any():
            raise refuse(c.where, "a whole number is divided by 0")
        return c.each("Div", lambda p, q: np.sign(p) * np.sign(q) * (np.abs(p) // np.abs(q)), a, b)
    return c.each("Div", lambda p, q: c.truncated(p / q), a, b)


def compare(c: Canvas, v: View) -> Tensor:
    """Translate a comparison; float32 values are compared as float32, so that both switch at the same load."""
    tensors = [_as_number(c, t) for t in (v.tensor(0), v.tensor(1))]
    return c.each(v.op, _COMPARE[v.op], *(c.rounded(t) for t in tensors), kind="bool")


def _as_number(c: Canvas, tensor: Tensor) -> Tensor:
    if isinstance(tensor, Symbol):
        return c.number(tensor)
    return Constant(tensor.array.astype(np.float64), "float64") if tensor.kind == "bool" else tensor


def logic(c: Canvas, v: View) -> Tensor:
    """Translate And, Or, Xor and Not."""
    if v.op == "Not":
        return c.each("Not", lambda a: ~a, v.tensor(0), kind="bool")
    functions: dict[str, Callable[[Any, Any], Any]] = {
        "And": lambda a, b: a & b,
        "Or": lambda a, b: a | b,
        "Xor": lambda a, b: (a | b) & ~(a & b),
    }
    return c.each(v.op, functions[v.op], v.tensor(0), v.tensor(1), kind="bool")


def not_a_number(c: Canvas, v: View) -> Tensor:
    """Translate IsNaN and IsInf (NaN is neither below nor above anything)."""
    if v.op == "IsInf":
        low, high = bool(v.attribute("detect_negative", 1)), bool(v.attribute("detect_positive", 1))
        top = float(np.finfo(np.float32 if v.tensor(0).kind == "float32" else np.float64).max)
        bottom = -top if low else -math.inf
        top = top if high else math.inf
        return c.each(v.op, lambda a: (a > top) | (a < bottom), v.tensor(0), kind="bool")
    return c.each(v.op, lambda a: ~((a < 1.0) | (a > 0.0)), v.tensor(0), kind="bool")


def clip(c: Canvas, v: View) -> Tensor:
    """Translate Clip with limits as inputs or attributes."""
    value = v.tensor(0)
    for k, (name, function) in enumerate((("min", c.x.maximum), ("max", c.x.minimum)), start=1):
        limit = v.optional(k)
        if limit is None and v.attribute(name, None) is not None:
            limit = Constant(np.array(float(v.attribute(name, 0.0))), value.kind)
        if limit is not None:
            value = c.each("Clip", function, value, limit)
    return value


def where(c: Canvas, v: View) -> Tensor:
    """Translate Where; a known condition only picks elements."""
    condition, first, second = v.tensor(0), v.tensor(1), v.tensor(2)
    if isinstance(condition, Constant):
        shape = np.broadcast_shapes(condition.shape, first.shape, second.shape)
        c.room(shape, "Where", isinstance(first, Symbol) or isinstance(second, Symbol))
        return c.move("Where", lambda a, b: np.asarray(np.where(condition.array, a, b)), first, second)
    return c.each("Where", c.x.where, condition, first, second, kind=first.kind)


def cast(c: Canvas, v: View) -> Tensor:
    """Translate Cast and CastLike; real numbers stay float64, their kind is remembered for comparisons."""
    value = v.tensor(0)
    if v.op == "CastLike":
        kind = v.tensor(1).kind
    else:
        code = int(v.attribute("to", 0))
        if code not in KINDS:
            raise refuse(c.where, f"Cast to element type {code} is not translated")
        kind = KINDS[code]
    if isinstance(value, Constant):
        array = value.array
        if kind == "int64" and array.dtype.kind == "f":  # NaN and what is too large have no whole number
            array = np.clip(np.nan_to_num(array), -(2.0**62), 2.0**62)
        return Constant(c.typed(array, kind), kind)
    if value.kind == "bool" or kind == "bool":
        if value.kind == kind:
            return value
        if kind == "bool":
            return c.each("Cast", lambda a: (a < 0.0) | (a > 0.0), value, kind="bool")
        return Symbol(c.number(value).node, value.shape, kind)
    if kind == "int64" and value.kind != "int64":
        return c.each("Cast", c.truncated, value, kind="int64")
    return Symbol(value.node, value.shape, kind)


def whole(c: Canvas, v: View) -> Tensor:
    """Translate Floor and Ceil."""
    sign = 1.0 if v.op == "Floor" else -1.0
    value = v.tensor(0)
    if isinstance(value, Constant):
        return c.each(v.op, np.floor if v.op == "Floor" else np.ceil, value)

    def below(a: Any) -> Any:
        part = c.truncated(sign * a)
        return sign * (part - c.x.where(part > sign * a, 1.0 + 0.0 * a, 0.0 * a))

    return c.each(v.op, below, c.rounded(value))
