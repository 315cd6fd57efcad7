"""The ONNX operators that the generator translates: C expressions, their derivatives, their shapes.

Every operator acts on the row vector of one contact point; whatever mixes points is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .tensors import Array, Attributes, Step, Tensor, broadcast, constant_of, refuse

#: What the expressions below call.
PRELUDE = """\
TF_INLINE double tf_max(double a, double b) { return (a != a || a > b) ? a : b; }
TF_INLINE double tf_min(double a, double b) { return (a != a || a < b) ? a : b; }
TF_INLINE double tf_pow(double a, double b) { return b == 2.0 ? a * a : b == 1.0 ? a : pow(a, b); }
TF_INLINE double tf_pow_da(double a, double b) {
    return a == 0.0 ? (b == 1.0 ? 1.0 : 0.0) : b * tf_pow(a, b - 1.0);
}
TF_INLINE double tf_pow_db(double a, double y) { return a > 0.0 ? y * log(a) : 0.0; }
"""

#: Operators with a kernel for many values at once.
FUNCTIONS = {"Exp": "tf_exp", "Log": "tf_log", "Tanh": "tf_tanh", "Sigmoid": "tf_sigmoid"}

Operands = Sequence[str]
#: Derivatives of the operands; None for one that does not depend on the seed.
Seeds = Sequence[str | None]

#: Value of one element. A NaN in Max, Min or Relu is passed on, as ONNX Runtime does.
ELEMENTWISE: dict[str, Callable[[Operands], str]] = {
    "Add": lambda a: f"({a[0]} + {a[1]})",
    "Sub": lambda a: f"({a[0]} - {a[1]})",
    "Mul": lambda a: f"({a[0]} * {a[1]})",
    "Div": lambda a: f"({a[0]} / {a[1]})",
    "Neg": lambda a: f"(-{a[0]})",
    "Abs": lambda a: f"fabs({a[0]})",
    "Exp": lambda a: f"tf_exp({a[0]}, fused)",
    "Log": lambda a: f"tf_log({a[0]}, fused)",
    "Sqrt": lambda a: f"sqrt({a[0]})",
    "Tanh": lambda a: f"tf_tanh({a[0]}, fused)",
    "Sigmoid": lambda a: f"tf_sigmoid({a[0]}, fused)",
    "Relu": lambda a: f"(({a[0]}) <= 0.0 ? 0.0 : ({a[0]}))",
    "Pow": lambda a: f"tf_pow({a[0]}, {a[1]})",
    "Max": lambda a: _chain("tf_max", a),
    "Min": lambda a: _chain("tf_min", a),
    "Clip": lambda a: f"tf_min(tf_max({a[0]}, {a[1]}), {a[2]})",
    "Less": lambda a: f"(({a[0]}) < ({a[1]}) ? 1.0 : 0.0)",
    "LessOrEqual": lambda a: f"(({a[0]}) <= ({a[1]}) ? 1.0 : 0.0)",
    "Greater": lambda a: f"(({a[0]}) > ({a[1]}) ? 1.0 : 0.0)",
    "GreaterOrEqual": lambda a: f"(({a[0]}) >= ({a[1]}) ? 1.0 : 0.0)",
    "And": lambda a: f"(({a[0]}) != 0.0 && ({a[1]}) != 0.0 ? 1.0 : 0.0)",
    "Or": lambda a: f"(({a[0]}) != 0.0 || ({a[1]}) != 0.0 ? 1.0 : 0.0)",
    "Not": lambda a: f"(({a[0]}) != 0.0 ? 0.0 : 1.0)",
    "Where": lambda a: f"(({a[0]}) != 0.0 ? ({a[1]}) : ({a[2]}))",
    "Identity": lambda a: f"({a[0]})",
}

#: ONNX types that a Cast may go to (float, int32, int64, bool, double); all stay doubles in C.
_CASTS = {
    1: "(double)(float)({0})",
    6: "trunc({0})",
    7: "trunc({0})",
    9: "(({0}) != 0.0 ? 1.0 : 0.0)",
    11: "({0})",
}

#: Operators whose derivative is 0 wherever they have one.
_BY_PIECES = {"And", "Greater", "GreaterOrEqual", "Less", "LessOrEqual", "Not", "Or", "TreeEnsemble"}

#: Operators that take rows apart or put them together.
STRUCTURAL = ("Cast", "Concat", "Gather", "Gemm", "MatMul", "ReduceSum", "Slice", "TreeEnsemble")
SUPPORTED = tuple(sorted((*ELEMENTWISE, *STRUCTURAL)))


def plain_name(step: Step) -> str:
    """Return the key of `ELEMENTWISE` of a step; a Cast passes on what `cast` returns."""
    return "Identity" if step.op == "Cast" else step.op


def cast(step: Step, a: str) -> str:
    """Return the value of a Cast: rounded to single precision, cut to an integer, or a truth value."""
    return _CASTS[step.attributes.whole("to")].format(a)


def differentiated(step: Step) -> list[Tensor]:
    """Return the operands that the derivative of a step depends on."""
    operands = [t for t in step.inputs if t is not None]
    if step.op in _BY_PIECES or (step.op == "Cast" and step.attributes.whole("to") in {6, 7, 9}):
        return []
    if step.op == "Where":
        return operands[1:]
    return operands[:1] if step.op in {"Gather", "Slice", "Gemm", "MatMul", "ReduceSum"} else operands


def _chain(function: str, operands: Operands) -> str:
    result = operands[0]
    for operand in operands[1:]:
        result = f"{function}({result}, {operand})"
    return result


def _sum(terms: Sequence[str | None]) -> str | None:
    present = [t for t in terms if t is not None]
    return " + ".join(present) if present else None


def _times(factor: str, seed: str | None) -> str | None:
    return None if seed is None else f"({factor}) * ({seed})"


def _choose(condition: str, first: str | None, second: str | None) -> str | None:
    if first is None and second is None:
        return None
    return f"(({condition}) ? ({first or '0.0'}) : ({second or '0.0'}))"


def derivative(op: str, y: str, a: Operands, d: Seeds) -> str | None:
    """Return the forward derivative of one element of value `y`, or None when it is zero.

    `a` and `d` are the operands and their derivatives. At a kink the derivative is the one of the branch that the value
    takes; where it is infinite (sqrt at 0, power below 1 at 0) it is 0.
    """
    match op:
        case "Add":
            return _sum([d[0], d[1]])
        case "Sub":
            return _sum([d[0], _times("-1.0", d[1])])
        case "Mul":
            return _sum([_times(a[1], d[0]), _times(a[0], d[1])])
        case "Div":
            return _sum([_times(f"1.0 / ({a[1]})", d[0]), _times(f"-({y}) / ({a[1]})", d[1])])
        case "Neg":
            return _times("-1.0", d[0])
        case "Abs":
            return _times(f"({a[0]}) < 0.0 ? -1.0 : 1.0", d[0])
        case "Exp":
            return _times(y, d[0])
        case "Log":
            return _times(f"1.0 / ({a[0]})", d[0])
        case "Sqrt":
            return _times(f"({y}) > 0.0 ? 0.5 / ({y}) : 0.0", d[0])
        case "Tanh":
            return _times(f"1.0 - ({y}) * ({y})", d[0])
        case "Sigmoid":
            return _times(f"({y}) * (1.0 - ({y}))", d[0])
        case "Relu":
            return _choose(f"({a[0]}) <= 0.0", None, d[0])
        case "Pow":
            return _sum([_times(f"tf_pow_da({a[0]}, {a[1]})", d[0]), _times(f"tf_pow_db({a[0]}, {y})", d[1])])
        case "Max":
            return _extreme(">", "tf_max", a, d)
        case "Min":
            return _extreme("<", "tf_min", a, d)
        case "Clip":
            return _choose(f"({a[0]}) < ({a[1]})", d[1], _choose(f"({a[0]}) > ({a[2]})", d[2], d[0]))
        case "Where":
            return _choose(f"({a[0]}) != 0.0", d[1], d[2])
        case "Identity":
            return d[0]
    return None  # comparisons and logic are constant by pieces


def _extreme(sign: str, function: str, a: Operands, d: Seeds) -> str | None:
    value, seed = a[0], d[0]
    for operand, other in zip(a[1:], d[1:]):
        seed = _choose(f"({value}) {sign} ({operand})", seed, other)
        value = f"{function}({value}, {operand})"
    return seed


def infer_shape(
    op: str, domain: str, attributes: Attributes, inputs: Sequence[Tensor | None], where: str
) -> tuple[int, ...]:
    """Return the shape of a node's output with the batch dimension 1.

    Raises InputError: the operator is not translated, or it mixes contact points.
    """
    expected = "ai.onnx.ml" if op == "TreeEnsemble" else ""
    if op not in SUPPORTED or domain not in {expected, expected or "ai.onnx"}:
        full = f"{domain}.{op}" if domain else op
        raise refuse(where, f"operator {full} is not translated to C, allowed: {', '.join(SUPPORTED)}")
    first = inputs[0]
    assert first is not None
    if op in ELEMENTWISE:
        return broadcast([t.shape for t in inputs if t is not None], op, where)
    if op == "Cast":
        to = attributes.whole("to")
        if to not in _CASTS:
            raise refuse(
                where, f"Cast to type {to} is not translated, allowed: {', '.join(map(str, _CASTS))}"
            )
        return first.shape
    if op in {"MatMul", "Gemm"}:
        weights = constant_of(inputs[1], f"the matrix of a {op}", where)
        if attributes.whole("transA", 0) or weights.ndim != 2 or len(first.shape) != 2:
            raise refuse(where, f"{op} with a transposed or not two-dimensional operand is not translated")
        rows, columns = weights.shape[::-1] if attributes.whole("transB", 0) else weights.shape
        if first.shape[1] != rows:
            raise refuse(where, f"{op} of {first.shape} with {weights.shape} does not fit")
        return (1, int(columns))
    if op == "TreeEnsemble":
        targets = attributes.whole("n_targets", 1)
        kinds = set(attributes.array("nodes_modes").tolist())
        if targets != 1 or attributes.whole("post_transform", 0) != 0 or kinds - {0}:
            raise refuse(where, "TreeEnsemble other than a sum of <= trees with one target is not translated")
        if attributes.whole("aggregate_function", 1) != 1:
            raise refuse(where, "TreeEnsemble that does not sum its trees is not translated")
        return (1, 1)
    if op == "ReduceSum":
        axes = reduce_axes(attributes, inputs, where)
        if len(first.shape) != 2 or axes != [1]:
            raise refuse(where, f"ReduceSum over axes {axes} of a value of shape {first.shape} mixes points")
        return (1, 1) if attributes.whole("keepdims", 1) else (1,)
    picked = picks(op, attributes, inputs, where)
    if op == "Gather" and np.ndim(constant_of(inputs[1], "the index of a Gather", where)) == 0:
        return (1,)
    return (1, len(picked))


def reduce_axes(attributes: Attributes, inputs: Sequence[Tensor | None], where: str) -> list[int]:
    """Return the axes of a ReduceSum, counted from the front."""
    first = inputs[0]
    assert first is not None
    if len(inputs) > 1 and inputs[1] is not None:
        axes = np.ravel(constant_of(inputs[1], "the axes of a ReduceSum", where)).tolist()
    else:
        axes = attributes.array("axes").tolist() if "axes" in attributes else list(range(len(first.shape)))
    return [int(a) % len(first.shape) for a in axes]


def picks(
    op: str, attributes: Attributes, inputs: Sequence[Tensor | None], where: str
) -> list[tuple[Tensor, int]]:
    """Return, for every element of the output of Gather, Slice or Concat, where it comes from."""
    first = inputs[0]
    assert first is not None
    if any(t is not None and len(t.shape) != 2 for t in (inputs if op == "Concat" else [first])):
        raise refuse(where, f"{op} of a value that is not two-dimensional is not translated")
    if op in {"Concat", "Gather"} and attributes.whole("axis", 0) % 2 != 1:
        raise refuse(where, f"{op} along axis 0 mixes points")
    if op == "Concat":
        return [(t, i) for t in inputs if t is not None for i in range(t.size)]
    columns = range(first.shape[1])
    if op == "Gather":
        index = np.ravel(constant_of(inputs[1], "the index of a Gather", where))
        return [(first, columns[int(i)]) for i in index]
    parts: list[Array] = [constant_of(t, "a limit of a Slice", where) for t in inputs[1:] if t is not None]
    starts, ends = np.ravel(parts[0]).tolist(), np.ravel(parts[1]).tolist()
    axes = np.ravel(parts[2]).tolist() if len(parts) > 2 else list(range(len(starts)))
    steps = np.ravel(parts[3]).tolist() if len(parts) > 3 else [1] * len(starts)
    if [int(a) % 2 for a in axes] != [1]:
        raise refuse(where, "Slice along axis 0 mixes points")
    return [(first, i) for i in columns[int(starts[0]) : int(ends[0]) : int(steps[0])]]
