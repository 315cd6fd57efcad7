"""A user's own ONNX file: every translated operator, real exports, units, places, and what must be refused."""

from __future__ import annotations

import contextlib
import io
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus import pack
from fmus.native import ops
from fmus.runtime.running import RunningFmu, UnpackedFmu
from fmus.source.reading import read_source
from fmus.user_onnx import read_user_model
from fmus.user_onnx.operators.arithmetic import erf
from fmus.user_onnx.operators.registry import translated
from friction_models.common import InputError
from friction_models.expressions.ops import NumpyOps
from friction_models.loads import LOAD_NAMES
from tests.fmus.foreign import CASES, DOUBLE, FLOAT, Array, case_bytes, forest, model_bytes, node
from tests.fmus.graphs import random_loads, runtime, save

#: Where no kernel in float64 exists to compare with, or one that computes in float32 inside.
ROUNDED = {"Erf", "HardSwish", "Gelu", "Gelu tanh", "Shrink", "com.microsoft.FastGelu"}
NO_DOUBLE = {"com.microsoft.Gelu", "com.microsoft.BiasGelu"}


def original(content: bytes, feed: dict[str, Array]) -> Array:
    session = onnxruntime.InferenceSession(content, providers=["CPUExecutionProvider"])
    return np.ravel(session.run(None, feed)[0]).astype(float)


def evaluate(path: Path, loads: Array) -> Array:
    with RunningFmu(UnpackedFmu.of(path)) as fmu:
        mu = np.empty(len(loads))
        for i, row in enumerate(loads):
            fmu.set_real(LOAD_NAMES, row)
            mu[i] = fmu.get_real(["mu"])[0]
    return mu


@pytest.mark.parametrize("name", CASES)
def test_operator_means_the_same_as_in_the_original(name: str) -> None:
    single = read_user_model(case_bytes(name, FLOAT), "m.onnx")
    assert single.agreement is not None
    assert single.agreement.difference <= (5e-5 if name == "IsInf" else 1e-6) * single.agreement.largest
    model = onnx.load_model_from_string(single.onnx)
    assert {n.op_type for n in model.graph.node} <= set(ops.SUPPORTED)
    if name not in NO_DOUBLE:
        double = read_user_model(case_bytes(name, DOUBLE), "m.onnx")
        assert double.agreement is not None
        limit = 1e-7 if name in ROUNDED else 1e-14
        assert double.agreement.difference <= limit * double.agreement.largest


def test_every_translated_operator_has_a_case() -> None:
    trees = {"ai.onnx.ml.TreeEnsemble", "ai.onnx.ml.TreeEnsembleRegressor"}
    assert {c.split(" ")[0] for c in CASES} | trees == set(translated())


def test_error_function_is_exact() -> None:
    from math import erf as true

    x = np.concatenate([np.linspace(-7.0, 7.0, 4001), 10.0 ** np.arange(-300.0, 1.0, 10.0), [1e4, -1e300]])
    expected = np.array([true(v) for v in x])
    np.testing.assert_allclose(erf(NumpyOps(), x), expected, rtol=3e-16, atol=0.0)


# --- trees ---

SPLITS = {"one": ["BRANCH_LEQ"], "mixed": ["BRANCH_LT", "BRANCH_LEQ", "BRANCH_GT", "BRANCH_GTE"]}


@pytest.mark.parametrize("modes", SPLITS)
@pytest.mark.parametrize("aggregate", ["SUM", "AVERAGE", "MIN", "MAX"])
def test_trees_branch_as_in_the_original_also_on_their_splits(modes: str, aggregate: str) -> None:
    trees = forest(SPLITS[modes], aggregate, base=0.02)
    content = model_bytes([trees])
    user = read_user_model(content, "m.onnx")
    splits = next(a for a in trees.attribute if a.name == "nodes_values").floats
    features = next(a for a in trees.attribute if a.name == "nodes_featureids").ints
    rows = []
    for feature, split in zip(features, splits):
        if split:
            single = np.float32(split)
            around = [np.nextafter(single, np.float32(0)), single, np.nextafter(single, np.float32(1e9))]
            # Also between two float32 numbers: the original rounds before it compares.
            between = [0.25, 0.5, 0.75]
            values = [*map(float, around), *(float(single) + f * float(np.spacing(single)) for f in between)]
            for value in values:
                row = random_loads(1, seed=len(rows), outside=False)[0]
                row[feature] = value
                rows.append(row)
    loads = np.array(rows)
    expected = np.maximum(original(content, {"in": loads.astype(np.float32)}), 0.0)
    np.testing.assert_allclose(runtime(user.onnx, loads), expected, rtol=1e-6)
    assert len(np.unique(np.round(expected, 7))) > 4


