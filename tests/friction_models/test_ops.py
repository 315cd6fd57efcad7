"""One formula, two back ends: whatever NumPy computes, the ONNX graph gives too."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import onnxruntime
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_models.expressions.onnx_graph import GraphBuilder, Node, OnnxOps
from friction_models.expressions.ops import LoadColumns, NumpyOps

ALLOWED = {
    "Add",
    "Sub",
    "Mul",
    "Div",
    "Neg",
    "Exp",
    "Log",
    "Sqrt",
    "Tanh",
    "Sigmoid",
    "Abs",
    "Relu",
    "Max",
    "Min",
    "Pow",
    "Less",
    "Greater",
    "And",
    "Or",
    "Not",
    "Where",
    "Gemm",
    "MatMul",
    "Gather",
    "Slice",
    "Concat",
    "ReduceSum",
    "Cast",
    "Identity",
    "Clip",
    "TreeEnsemble",
}
WEIGHTS = np.arange(10.0).reshape(5, 2) / 7
Formula = Callable[[Any, LoadColumns], Any]

FORMULAS: dict[str, Formula] = {
    "add": lambda x, L: 1.5 + L.T + L.sd,
    "sub": lambda x, L: 1.5 - L.T - 2.0 + L.sd,
    "mul": lambda x, L: 2.0 * L.T * L.sd,
    "div": lambda x, L: 3.0 / (1.0 + L.sd) + L.T / 7.0,
    "neg": lambda x, L: -L.T,
    "pow": lambda x, L: (L.sd + 1.0) ** 0.37 + 1.01**L.psi + x.power(L.psi, 2.0),
    "exp": lambda x, L: x.exp(-L.v_rel / 100.0),
    "log": lambda x, L: x.log(1.0 + L.v_rel),
    "sqrt": lambda x, L: x.sqrt(L.sigma_n),
    "tanh": lambda x, L: x.tanh(L.T / 50.0),
    "sigmoid": lambda x, L: x.sigmoid((L.T - 100.0) / 5.0),
    "abs": lambda x, L: x.abs(L.T - 100.0) + abs(L.sd - 3.0),
    "relu": lambda x, L: x.relu(L.T - 100.0),
    "max_min": lambda x, L: x.maximum(L.T, L.sd) + x.minimum(L.psi, 3.0),
    "where": lambda x, L: x.where(L.T < 100.0, L.sd, 2.0),
    "logic": lambda x, L: x.where((L.T <= 100.0) & (L.sd > 5.0) | ~(L.psi >= 2.0), 1.0, L.sd),
    "constant_condition": lambda x, L: x.where(np.array([[True]]), L.sd, L.T),
    "matmul": lambda x, L: x.reduce_sum(x.matmul(x.concat(L.columns()), WEIGHTS)),
    "gemm": lambda x, L: x.column(x.matmul(x.concat(L.columns()), WEIGHTS, [1.0, 2.0]), 1),
    "constant": lambda x, L: x.constant(0.08, L.T),
    "plain_numbers": lambda x, L: (
        L.T * (x.exp(1.0) + x.log(2.0) + x.maximum(1.0, 2.0)) + x.sqrt(np.array([[4.0]]))
    ),
    "numpy_on_the_left": lambda x, L: np.float64(2.0) * L.T + np.array([[3.0]]) - L.sd,
}


def run_both(formula: Formula, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray, set[str]]:
    """Return what NumPy and ONNX Runtime give, and the operators of the graph."""
    numbers = NumpyOps()
    expected = np.asarray(formula(numbers, LoadColumns.from_matrix(numbers, loads)))
    graph = GraphBuilder()
    x = OnnxOps(graph)
    result = formula(x, LoadColumns.from_matrix(x, graph.input("loads", ["n", 5])))
    graph.output("mu", result, ["n", 1])
    model = graph.build()
    got = onnxruntime.InferenceSession(model.SerializeToString()).run(None, {"loads": loads})[0]
    return expected, got, {n.op_type for n in model.graph.node}


@pytest.mark.parametrize("name", FORMULAS)
def test_numpy_and_onnx_agree_and_only_allowed_operators_appear(name: str) -> None:
    loads = np.random.default_rng(1).uniform(0, 200, (64, 5))
    expected, got, operators = run_both(FORMULAS[name], loads)
    assert expected.shape == got.shape == (64, 1)
    assert got.dtype == np.float64
    np.testing.assert_allclose(got, expected, rtol=1e-13, atol=1e-13)
    assert operators <= ALLOWED


UNARY = ["tanh", "sigmoid", "abs", "relu", "neg", "softened_log"]
BINARY = ["add", "sub", "mul", "max", "min", "where"]


@st.composite
def random_formula(draw: st.DrawFn) -> Formula:
    steps = draw(
        st.lists(
            st.tuples(st.sampled_from(UNARY + BINARY), st.integers(0, 9), st.integers(0, 9)),
            min_size=1,
            max_size=12,
        )
    )

    def formula(x: Any, L: LoadColumns) -> Any:
        values = [c / 100.0 for c in L.columns()] + [0.5, -1.25]
        table: dict[str, Callable[..., Any]] = {
            "tanh": x.tanh,
            "sigmoid": x.sigmoid,
            "abs": x.abs,
            "relu": x.relu,
            "neg": lambda a: -a,
            "softened_log": lambda a: x.log(1.0 + x.abs(a)),
            "add": lambda a, b: a + b,
            "sub": lambda a, b: a - b,
            "mul": lambda a, b: x.tanh(a) * b,
            "max": x.maximum,
            "min": x.minimum,
            "where": lambda a, b: x.where(L.T < 100.0, a, b),
        }
        for name, i, j in steps:
            operands = [values[i % len(values)], values[j % len(values)]]
            values.append(table[name](*operands[: 1 if name in UNARY else 2]))
        return values[-1] + 0.0 * L.T

    return formula


@settings(max_examples=40, deadline=None)
@given(random_formula())
def test_any_composition_agrees(formula: Formula) -> None:
    loads = np.random.default_rng(2).uniform(0, 300, (16, 5))
    expected, got, _ = run_both(formula, loads)
    np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-13)


def test_equal_expressions_become_one_node_and_equal_constants_one_initializer() -> None:
    graph = GraphBuilder()
    x = OnnxOps(graph)
    L = LoadColumns.from_matrix(x, graph.input("loads", ["n", 5]))
    graph.output("mu", x.exp(L.T * 0.5) + x.exp(L.T * 0.5) + 0.5, ["n", 1])
    model = graph.build()
    assert [n.op_type for n in model.graph.node].count("Exp") == 1
    assert sum(t.data_type == 11 for t in model.graph.initializer) == 1


def test_a_formula_cannot_branch_on_a_load() -> None:
    graph = GraphBuilder()
    loads = graph.input("loads", ["n", 5])
    assert isinstance(loads, Node)
    with pytest.raises(TypeError, match=r"x\.where"):
        bool(loads > 1.0)
    with pytest.raises(TypeError, match="equality"):
        _ = loads == 1.0
    with pytest.raises(TypeError, match=r"x\.column"):
        iter(loads)


def test_sigmoid_is_right_where_the_exponential_overflows() -> None:
    x = NumpyOps()
    with np.errstate(all="raise"):
        np.testing.assert_array_equal(x.sigmoid(np.array([[-1e4], [0.0], [1e4]])), [[0.0], [0.5], [1.0]])
