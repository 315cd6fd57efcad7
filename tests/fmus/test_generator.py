"""Every operator of the generated C against ONNX Runtime; what is not translated is refused by name."""

from __future__ import annotations

from typing import Any

import numpy as np
import onnx
import pytest

from fmus.interface.friction_source import parse_source
from fmus.native import graph, ops
from fmus.native.generate import generate
from friction_models.common import InputError
from tests.fmus.compiled import Compiled
from tests.fmus.graphs import Array, graph_bytes, inside, node, random_loads, runtime

SCALE = node("Mul", "loads s", "x")
SCALES = {
    "s": np.array([[1e-3, 1e-3, 3e-4, 1e-2, 5e-2]]),
    "one": np.array([[1.0]]),
    "low": np.array(0.2),
    "high": np.array(0.7),
}
#: Nodes that turn x, shape (n, 5) around 0.01 to 1, into y of any width.
CASES: dict[str, list[onnx.NodeProto]] = {
    **{op: [node(op, "x", "y")] for op in ("Exp", "Log", "Sqrt", "Tanh", "Sigmoid", "Abs", "Identity", "Neg")},
    "Relu": [node("Sub", "x low", "a"), node("Relu", "a", "y")],
    "Add": [node("Add", "x low", "y")],
    "Sub": [node("Sub", "low x", "y")],
    "Mul": [node("Mul", "x x", "y")],
    "Div": [node("Div", "low x", "y")],
    "Pow": [node("Pow", "x high", "a"), node("Pow", "low x", "b2"), node("Mul", "a b2", "y")],
    "Max": [node("Max", "x low", "y")],
    "Min": [node("Min", "x low", "y")],
    "Clip": [node("Clip", "x low high", "y")],
    "Less": [node("Less", "x low", "a"), node("Where", "a x high", "y")],
    "Greater": [node("Greater", "x low", "a"), node("Where", "a x high", "y")],
    "And": [node("Less", "x high", "a"), node("Greater", "x low", "b2"), node("And", "a b2", "c"), node("Where", "c x low", "y")],
    "Or": [node("Greater", "x high", "a"), node("Less", "x low", "b2"), node("Or", "a b2", "c"), node("Where", "c x high", "y")],
    "Not": [node("Less", "x low", "a"), node("Not", "a", "b2"), node("Where", "b2 x high", "y")],
    "LessOrEqual": [node("LessOrEqual", "x low", "a"), node("Where", "a x high", "y")],
    "GreaterOrEqual": [node("GreaterOrEqual", "x low", "a"), node("Where", "a x high", "y")],
    "Cast": [node("Greater", "x low", "a"), node("Cast", "a", "b2", to=11), node("Mul", "b2 x", "y")],
    "MatMul": [node("MatMul", "x w", "y")],
    "Gemm": [node("Gemm", "x wt b", "y", transB=1, alpha=0.5, beta=2.0)],
    "ReduceSum": [node("Mul", "x x", "a"), node("ReduceSum", "a axis", "y")],
    "Gather": [node("Gather", "x pick", "y", axis=1)],
    "Slice": [node("Slice", "x from to axis", "y")],
    "Concat": [node("Exp", "x", "e"), node("Concat", "x e", "y", axis=1)],
}  # fmt: skip
RNG = np.random.default_rng(11)
CONSTANTS = SCALES | {
    "w": RNG.normal(size=(5, 7)),
    "wt": RNG.normal(size=(3, 5)),
    "b": RNG.normal(size=3),
    "axis": np.array([1]),
    "pick": np.array([3, 0, -1]),
    "from": np.array([1]),
    "to": np.array([4]),
}


def case(op: str) -> bytes:
    tail = [node("ReduceSum", "y axis", "t"), node("Abs", "t", "mu")]
    nodes = [SCALE, *CASES[op], *tail]
    used = {name for n in nodes for name in n.input}
    return graph_bytes(nodes, {k: v for k, v in CONSTANTS.items() if k in used})