def test_native_fmu_of_trees_is_the_original(tmp_path: Path) -> None:
    content = model_bytes([forest(["BRANCH_LT", "BRANCH_GT"], "AVERAGE", trees=20, depth=4)])
    path = pack(save(content, tmp_path / "trees.onnx"), tmp_path / "trees.fmu")
    loads = random_loads(200)
    expected = original(content, {"in": loads.astype(np.float32)})
    np.testing.assert_allclose(evaluate(path, loads), expected, rtol=1e-6)


def test_scaled_inputs_of_trees_round_step_by_step() -> None:
    """Scaler, Sub and Div before trees: a point at a split must not end on the other side."""
    scaler = node("ai.onnx.ml/Scaler", "in", "a", offset=[3.3] * 5, scale=[0.37] * 5)
    trees = forest(["BRANCH_LEQ"], trees=1, depth=1)
    trees.input[0] = "b"
    content = model_bytes([scaler, node("Div", "a third", "b"), trees], {"third": np.array(0.3)})
    user = read_user_model(content, "m.onnx")
    feature = next(a for a in trees.attribute if a.name == "nodes_featureids").ints[0]
    split = np.float32(next(a for a in trees.attribute if a.name == "nodes_values").floats[0])
    middle = float(split) * 0.3 / 0.37 + 3.3
    loads = random_loads(400, outside=False)
    loads[:, feature] = middle + np.arange(-200, 200) * 0.1 * np.spacing(np.float32(middle))
    expected = original(content, {"in": loads.astype(np.float32)})
    assert len(np.unique(expected)) == 2
    np.testing.assert_allclose(runtime(user.onnx, loads), expected, rtol=1e-6)


def test_trees_of_the_newer_operator_and_several_targets() -> None:
    several = forest(["BRANCH_LT"], targets=2)
    several.output[0] = "pair"
    content = model_bytes([several, node("ReduceSum", "pair one", "out")], {"one": np.array([1])})
    agreement = read_user_model(content, "m.onnx").agreement
    assert agreement is not None
    assert agreement.difference < 1e-6 * agreement.largest

    def packed(values: list[float], kind: Any = np.float32) -> onnx.TensorProto:
        return onnx.numpy_helper.from_array(np.array(values, dtype=kind))

    newer = node(
        "ai.onnx.ml/TreeEnsemble",
        "in",
        "out",
        tree_roots=[0],
        nodes_featureids=[1, 2],
        nodes_splits=packed([120.0, 900.0]),
        nodes_modes=packed([1, 4], np.uint8),  # below, then equal
        nodes_truenodeids=[0, 2],
        nodes_trueleafs=[1, 1],
        nodes_falsenodeids=[1, 1],
        nodes_falseleafs=[0, 1],
        leaf_targetids=[0, 0, 0],
        leaf_weights=packed([0.1, 0.2, 0.3]),
        n_targets=1,
        aggregate_function=1,
    )
    graph = onnx.load_model_from_string(model_bytes([newer]))
    graph.opset_import[1].version = 5
    content = graph.SerializeToString()
    loads = np.tile([50.0, 100.0, 900.0, 1.0, 1.0], (4, 1))
    loads[:, 1], loads[3, 2] = [119.0, 120.0, 121.0, 121.0], 901.0
    expected = original(content, {"in": loads.astype(np.float32)})
    np.testing.assert_allclose(expected, [0.1, 0.3, 0.3, 0.2], rtol=1e-6)
    np.testing.assert_allclose(runtime(read_user_model(content, "m").onnx, loads), expected, rtol=1e-6)


# --- real exports ---


def torch_bytes(module: Any, dynamo: bool, arguments: int = 1, **more: Any) -> bytes:
    torch = pytest.importorskip("torch")
    if dynamo:
        pytest.importorskip("onnxscript", reason="torch's newer exporter needs onnxscript, extra [dev]")
        more |= {"external_data": False}
    given = (torch.zeros(2, 5),) if arguments == 1 else tuple(torch.zeros(2, 1) for _ in range(arguments))
    file = io.BytesIO()
    with contextlib.redirect_stdout(io.StringIO()):
        program = torch.onnx.export(
            module.eval(), given, None if dynamo else file, dynamo=dynamo, verbose=False, **more
        )
    return bytes(program.model_proto.SerializeToString()) if dynamo else file.getvalue()


