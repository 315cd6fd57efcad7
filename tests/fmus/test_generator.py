"""Every operator of the generated C against ONNX Runtime; what is not translated is refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import pytest

from fmus import pack
from fmus.native import ops
from fmus.native.generate import generate
from fmus.running import RunningFmu, UnpackedFmu
from fmus.source import parse_source
from friction_models.loads import LOAD_NAMES, InputError
from tests.fmus.graphs import Array, graph_bytes, inside, node, random_loads, runtime, save

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


def evaluate(path: Path, loads: Array, clamp: bool = True) -> Array:
    with RunningFmu(UnpackedFmu(path)) as fmu:
        fmu.set({"clamp_to_domain": clamp})
        mu = np.empty(len(loads))
        for i, row in enumerate(loads):
            fmu.set_real(LOAD_NAMES, row)
            mu[i] = fmu.get_real(["mu"])[0]
    return mu


@pytest.mark.parametrize("op", CASES)
def test_operator_agrees_with_onnx_runtime_and_with_its_derivative(op: str, tmp_path: Path) -> None:
    content = case(op)
    path = pack(save(content, tmp_path / "m.onnx"), tmp_path / "m.fmu")
    loads = inside(random_loads(40))
    loads[:, 3] += 1e-3  # Log needs a positive sliding distance
    mu = evaluate(path, loads)
    expected = runtime(content, loads)
    assert np.ptp(expected) > 0.0
    np.testing.assert_allclose(mu, expected, rtol=1e-12, atol=1e-14)
    compare_derivatives(path)


def test_every_translated_operator_has_a_case() -> None:
    assert set(CASES) | {"Where", "TreeEnsemble"} == set(ops.SUPPORTED)


def test_trees_agree_with_onnx_runtime_also_on_a_split(tmp_path: Path) -> None:
    trees = node(
        "TreeEnsemble",
        "loads",
        "mu",
        domain="ai.onnx.ml",
        n_targets=1,
        aggregate_function=1,
        tree_roots=[0, 2],
        nodes_featureids=[0, 1, 4],
        nodes_splits=onnx.numpy_helper.from_array(np.array([200.0, 100.0, 5.0])),
        nodes_modes=onnx.numpy_helper.from_array(np.zeros(3, dtype=np.uint8)),
        nodes_truenodeids=[1, 0, 3],
        nodes_trueleafs=[0, 1, 1],
        nodes_falsenodeids=[2, 1, 4],
        nodes_falseleafs=[1, 1, 1],
        leaf_targetids=[0] * 5,
        leaf_weights=onnx.numpy_helper.from_array(np.array([0.01, 0.02, 0.03, 0.1, 0.2])),
    )
    content = graph_bytes([trees])
    loads = random_loads(60)
    loads[0, 0], loads[1, 1], loads[2, 4] = 200.0, 100.0, 5.0
    mu = evaluate(pack(save(content, tmp_path / "m.onnx"), tmp_path / "m.fmu"), loads)
    expected = runtime(content, loads)
    np.testing.assert_allclose(mu, expected, rtol=1e-12)
    assert len(np.unique(expected)) == 6


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


def compare_derivatives(path: Path) -> None:
    """Compare directional derivatives with central differences."""
    rng = np.random.default_rng(4)
    with RunningFmu(UnpackedFmu(path)) as fmu:
        for row in inside(random_loads(10, seed=9, outside=False)) + 1e-3:
            seed = rng.normal(size=5) * row

            def mu_at(loads: Array, fmu: RunningFmu = fmu) -> float:
                fmu.set_real(LOAD_NAMES, loads)
                return float(fmu.get_real(["mu"])[0])

            h = 1e-6
            central = (mu_at(row + h * seed) - mu_at(row - h * seed)) / (2.0 * h)
            fmu.set_real(LOAD_NAMES, row)
            got = fmu.slave.getDirectionalDerivative([5], range(5), seed)[0]
            assert got == pytest.approx(central, rel=1e-6, abs=1e-8)