def mixed() -> bytes:
    """Return a graph of what is the same for all points, what is not, and both together."""
    nodes = [
        node("Mul", "loads s", "x"),
        node("Gather", "loads second", "T", axis=1),
        node("Exp", "system", "e"),
        node("MatMul", "e u", "p"),
        node("Tanh", "p", "q"),
        node("Mul", "x q", "xq"),
        node("Sub", "xq system", "low"),
        node("Gather", "q first", "q1", axis=1),
        node("Mul", "T tiny", "T1"),
        node("Clip", "low nought", "above"),
        node("Clip", "xq  high", "below"),
        node("Min", "xq T1", "within"),
        node("Add", "q1 T1", "spread"),
        node("Concat", "above below spread within", "all", axis=1),
        node("Gather", "all pick", "picked", axis=1),
        node("Abs", "picked", "size"),
        node("Add", "size T1", "moved"),
        node("Tanh", "size", "t"),
        node("Concat", "t moved", "wide", axis=1),
        node("ReduceSum", "wide axis", "sum"),
        node("Sigmoid", "sum", "mu"),
    ]
    constants = {
        "s": SCALES["s"],
        "u": np.linspace(0.1, 1.0, 5)[None, :],
        "second": np.array([1]),
        "first": np.array([0]),
        "tiny": np.array(2e-3),
        "nought": np.array(0.0),
        "high": np.array(0.3),
        "pick": np.array([10, 3, 2, 5, 4, 12]),
        "axis": np.array([1]),
    }
    variable = {"name": "Ra", "unit": "um", "start": 0.4}
    return graph_bytes(nodes, constants, {"system": [1, 1]}, metadata={"system": [variable]})


def broad(width: int) -> bytes:
    """Return a network that is too wide for a block of points on the stack (600), or for a point (60 000)."""
    rng = np.random.default_rng(2)
    constants = {"w": rng.normal(size=(5, width)) / 500.0, "u": rng.normal(size=(width, 1)) / width}
    nodes = [node("MatMul", "loads w", "h"), node("Tanh", "h", "t"), node("MatMul", "t u", "y")]
    return graph_bytes([*nodes, node("Abs", "y", "mu")], constants)


def trees(**changes: Any) -> bytes:
    attributes: dict[str, Any] = {
        "n_targets": 1,
        "aggregate_function": 1,
        "tree_roots": [0, 2],
        "nodes_featureids": [0, 1, 4],
        "nodes_splits": onnx.numpy_helper.from_array(np.array([200.0, 100.0, 5.0])),
        "nodes_modes": onnx.numpy_helper.from_array(np.zeros(3, dtype=np.uint8)),
        "nodes_truenodeids": [1, 0, 3],
        "nodes_trueleafs": [0, 1, 1],
        "nodes_falsenodeids": [2, 1, 4],
        "nodes_falseleafs": [1, 1, 1],
        "leaf_targetids": [0] * 5,
        "leaf_weights": onnx.numpy_helper.from_array(np.array([0.01, 0.02, 0.03, 0.1, 0.2])),
    }
    return graph_bytes([node("TreeEnsemble", "loads", "mu", domain="ai.onnx.ml", **(attributes | changes))])