def torch_net() -> Any:
    import torch

    class Net(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            torch.manual_seed(1)
            self.register_buffer("mean", torch.tensor([200.0, 150.0, 1500.0, 30.0, 10.0]))
            self.register_buffer("std", torch.tensor([150.0, 100.0, 700.0, 20.0, 6.0]))
            acts = [torch.nn.GELU(), torch.nn.SiLU(), torch.nn.Mish(), torch.nn.ELU(), torch.nn.LayerNorm(6)]
            self.parts = torch.nn.ModuleList(torch.nn.Sequential(torch.nn.Linear(5, 6), a) for a in acts)
            self.norm = torch.nn.BatchNorm1d(30)
            self.end = torch.nn.Linear(30, 1)

        def forward(self, x: Any) -> Any:
            x = (x - self.mean) / self.std
            joined = torch.cat([p(x) for p in self.parts], dim=-1).view(x.shape[0], -1)
            a, b = self.norm(joined).chunk(2, dim=-1)
            return 0.1 + 0.02 * self.end(torch.cat([a * torch.sigmoid(b), b], dim=-1)).squeeze(-1)

    return Net()


# By day the example of docs/own-onnx.md runs through the newer exporter.
@pytest.mark.parametrize("dynamo", [False, pytest.param(True, marks=pytest.mark.nightly)])
def test_torch_exports(dynamo: bool) -> None:
    import torch

    free: dict[str, Any] = (
        {"dynamic_shapes": ({0: torch.export.Dim("n")},)}
        if dynamo
        else {"input_names": ["x"], "dynamic_axes": {"x": {0: "n"}}}
    )
    net = torch_net()
    user = read_user_model(torch_bytes(net, dynamo, **free), "m.onnx")
    loads = random_loads(50)
    with torch.no_grad():
        expected = net.double()(torch.tensor(loads)).numpy()
    np.testing.assert_allclose(runtime(user.onnx, loads), np.maximum(expected, 0.0), rtol=1e-6, atol=1e-9)


def test_torch_export_of_five_inputs_becomes_a_native_fmu(tmp_path: Path) -> None:
    import torch

    class Five(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            torch.manual_seed(3)
            self.inner = torch.nn.Sequential(torch.nn.Linear(5, 8), torch.nn.GELU(), torch.nn.Linear(8, 1))

        def forward(self, psi: Any, sd: Any, sigma_n: Any, T: Any, v_rel: Any) -> Any:
            return 0.2 + 0.1 * self.inner(
                torch.cat([v_rel / 500, T / 300, sigma_n / 2e3, sd / 60, psi / 20], 1)
            )

    names = ["psi", "sd", "sigma_n", "T", "v_rel"]
    content = torch_bytes(Five(), False, 5, input_names=names, dynamic_axes={n: {0: "n"} for n in names})
    path = pack(save(content, tmp_path / "five.onnx"), tmp_path / "five.fmu")
    loads = random_loads(30)
    feed = {n: loads[:, [LOAD_NAMES.index(n)]].astype(np.float32) for n in names}
    expected = original(content, feed)
    assert expected.min() > 0.0
    np.testing.assert_allclose(evaluate(path, loads), expected, rtol=1e-5)


def test_weights_that_torch_stores_beside_the_file_are_read(tmp_path: Path) -> None:
    net = onnx.load_model_from_string(dense([5, 8, 1], ["Tanh"]))
    onnx.save(
        net, tmp_path / "net.onnx", save_as_external_data=True, location="net.onnx.data", size_threshold=0
    )
    content = (tmp_path / "net.onnx").read_bytes()
    source = read_source(tmp_path / "net.onnx")
    assert source.original is not None
    assert original(source.original, {"in": np.ones((1, 5), np.float32)}).size == 1
    (tmp_path / "net.onnx.data").rename(tmp_path / "net.other")
    with pytest.raises(InputError, match="is not beside it"):
        read_source(tmp_path / "net.onnx")
    for name in ("../net.data", "/etc/hostname", "secret.txt", "net.onnx", ""):
        net = onnx.load_model_from_string(content)
        for tensor in net.graph.initializer:
            tensor.external_data[0].value = name
        (tmp_path / "net.onnx").write_bytes(net.SerializeToString())
        with pytest.raises(InputError, match="are stored in"):
            read_source(tmp_path / "net.onnx")


def pipelines() -> dict[str, Any]:
    from sklearn import ensemble, linear_model, neural_network, preprocessing, svm, tree

    steps = preprocessing
    return {
        "mlp": (steps.StandardScaler(), neural_network.MLPRegressor(hidden_layer_sizes=(8, 8), activation="tanh", max_iter=20)),
        "mlp logistic": (steps.MinMaxScaler(), neural_network.MLPRegressor(activation="logistic", max_iter=9)),
        "ridge": (steps.RobustScaler(), linear_model.Ridge()),
        "polynomial": (steps.StandardScaler(), steps.PolynomialFeatures(2), linear_model.Ridge()),
        "gamma": (steps.StandardScaler(), linear_model.GammaRegressor()),
        "power": (steps.PowerTransformer(), linear_model.Ridge()),
        "svr": (steps.StandardScaler(), svm.SVR(epsilon=1e-3)),
        "svr poly": (steps.StandardScaler(), svm.SVR(kernel="poly", epsilon=1e-3)),
        "tree": (tree.DecisionTreeRegressor(),),
        "forest": (steps.StandardScaler(), ensemble.RandomForestRegressor(5, random_state=0)),
        "extra": (ensemble.ExtraTreesRegressor(5, random_state=0),),
        "boosting": (ensemble.GradientBoostingRegressor(n_estimators=20),),
        "bagging": (steps.StandardScaler(), ensemble.BaggingRegressor(n_estimators=3, random_state=0)),
        "voting": (ensemble.VotingRegressor([("a", linear_model.Ridge()), ("b", tree.DecisionTreeRegressor(max_depth=4))]),),
    }  # fmt: skip


@pytest.mark.parametrize("name", [*pipelines(), "gaussian process"])
@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_scikit_learn_exports(name: str, precision: Any) -> None:
    skl2onnx = pytest.importorskip("skl2onnx", reason="skl2onnx writes these files, extra [dev]")
    from sklearn.gaussian_process import GaussianProcessRegressor, kernels
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    if precision is np.float64 and name == "power":
        pytest.skip("skl2onnx does not write a PowerTransformer in float64")
    if precision is np.float32 and name == "gaussian process":
        pytest.skip("a Gaussian process in float32 cancels; its export in float64 is packed")
    loads = random_loads(150, outside=False)
    mu = 0.05 + 1e-4 * loads[:, 1] + 0.02 * np.exp(-loads[:, 3] / 20.0)
    if name == "gaussian process":
        kernel = kernels.RBF(2.0) + kernels.WhiteKernel(1e-4)
        model = make_pipeline(StandardScaler(), GaussianProcessRegressor(kernel, optimizer=None))
        options = {id(model.steps[-1][1]): {"optim": "cdist"}}
    else:
        model, options = make_pipeline(*pipelines()[name]), None
    model.fit(loads, mu)
    content = skl2onnx.to_onnx(model, loads[:1].astype(precision), options=options).SerializeToString()
    user = read_user_model(content, "m.onnx")
    # Trees compare in float32: on other points than those trained on, which are where the splits are not.
    points = random_loads(150, seed=5, outside=False)
    expected = np.maximum(model.predict(points).ravel(), 0.0)
    # The numbers in the attributes of ai.onnx.ml are float32.
    np.testing.assert_allclose(runtime(user.onnx, points), expected, rtol=2e-5, atol=1e-6)


# --- random dense networks ---

ACTIVATIONS = (
    "Relu",
    "Tanh",
    "Sigmoid",
    "Softplus",
    "Softsign",
    "Elu",
    "Selu",
    "LeakyRelu",
    "HardSigmoid",
    "Mish",
)


def dense(
    widths: list[int], activations: list[str], kind: int = FLOAT, seed: int = 0, gemm: bool = True
) -> bytes:
    """Return a dense network behind a scaler, by Gemm (transposed weights) or MatMul and Add."""
    rng = np.random.default_rng(seed)
    nodes = [node("Mul", "in scale", "h0")]
    constants: dict[str, Array] = {"scale": np.array([[2e-3, 3e-3, 4e-4, 1e-2, 5e-2]])}
    for k, (m, n) in enumerate(pairwise(widths)):
        constants[f"w{k}"] = rng.normal(size=(n, m) if gemm else (m, n)) / np.sqrt(m)
        constants[f"b{k}"] = rng.normal(size=n)
        last = k == len(widths) - 2
        made = "out" if last else f"g{k}"
        if gemm:
            nodes.append(node("Gemm", f"h{k} w{k} b{k}", made, transB=1))
        else:
            nodes += [node("MatMul", f"h{k} w{k}", f"p{k}"), node("Add", f"p{k} b{k}", made)]
        if not last:
            nodes.append(node(activations[k % len(activations)], f"g{k}", f"h{k + 1}"))
    return model_bytes(nodes, constants, kind=kind, opset=21)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.integers(1, 9), min_size=0, max_size=4),
    st.lists(st.sampled_from(ACTIVATIONS), min_size=1, max_size=4),
    st.integers(0, 10**6),
    st.booleans(),
)
def test_random_dense_networks_are_the_same_function(
    hidden: list[int], activations: list[str], seed: int, gemm: bool
) -> None:
    widths = [5, *hidden, 1]
    double = read_user_model(dense(widths, activations, DOUBLE, seed, gemm), "m.onnx")
    assert double.agreement is not None
    assert double.agreement.difference <= 1e-6 * max(double.agreement.largest, 1e-3)
    from fmus.user_onnx.parity import Reference

    loads = random_loads(20, seed)
    reference = Reference(dense(widths, activations, DOUBLE, seed, gemm)).run(["out"], {"in": loads})[0]
    np.testing.assert_allclose(
        runtime(double.onnx, loads), np.maximum(reference[:, 0], 0.0), rtol=1e-12, atol=1e-14
    )
