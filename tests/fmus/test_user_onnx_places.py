"""Where loads enter a foreign graph, in which unit, what the YAML says, and what is refused."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import time
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from fmus import check, pack
from fmus.runtime.running import RunningFmu, UnpackedFmu
from fmus.source.reading import read_source
from fmus.user_onnx import attempt, read_user_model
from fmus.user_onnx.operators import arithmetic
from fmus.user_onnx.spec import Spec
from friction_models import ConstantFriction, OnnxModel
from friction_models.common import InputError
from friction_models.common.processes import timed
from friction_models.common.processes.child_processes import python_command
from friction_models.loads import LOAD_NAMES, LOADS
from tests.fmus.foreign import DOUBLE, FLOAT, Array, forest, model_bytes, node
from tests.fmus.graphs import random_loads, runtime, save

#: mu = 0.1 + sum of weight * load, in the contract's units.
WEIGHTS = np.array([1e-5, 2e-5, 3e-6, 4e-4, 5e-4])
LINE = [node("Mul", "in w", "p"), node("ReduceSum", "p axis", "s"), node("Add", "s c", "out")]
CONSTANTS = {"w": WEIGHTS, "c": np.array(0.1), "axis": np.array([1])}


def line(**more: Any) -> bytes:
    return model_bytes([onnx.NodeProto.FromString(n.SerializeToString()) for n in LINE], CONSTANTS, **more)


def true_line(loads: Array) -> Array:
    return 0.1 + loads @ WEIGHTS.astype(np.float32).astype(float)


def lowered(content: bytes, spec: object = None) -> Array:
    """Return mu of the redrawn graph at `random_loads(20)`."""
    given = None if spec is None else Spec.from_dict(spec)
    return runtime(read_user_model(content, "m.onnx", given).onnx, random_loads(20))


LOADED = random_loads(20)


@pytest.mark.parametrize("shape", [["n", 5], [1, 5], [None, 5], [None, None], None])
@pytest.mark.parametrize("kind", [FLOAT, DOUBLE])
def test_one_input_of_any_shape(shape: list[Any] | None, kind: int) -> None:
    mu = lowered(line(inputs={"in": shape}, kind=kind))
    np.testing.assert_allclose(mu, true_line(LOADED), rtol=1e-6)


@pytest.mark.parametrize("shape", [["n", 1], ["n"], [1, 1], [1], []])
@pytest.mark.parametrize("output", [None, ["n"], ["n", 1]])
def test_five_inputs_in_order_or_by_their_names(shape: list[Any], output: list[Any] | None) -> None:
    """Five inputs called like the loads take these, whatever their order; others are counted."""
    for names in (["a", "b", "c", "d", "e"], ["psi", "T", "sd", "v_rel", "sigma_n"]):
        nodes, total = [], "zero"
        for k, name in enumerate(names):
            weight = LOAD_NAMES.index(name) if name in LOAD_NAMES else k
            nodes += [node("Mul", f"{name} w{weight}", f"m{k}"), node("Add", f"{total} m{k}", f"t{k}")]
            total = f"t{k}"
        nodes.append(node("Identity", total, "out"))
        constants = {f"w{k}": np.array(w) for k, w in enumerate(WEIGHTS)} | {"zero": np.array(0.1)}
        outputs = {"out": output} if len(shape) != 0 or output is None else {"out": None}
        content = model_bytes(nodes, constants, dict.fromkeys(names, shape), outputs)
        np.testing.assert_allclose(lowered(content), true_line(LOADED), rtol=1e-6)


def test_units_places_and_scaling_of_the_yaml() -> None:
    spec = {
        "inputs": {
            "v_rel": {"column": 4, "unit": "m/s", "range": [0.005, 0.5]},
            "T": {"column": 3, "unit": "K", "range": [293.15, 673.15]},
            "sigma_n": {"column": 2, "unit": "GPa", "range": [0.5, 2.75], "subtract": 1.5, "divide": 0.75},
            "sd": {"column": 1, "unit": "m"},
            "psi": {"column": 0},
        },
        "output": {"multiply": 0.5, "add": 0.01},
    }
    seen = LOADED * [1e-3, 1.0, 1e-3, 1e-3, 1.0] + [0.0, 273.15, 0.0, 0.0, 0.0]
    seen[:, 2] = (seen[:, 2] - 1.5) / 0.75
    expected = 0.01 + 0.5 * true_line(seen[:, ::-1])
    np.testing.assert_allclose(lowered(line(), spec), expected, rtol=1e-6)
    user = read_user_model(line(), "m.onnx", Spec.from_dict(spec))
    assert user.domain["v_rel"] == pytest.approx((5.0, 500.0))
    assert user.domain["T"] == pytest.approx((20.0, 400.0))
    assert user.domain["sigma_n"] == pytest.approx((500.0, 2750.0))
    assert user.domain["sd"] == (LOADS[3].lower, LOADS[3].upper)  # no range given: limited by physics only


def test_yaml_as_a_list_and_graphs_of_fewer_loads() -> None:
    order = ["psi", "sd", "sigma_n", "T", "v_rel"]
    np.testing.assert_allclose(lowered(line(), {"inputs": order}), true_line(LOADED[:, ::-1]), rtol=1e-6)
    nodes = [node("MatMul", "in w", "a"), node("Add", "a c", "out")]
    two = model_bytes(nodes, {"w": np.array([[1e-3], [0.1]]), "c": np.array(0.02)}, {"in": ["n", 2]})
    mu = lowered(two, {"inputs": [{"load": "T", "unit": "K"}, {"load": "sigma_n", "unit": "GPa"}]})
    expected = 0.02 + 1e-3 * (LOADED[:, 1] + 273.15) + 0.1e-3 * LOADED[:, 2]
    np.testing.assert_allclose(mu, expected, rtol=1e-6)
    with pytest.raises(InputError, match=r"the graph has 2 columns, allowed: 5 = v_rel, .* that names"):
        lowered(two)
    with pytest.raises(InputError, match="column 1 of input 'in' gets no load"):
        lowered(two, {"inputs": {"T": {"column": 0}}})


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({"inputs": {"T": {"unit": "kelvins"}}}, "unknown unit of 'T' 'kelvins'; allowed: K, degC, degF"),
        ({"inputs": {"T": {"unit": "MPa"}}}, "unknown unit of 'T' 'MPa'"),
        ({"inputs": {"Temp": {}}}, "unknown load in inputs 'Temp'; allowed: T, psi, sd, sigma_n, v_rel"),
        ({"inputs": {"sigman": {}}}, "did you mean 'sigma_n'"),
        ({"inputs": {"T": {"colum": 1}}}, "unknown key 'inputs.T.colum'; .*did you mean 'column'"),
        ({"inputs": {"T": {"column": 7}}}, "inputs.T.column: .*less than or equal to 4 .value 7"),
        ({"inputs": {"T": {"column": 0}}}, "column 0 of input 'in' is given to 'v_rel' and 'T'"),
        ({"inputs": {"T": {"input": "temperature"}}}, "unknown input of the graph for 'T' 'temperature'; allowed: in"),
        ({"inputs": {"T": {"range": [400, 20]}}}, "range from 400.0 to 20.0; allowed: lower <= upper"),
        ({"inputs": {"T": {"unit": "K", "range": [-5, 20]}}}, "range of 'T' is -5 to 20 K, allowed: within 0 to 2273.15"),
        ({"inputs": {"T": {"range": [20, float("nan")]}}}, "finite number"),
        ({"inputs": {"T": {"divide": 0}}}, "divide = 0.0; allowed: a number that is not 0"),
        ({"inputs": ["T", "T"]}, "load 'T' stands twice"),
        ({"inputs": 1}, "inputs: input should be a valid dictionary .value 1"),
        ({"inputs": [3]}, r"inputs\[0\] is 3, allowed"),
        ({"domain": {"T": [20, 400]}}, "unknown key 'domain'; allowed: the trained range stands with each input"),
        ({"nam": "x"}, "unknown key 'nam'; allowed: name, .*did you mean 'name'"),
        ({"output": {"name": "mu"}}, "unknown output 'mu'; allowed: out"),
        ({"output": {"unit": "1"}}, "unknown key 'output.unit'; allowed: name, multiply, add"),
        ({"family": "../x"}, "family: .*value '../x'"),
        ({"name": "x" * 500}, "name: .*at most 120"),
        (["T"], "holds a list, allowed: the keys name"),
    ],
)  # fmt: skip
def test_a_yaml_that_does_not_fit_is_refused_in_one_sentence(spec: object, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        lowered(line(), spec)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name: [unclosed", "not YAML"),
        ("a: &x [1, 2]\nb: *x\n", "holds an alias"),
        ("!!python/object/apply:os.system ['true']", "not YAML"),
        ("# " + "x" * 70_000, "allowed: at most 65536"),
        ("", "holds nothing"),
        ("[" * 60_000, "nested deeper than 8 levels"),
        ("- " * 30_000, "nested deeper than 8 levels"),
    ],
)
def test_hostile_yaml(text: str, words: str, tmp_path: Path) -> None:
    model, spec = save(line(), tmp_path / "m.onnx"), tmp_path / "m.yaml"
    spec.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words) as caught:
        read_source(model, spec=spec)
    assert "m.yaml" in str(caught.value)


def test_a_yaml_belongs_to_a_users_own_file(tmp_path: Path) -> None:
    ours = ConstantFriction(0.1)
    ours.save(tmp_path / "ours")
    spec = tmp_path / "m.yaml"
    spec.write_text("name: x\n", encoding="utf-8")
    for model in (ours, tmp_path / "ours"):
        with pytest.raises(InputError, match="own ONNX file"):
            read_source(model, spec=spec)


def test_native_fmu_of_a_users_file_shows_the_contract_and_keeps_the_original(tmp_path: Path) -> None:
    spec = tmp_path / "m.yaml"
    spec.write_text(
        "name: shop floor\nfamily: mlp\nauthor: A. User\ninputs: {T: {unit: K, range: [293.15, 673.15]}}\n",
        encoding="utf-8",
    )
    model = save(line(), tmp_path / "m.onnx")
    path = pack(model, tmp_path / "m.fmu", spec=spec)
    unpacked = UnpackedFmu.of(path)
    assert unpacked.raw.modelName == "friction shop floor"
    assert (unpacked.folder / "resources" / "original.onnx").read_bytes() == model.read_bytes()
    assert "A. User" in (unpacked.folder / "documentation" / "index.html").read_text(encoding="utf-8")
    carried = OnnxModel(unpacked.folder / "resources" / "model.onnx")
    assert carried.domain is not None
    loads = np.array([[50.0, 500.0, 900.0, 3.0, 1.5]])
    inside = loads.copy()
    inside[0, 1] = 400.0
    inside[0, 1] += 273.15
    with RunningFmu(unpacked) as fmu:
        assert unpacked.resolve("T")[0].unit == "degC"
        fmu.set_real(LOAD_NAMES, loads[0])
        np.testing.assert_allclose(fmu.get_real(["mu"]), true_line(inside), rtol=1e-6)
    report = check(path)
    assert report.ok, str(report)
    assert path.read_bytes() == pack(model, tmp_path / "again.fmu", spec=spec).read_bytes()


# --- target python ---


@pytest.mark.parametrize("rows", [1, pytest.param("n", marks=pytest.mark.nightly)])
def test_what_has_no_translation_runs_in_python_in_its_own_units(rows: Any, tmp_path: Path) -> None:
    nodes = [node("MatMul", "x w", "a"), node("Sin", "a", "b"), node("Abs", "b", "y")]
    content = model_bytes(nodes, {"w": np.array([[1e-3], [1.0]])}, {"x": [rows, 2]}, {"y": [rows, 1]})
    model, spec = save(content, tmp_path / "sine.onnx"), tmp_path / "sine.yaml"
    spec.write_text(
        "inputs:\n  sigma_n: {column: 1, unit: GPa, subtract: 0.1, divide: 2}\n"
        "  T: {column: 0, unit: K, range: [293.15, 573.15]}\noutput: {multiply: 0.5}\n",
        encoding="utf-8",
    )
    with pytest.raises(InputError, match=r"operator Sin is not translated, allowed: Abs, .*--target python"):
        pack(model, tmp_path / "no.fmu", spec=spec)
    path = pack(model, tmp_path / "sine.fmu", spec=spec, target="python", nodes=3)
    T, sigma_n = np.array([20.0, 100.0, 400.0]), np.array([600.0, 1000.0, 2000.0])
    with RunningFmu(UnpackedFmu.of(path)) as fmu:
        fmu.set_real([f"T[{k}]" for k in (1, 2, 3)], T)
        fmu.set_real([f"sigma_n[{k}]" for k in (1, 2, 3)], sigma_n)
        mu = fmu.get_real([f"mu[{k}]" for k in (1, 2, 3)])
    seen = 1e-3 * (np.minimum(T, 300.0) + 273.15) + (1e-3 * sigma_n - 0.1) / 2.0
    np.testing.assert_allclose(mu, 0.5 * np.abs(np.sin(seen)), rtol=1e-6)
    if rows == 1:
        report = check(path)
        assert report.ok, str(report)


def test_python_fmu_of_a_translated_file_is_the_native_one(tmp_path: Path) -> None:
    model = save(line(), tmp_path / "m.onnx")
    path = pack(model, tmp_path / "m.fmu", target="python")
    with RunningFmu(UnpackedFmu.of(path)) as fmu:
        fmu.set_real(LOAD_NAMES, LOADED[0])
        np.testing.assert_allclose(fmu.get_real(["mu"]), lowered(line())[:1], rtol=1e-12)


# --- hostile and wrong files ---


def bomb(*nodes: onnx.NodeProto, **constants: Array) -> bytes:
    tail = [node("ReduceSum", "big", "sum", keepdims=0), node("Cast", "sum", "real", to=FLOAT)]
    first = [node("ReduceSum", "in axis", "s"), node("Add", "s real", "out")]
    return model_bytes([*nodes, *tail, *first], {"axis": np.array([1]), **constants})


def changed(**fields: Any) -> bytes:
    """Return the line with another first constant."""
    model = onnx.load_model_from_string(line())
    tensor = model.graph.initializer[0]
    for name, value in fields.items():
        if name == "dims":
            del tensor.dims[:]
            tensor.dims.extend(value)
        else:
            setattr(tensor, name, value)
    return bytes(model.SerializeToString())


def subgraph() -> bytes:
    body = helper.make_graph(
        [node("Identity", "in", "inner")], "b", [], [helper.make_tensor_value_info("inner", FLOAT, None)]
    )
    yes = numpy_helper.from_array(np.array(True), "yes")
    branch = helper.make_node("If", ["yes"], ["out"], then_branch=body, else_branch=body)
    graph = onnx.load_model_from_string(model_bytes([branch]))
    graph.graph.initializer.append(yes)
    return bytes(graph.SerializeToString())


def functions() -> bytes:
    model = onnx.load_model_from_string(line())
    made = helper.make_function(
        "own", "f", ["a"], ["b"], [node("Identity", "a", "b")], [helper.make_opsetid("", 20)]
    )
    model.functions.append(made)
    return bytes(model.SerializeToString())


def sparse() -> bytes:
    model = onnx.load_model_from_string(line())
    model.graph.sparse_initializer.add().dims.append(3)
    return bytes(model.SerializeToString())


HUGE = np.array([100_000, 100_000])
HOSTILE: dict[str, tuple[bytes, str]] = {
    "no ONNX": (b"\x00\x01 something else", "cannot be parsed|no output"),
    "truncated": (line()[:-40], "cannot be parsed|holds other data"),
    "subgraph": (subgraph(), "holds a graph of its own"),
    "function": (functions(), "defines a function of its own"),
    "sparse": (sparse(), "sparse tensors"),
    "random": (model_bytes([node("RandomNormalLike", "in", "out")]), "draws random numbers"),
    "cycle": (model_bytes([node("Add", "in b", "a"), node("Neg", "a", "b"), node("Neg", "b", "out")]), "need each other"),
    "computed twice": (model_bytes([node("Neg", "in", "out"), node("Abs", "in", "out")]), "by two nodes"),
    "bytes as name": (line().replace(b"\x03out", b"\x03\xff\xfet"), "no text"),
    "missing": (model_bytes([node("Add", "in nothing", "out")]), "'nothing' is used but never computed"),
    "dims lie": (changed(dims=[4000]), "holds other data than its dimensions"),
    "dims negative": (changed(dims=[-5]), "has dimensions"),
    "dims huge": (changed(dims=[1 << 40]), "has dimensions"),
    "dims overflow": (changed(dims=[1 << 32, 1 << 32]), "has dimensions"),
    "text": (changed(data_type=TensorProto.STRING), "element type 8"),
    "unknown type": (changed(data_type=99), "element type 99"),
    "NaN": (changed(raw_data=np.full(5, np.nan, np.float32).tobytes()), "holds NaN"),
    "old operators": (line(opset=6), "operator set 6 is not translated"),
    "new operators": (line(opset=99), "operator set 99 is not translated"),
    "ConstantOfShape": (bomb(node("ConstantOfShape", "huge", "big"), huge=HUGE), "10000000000 elements"),
    "Expand": (bomb(node("Expand", "axis huge", "big"), huge=HUGE), "10000000000 elements"),
    "Tile": (bomb(node("Tile", "axis huge", "big"), huge=np.array([1 << 40])), "elements a point"),
    "Range": (bomb(node("Range", "a b c", "big"), a=np.array(0), b=np.array(1 << 50), c=np.array(1)), "Range makes"),
    "endless Range": (bomb(node("Range", "a b c", "big"), a=np.array(0), b=np.array(5), c=np.array(0)), "Range makes inf"),
    "Concat": (bomb(node("Concat", " ".join(["many"] * 300), "big", axis=0), many=np.zeros(100_000)), "30000000 elements"),
    "products": (
        bomb(node("MatMul", "a b", "big"), a=np.zeros((1 << 20, 1)), b=np.zeros((1, 1 << 20))), "elements a point",
    ),
    "doubling": (
        bomb(
            *(node("Add", f"d{k} d{k}", f"d{k + 1}") for k in range(200)),
            node("Identity", "d200", "big"),
            d0=np.zeros(1 << 20, dtype=np.float16),
        ),
        "grow beyond",
    ),
    "wide": (
        model_bytes([node("MatMul", "in w", "a"), node("ReduceSum", "a axis", "out")], {"w": np.zeros((5, 200_000)), "axis": np.array([1])}),
        "200000 elements a point",
    ),
    "index": (model_bytes([node("Gather", "in i", "out", axis=1)], {"i": np.array([7])}), "Gather picks element 7 of 5"),
    "mixes points": (model_bytes([node("ReduceMean", "in", "out")]), "depends on the other points|has 1 values for 256 points"),
    "five values": (model_bytes([node("Neg", "in", "out")]), "has 5 values a point"),
    "image": (model_bytes([node("Neg", "in", "out")], inputs={"in": ["n", 3, 28, 28]}), r"has shape \['n', 3, 28, 28\]"),
    "six columns": (model_bytes([node("Neg", "in", "out")], inputs={"in": ["n", 6]}), r"has inputs in \['n', 6\]"),
    "endless input": (model_bytes([node("Neg", "in", "out")], inputs={"in": ["n", 1 << 40]}), "has inputs in"),
    "no number": (
        model_bytes([node("Sqrt", "m", "r"), node("ReduceSum", "r axis", "out")], {"m": np.full((1, 5), -1.0), "axis": np.array([1])}),
        "finite number",
    ),
    "NaN everywhere": (
        model_bytes([node("Abs", "in", "a"), node("Sub", "minus a", "b"), node("Sqrt", "b", "c"), node("ReduceSum", "c axis", "out")],
                    {"minus": np.array(-1.0), "axis": np.array([1])}),
        "mu is a finite number at 0 of",
    ),
    "Reshape": (model_bytes([node("Reshape", "in s", "out")], {"s": np.array([2, 3])}), "does not fit"),
    "attribute": (model_bytes([node("LeakyRelu", "in", "a", alpha="x"), node("ReduceSum", "a", "out")]), "attribute 'alpha'"),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_and_wrong_files_are_refused_in_one_sentence(name: str, tmp_path: Path) -> None:
    content, words = HOSTILE[name]
    start = time.process_time()
    with pytest.raises(InputError, match=words) as caught:
        read_source(save(content, tmp_path / "m.onnx"))
    assert "\n" not in str(caught.value)
    assert "m.onnx" in str(caught.value)
    assert time.process_time() - start < 30.0  # bounded work, not speed: unbounded would take hours


def test_what_would_take_all_memory_is_tried_in_a_second_process(tmp_path: Path) -> None:
    nodes = [
        node("ConstantOfShape", "huge", "big"),
        node("ReduceSum", "big", "sum", keepdims=0),
        node("ReduceSum", "in axis", "s"),
        node("Add", "s sum", "t"),
        node("Sin", "t", "out"),
    ]
    model = save(model_bytes(nodes, {"huge": HUGE, "axis": np.array([1])}), tmp_path / "m.onnx")
    with pytest.raises(InputError, match=r"m\.onnx: (ONNX Runtime cannot run|the process that runs)"):
        pack(model, tmp_path / "m.fmu", target="python")
    assert not (tmp_path / "m.fmu").exists()


def test_what_does_not_end_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(attempt, "TIME_LIMIT", 0.5)
    # Loops are refused when the file is read; products of large matrices take hours, too.
    nodes = [
        node("ConstantOfShape", "large", "m0"),
        *(node("MatMul", f"m{k} m{k}", f"m{k + 1}") for k in range(1000)),
        node("ReduceMax", "m1000", "most", keepdims=0),
        node("ReduceSum", "in axis", "s"),
        node("Add", "s most", "t"),
        node("Sin", "t", "out"),
    ]
    content = model_bytes(nodes, {"large": np.array([4000, 4000]), "axis": np.array([1])})
    with pytest.raises(InputError, match=r"are not evaluated after 0\.5 s"):
        read_user_model(content, "m.onnx", python=True)


#: Has no translation.
SINES = model_bytes([node("Sin", "in", "a"), node("ReduceSum", "a axis", "out")], {"axis": np.array([1])})


def started_late(monkeypatch: pytest.MonkeyPatch, seconds: float) -> None:
    """Let the process of the attempt take longer to load what it needs."""

    def command(*words: str) -> list[str]:
        *begin, code, path, module, folder = python_command(*words)
        return [*begin, f"import time; time.sleep({seconds}); {code}", path, module, folder]

    monkeypatch.setattr(attempt, "python_command", command)


@pytest.mark.nightly
def test_the_time_to_load_libraries_is_not_that_of_the_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    started_late(monkeypatch, 3.5)
    monkeypatch.setattr(attempt, "TIME_LIMIT", 3.0)
    assert read_user_model(SINES, "m.onnx", python=True).agreement is None


def test_a_process_that_never_starts_to_run_the_graph_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    started_late(monkeypatch, 600.0)
    monkeypatch.setattr(timed, "START_LIMIT", 0.5)
    with pytest.raises(
        InputError, match=r"m\.onnx: the process that is to run the graph is not ready after 0\.5 s"
    ):
        read_user_model(SINES, "m.onnx", python=True)


def test_a_deep_graph_is_no_deep_recursion(tmp_path: Path) -> None:
    deep = [node("ReduceMean", "in axis", "d0"), *(node("Neg", f"d{k}", f"d{k + 1}") for k in range(1500))]
    content = model_bytes([*deep, node("Identity", "d1500", "out")], {"axis": np.array([1])})
    np.testing.assert_allclose(lowered(content), np.maximum(LOADED.mean(axis=1), 0.0), rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"nodes_truenodeids": [0, 0, 0]}, "does not begin with its root|reached twice"),
        ({"nodes_truenodeids": [7, 0, 0]}, "has no child"),
        ({"nodes_nodeids": [0, 1, 1]}, "two nodes of the same number"),
        ({"nodes_featureids": [9, 0, 0]}, "asks for feature 9 of 5"),
        ({"nodes_modes": ["BRANCH_MEMBER", "LEAF", "LEAF"]}, "mode 'BRANCH_MEMBER'"),
        ({"nodes_values": [1.0, 0.0]}, "different lengths"),
        ({"target_nodeids": [0, 2]}, "no leaf"),
        ({"target_ids": [0, 3]}, "target 3 of 1"),
        ({"n_targets": 10**9}, "with 1000000000 targets"),
        ({"post_transform": "PROBIT"}, "post_transform 'PROBIT'"),
        ({"aggregate_function": "MEDIAN"}, "'MEDIAN'"),
    ],
)
def test_trees_that_are_none(change: dict[str, Any], words: str) -> None:
    trees = forest(["BRANCH_LEQ"], trees=1, depth=1)
    kept = {a.name: helper.get_attribute_value(a) for a in trees.attribute} | change
    made = helper.make_node("TreeEnsembleRegressor", ["in"], ["out"], domain="ai.onnx.ml", **kept)
    with pytest.raises(InputError, match=words):
        read_user_model(model_bytes([made]), "m.onnx")


@pytest.mark.nightly
def test_the_example_of_the_documentation_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("onnxscript", reason="torch's exporter needs onnxscript, extra [dev]")
    import torch

    from orchestrator.cli.main import run

    text = (Path(__file__).parents[2] / "docs" / "own-onnx.md").read_text(encoding="utf-8")
    example = text.partition("## Example")[2]
    blocks = dict(re.findall(r"```(python|yaml|console)\n(.*?)```", example, re.DOTALL))
    monkeypatch.chdir(tmp_path)
    seen: dict[str, Any] = {}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(blocks["python"], seen)
    (tmp_path / "net.yaml").write_text(blocks["yaml"], encoding="utf-8")
    for command in blocks["console"].splitlines():
        assert run(shlex.split(command)[1:]) == 0
    loads = np.array([[100.0, 80.0, 900.0, 5.0, 1.5], [400.0, 300.0, 2000.0, 0.0, 1.0]])
    scaled = (loads[:, [1, 2, 0]] * [1.0, 1e-3, 1e-3] + [273.15, 0.0, 0.0] - [450, 1.5, 0.2]) / [
        120,
        0.7,
        0.2,
    ]
    with torch.no_grad():
        expected = 0.08 + 0.1 * seen["net"].double()(torch.tensor(scaled)).numpy()[:, 0]
    assert expected.min() > 0.0
    with RunningFmu(UnpackedFmu.of(tmp_path / "net.fmu")) as fmu:
        for row, mu in zip(loads, expected):
            fmu.set_real(LOAD_NAMES, row)
            assert fmu.get_real(["mu"])[0] == pytest.approx(mu, rel=1e-9)


def test_a_wrong_translation_is_not_packed(monkeypatch: pytest.MonkeyPatch) -> None:
    content = model_bytes(
        [node("Mul", "in small", "x"), node("Gelu", "x", "y"), node("ReduceSum", "y axis", "out")],
        {"axis": np.array([1]), "small": np.array([[1e-3]])},
    )
    read_user_model(content, "m.onnx")
    right = arithmetic._gelu
    monkeypatch.setattr(arithmetic, "_gelu", lambda x, a, form: right(x, a, form) * 1.001)
    with pytest.raises(InputError, match="the graph in float64 is off by"):
        read_user_model(content, "m.onnx")