@pytest.fixture(scope="module")
def operators(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    contents = {op: case(op) for op in CASES}
    contents |= {"mixed": mixed(), "TreeEnsemble": trees(), "broad": broad(600)}
    # What the compiler makes of it at -O3, `test_parity` sees.
    return Compiled(contents, tmp_path_factory.mktemp("operators"), "-O1")


def compare_values(
    operators: Compiled, name: str, loads: Array, expected: Array, system: Array | None = None
) -> None:
    """Compare with ONNX Runtime, and one point with blocks of points."""
    for build in operators.builds():
        mu = operators.mu(name, loads, None, system, build)
        np.testing.assert_allclose(mu, expected, rtol=1e-12, atol=1e-14)
        assert np.array_equal(operators.mu(name, loads, None, system, build, 5), mu)


def compare_derivatives(operators: Compiled, name: str, loads: Array, along: Array, system: Array) -> None:
    """Compare with central differences; a point close to a kink may differ."""
    seeds = (along, np.zeros((len(loads), 0)), np.ones(len(system)))
    _, got = operators.derivative("mu", name, (loads, None, system), seeds)
    h = 1e-6
    ahead, behind = (operators.mu(name, loads + s * along, None, system + s) for s in (h, -h))
    assert np.isclose(got, (ahead - behind) / (2.0 * h), rtol=1e-6, atol=1e-8).mean() > 0.98
    assert np.abs(got).max() > 0.0


@pytest.mark.parametrize("op", CASES)
def test_operator_agrees_with_onnx_runtime_and_with_its_derivative(op: str, operators: Compiled) -> None:
    loads = inside(random_loads(400))
    loads[:, 3] += 1e-3  # Log needs a positive sliding distance
    expected = runtime(case(op), loads)
    assert np.ptp(expected) > 0.0
    compare_values(operators, op, loads, expected)
    along = np.random.default_rng(4).normal(size=loads.shape) * loads
    compare_derivatives(operators, op, loads, along, np.zeros(0))


def test_values_of_the_system_stand_beside_those_of_the_points(operators: Compiled) -> None:
    loads = inside(random_loads(300))
    for value in (0.01, 0.2, 0.4):
        system = np.array([value])
        expected = runtime(mixed(), loads, system=system[None, :])
        compare_values(operators, "mixed", loads, expected, system)
        compare_derivatives(operators, "mixed", loads, np.zeros_like(loads), system)


def test_every_translated_operator_has_a_case() -> None:
    assert set(CASES) | {"Where", "TreeEnsemble"} == set(ops.SUPPORTED)


def test_a_broad_network_runs_point_by_point(operators: Compiled) -> None:
    loads = random_loads(100)
    compare_values(operators, "broad", loads, runtime(broad(600), loads))


def test_trees_agree_with_onnx_runtime_also_on_a_split(operators: Compiled) -> None:
    loads = random_loads(60)
    loads[0, 0], loads[1, 1], loads[2, 4] = 200.0, 100.0, 5.0
    expected = runtime(trees(), loads)
    compare_values(operators, "TreeEnsemble", loads, expected)
    assert len(np.unique(expected)) == 6


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"nodes_truenodeids": [1, 0, 9]}, "leaf 9, which does not exist"),
        ({"nodes_truenodeids": [7, 0, 3]}, "node 7, which does not exist"),
        ({"nodes_truenodeids": [0, 0, 3]}, "node 0 twice"),
        ({"nodes_truenodeids": [-1, 0, 3]}, "node -1"),
        ({"tree_roots": [0, 1]}, "node 1 twice"),
        ({"nodes_featureids": [0, 5, 4]}, "feature 5, allowed: 0 to 4"),
        ({"nodes_featureids": [0, 1]}, "different lengths"),
    ],
)
def test_trees_that_are_none_are_refused(changes: dict[str, Any], words: str) -> None:
    source = parse_source(trees(**changes), "m.onnx")
    with pytest.raises(InputError, match=words):
        generate(source, source.interface(1))


#: Concatenated with itself again and again, 20 times.
DOUBLED = [node("Concat", f"a{k} a{k}", f"a{k + 1}", axis=1) for k in range(20)]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (broad(60_000), "60000 values a point, allowed: 16384; pack it with --target python"),
        (graph_bytes([node("Identity", "loads", "a0"), *DOUBLED]), "20480 values a point"),
        (
            graph_bytes([node("Gather", "loads six", "mu", axis=1)], {"six": np.array([6])}),
            "breaks the rules",
        ),
        (graph_bytes([node("Cast", "loads", "mu")]), "breaks the rules"),
        (graph_bytes([node("Exp", "nowhere", "mu")]), "uses 'nowhere', which does not exist"),
    ],
)
def test_graphs_that_cannot_be_are_refused(content: bytes, words: str) -> None:
    source = parse_source(content, "m.onnx")
    with pytest.raises(InputError, match=words):
        generate(source, source.interface(1))


def test_graphs_with_more_numbers_than_compilers_take_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(graph, "MAX_CONSTANTS", 50)
    source = parse_source(broad(10), "m.onnx")
    with pytest.raises(InputError, match="the graph holds 60 numbers, allowed: 50; pack it with --target py"):
        generate(source, source.interface(1))


@pytest.mark.parametrize(
    ("nodes", "constants", "words"),
    [
        ([node("Erf", "loads", "mu")], {}, "operator Erf is not translated"),
        ([node("ReduceSum", "loads zero", "mu")], {"zero": np.array([0])}, "mixes points"),
        ([node("Gather", "loads zero", "mu", axis=0)], {"zero": np.array([0])}, "mixes points"),
        ([node("Exp", "loads", "a"), node("MatMul", "a a", "mu")], {}, "the matrix of a MatMul"),
        ([node("Tanh", "loads", "mu", domain="com.microsoft")], {}, "operator com.microsoft.Tanh"),
        ([node("Cast", "loads", "mu", to=10)], {}, "Cast to type 10"),
    ],
)
def test_what_is_not_translated_is_refused_and_points_to_python(
    nodes: list[onnx.NodeProto], constants: dict[str, Array], words: str
) -> None:
    source = parse_source(graph_bytes(nodes, constants), "m.onnx")
    with pytest.raises(InputError, match=words) as caught:
        generate(source, source.interface(1))
    assert "--target python" in str(caught.value)
