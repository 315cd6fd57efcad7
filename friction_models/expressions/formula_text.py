"""Formulas written as text, ``C*(sigma_n/10)**a``: read once, then computed with arrays or drawn as an ONNX graph.

Nothing is executed: the text is parsed, and only arithmetic, comparisons in ``where`` and the functions named here are taken.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from ..common import InputError, unknown_name
from ..common.ranges import is_number
from .ops import NumpyOps, Ops, Value

#: Longest text, and deepest nesting.
MAX_TEXT, MAX_DEPTH = 1000, 40
#: Functions by name with their number of operands.
FUNCTIONS = {"exp": 1, "log": 1, "sqrt": 1, "tanh": 1, "abs": 1, "min": 2, "max": 2, "where": 3}
_COMPARE: dict[type[ast.cmpop], Callable[[Value, Value], Value]] = {
    ast.Lt: lambda a, b: a < b,
    ast.LtE: lambda a, b: a <= b,
    ast.Gt: lambda a, b: a > b,
    ast.GtE: lambda a, b: a >= b,
}
_ARITHMETIC: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
}


@dataclass(frozen=True)
class Formula:
    """A parsed formula.

    Examples
    --------
    >>> formula = read_formula("mu0*(1 - exp(-v_rel/v0))", {"mu0", "v0", "v_rel"})
    >>> formula.names
    ('mu0', 'v0', 'v_rel')
    >>> formula.value(NumpyOps(), {"mu0": 0.1, "v0": 1.0, "v_rel": 0.0})
    0.0
    """

    text: str
    #: The names that stand in it, sorted.
    names: tuple[str, ...]
    tree: ast.expr

    def value(self, x: Ops, values: Mapping[str, Value]) -> Value:
        """Return the value where names have `values`: columns, or plain numbers."""
        return _value(self.tree, x, values)


def read_formula(text: object, names: Collection[str], where: str = "formula") -> Formula:
    """Parse a formula in which only `names` may stand.

    Raises InputError: no formula, too long, or something in it that is not allowed.

    Examples
    --------
    >>> read_formula("sigma_n.__class__", {"sigma_n"})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: formula: 'sigma_n.__class__' holds Attribute; allowed: numbers, names, + - * / **, and abs, exp, log, max, min, sqrt, tanh, where
    >>> read_formula("mu1 + 1", {"mu0"})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: formula: unknown name 'mu1'; allowed: mu0; did you mean 'mu0'?
    """
    if not isinstance(text, str) or not 0 < len(text) <= MAX_TEXT:
        raise InputError(
            f"{where}: {text!r:.60} is no formula, allowed: a text of 1 to {MAX_TEXT} characters"
        )
    try:
        tree = ast.parse(text.replace("^", "**").strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise InputError(f"{where}: {text[:60]!r} is no formula, allowed: such as 'mu0*(p/p0)**n'") from None
    found: set[str] = set()
    _check(tree, text, names, found, where, 0)
    return Formula(text, tuple(sorted(found)), tree)


def _check(node: ast.AST, text: str, names: Collection[str], found: set[str], where: str, depth: int) -> None:
    parts: list[ast.AST] = []
    good = depth < MAX_DEPTH
    if isinstance(node, ast.Constant):
        good = good and is_number(node.value) and abs(node.value) < 1e300
    elif isinstance(node, ast.Name):
        if node.id not in names:
            raise unknown_name("name", node.id, names, where)
        found.add(node.id)
    elif isinstance(node, ast.UnaryOp):
        good = good and isinstance(node.op, ast.USub | ast.UAdd)
        parts = [node.operand]
    elif isinstance(node, ast.BinOp):
        good = good and isinstance(node.op, (*_ARITHMETIC, ast.Pow))
        parts = [node.left, node.right]
    elif isinstance(node, ast.Call):
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        good = good and FUNCTIONS.get(name) == len(node.args) and not node.keywords
        parts = list(node.args)
        if good and name == "where":
            test = parts.pop(0)
            good = isinstance(test, ast.Compare) and len(test.ops) == 1 and type(test.ops[0]) in _COMPARE
            if isinstance(test, ast.Compare):
                parts += [test.left, *test.comparators]
    else:
        good = False
    if not good:
        what = type(node).__name__ if depth < MAX_DEPTH else "too many brackets"
        raise InputError(
            f"{where}: {text[:60]!r} holds {what}; allowed: numbers, names, + - * / **, and {', '.join(sorted(FUNCTIONS))}"
        )
    for part in parts:
        _check(part, text, names, found, where, depth + 1)


def _value(node: ast.expr, x: Ops, values: Mapping[str, Value]) -> Value:
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return values[node.id]
    if isinstance(node, ast.UnaryOp):
        inner = _value(node.operand, x, values)
        return -inner if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.BinOp):
        left, right = _value(node.left, x, values), _value(node.right, x, values)
        if isinstance(node.op, ast.Pow):
            return _apply(x, "power", left, right)
        return _ARITHMETIC[type(node.op)](left, right)
    assert isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    if node.func.id == "where":
        test = node.args[0]
        assert isinstance(test, ast.Compare)
        sides = (_value(test.left, x, values), _value(test.comparators[0], x, values))
        truth = _COMPARE[type(test.ops[0])](*sides)
        return x.where(truth, *(_value(a, x, values) for a in node.args[1:]))
    name = {"min": "minimum", "max": "maximum"}.get(node.func.id, node.func.id)
    return _apply(x, name, *(_value(a, x, values) for a in node.args))


def _apply(x: Ops, name: str, *operands: Value) -> Value:
    """Compute a function; of plain numbers at once, so that a graph holds the result alone."""
    if all(isinstance(a, float) for a in operands):
        return float(getattr(NumpyOps(), name)(*operands))
    return getattr(x, name)(*operands)
