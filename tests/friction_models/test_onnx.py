"""ONNX files: signature, metadata, hostile files, and models with memory."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import onnx
import pandas as pd
import pytest
from onnx import TensorProto, helper

from friction_models import LinearFriction, OnnxModel, effects, load_model
from friction_models.common import InputError
from friction_models.expressions.ops import LoadColumns, Ops, Value
from friction_models.families.registry import make_model
from friction_models.loads import LOAD_NAMES
from friction_models.loads.dataset import read_tests
from friction_models.models.base import FrictionModel
from friction_models.models.law import Learned
from friction_models.models.variables import StateVariable, SystemVariable

from .made_up import anywhere, campaign

FRAME = campaign(6, 20)


class WearFriction(FrictionModel):
    """A law with memory for these tests: wear w' = mu sigma_n v_rel, mu = 0.05 + Ra + 1e-6 w."""

    family: ClassVar[str] = "wear"

    def _fit(self, loads: Any, mu: Any, groups: Any) -> None:
        """Nothing to learn."""

    @property
    def states(self) -> tuple[StateVariable, ...]:
        return (StateVariable("work", "J/mm2", 2.0, ode=True), StateVariable("time", "s", 0.0, ode=True))

    @property
    def system_variables(self) -> tuple[SystemVariable, ...]:
        return (SystemVariable("Ra", "um", 0.01, 0.0, 0.1),)

    def formula(
        self,
        x: Ops,
        L: LoadColumns,
        S: Sequence[Value] | None = None,
        system: Mapping[str, Value] | None = None,
    ) -> Value:
        work = x.constant(2.0, L.T) if S is None else S[0]
        roughness = 0.01 if system is None else system["Ra"]
        return 0.05 + roughness + 1e-6 * work

    def state_update(
        self, x: Ops, L: LoadColumns, S: Sequence[Value], mu: Value, dt: Value
    ) -> tuple[list[Value], list[Value] | None]:
        rates = [mu * L.sigma_n * L.v_rel, x.constant(1.0, L.T)]
        return [s + r * dt for s, r in zip(S, rates)], rates

    def formula_text(self) -> str:
        return "mu = 0.05 + Ra + 1e-6 w"

    def _learned(self) -> Learned:
        return {}, {}

    def _restore(self, values: Mapping[str, Any], arrays: Mapping[str, Any]) -> None:
        """Nothing to take back."""


@pytest.fixture(scope="module")
def polynomial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("onnx") / "p.onnx"
    return make_model("polynomial").fit_frame(FRAME, info={"synthetic": True}).to_onnx(path)


@pytest.fixture(scope="module")
def wear(tmp_path_factory: pytest.TempPathFactory) -> OnnxModel:
    return OnnxModel(WearFriction().fit_frame(FRAME).to_onnx(tmp_path_factory.mktemp("onnx") / "w.onnx"))


def test_signature_is_the_contract(polynomial: Path) -> None:
    graph = onnx.load(polynomial).graph

    def shown(value: onnx.ValueInfoProto) -> tuple[str, int, list[Any]]:
        tensor = value.type.tensor_type
        return value.name, tensor.elem_type, [d.dim_value or d.dim_param for d in tensor.shape.dim]

    assert [shown(v) for v in graph.input] == [("loads", TensorProto.DOUBLE, ["n", 5])]
    assert [shown(v) for v in graph.output] == [("mu", TensorProto.DOUBLE, ["n", 1])]
    assert all(t.data_type in (TensorProto.DOUBLE, TensorProto.INT64) for t in graph.initializer)


def test_metadata_is_complete(polynomial: Path) -> None:
    props = {p.key: json.loads(p.value) for p in onnx.load(polynomial).metadata_props}
    assert set(props) == {"tribofmu.model", "tribofmu.domain", "tribofmu.card"}
    assert set(props["tribofmu.model"]) == {"family", "name", "formula", "version"}
    assert props["tribofmu.model"]["family"] == "polynomial"
    assert list(props["tribofmu.domain"]) == list(LOAD_NAMES)
    assert props["tribofmu.card"]["data"]["synthetic"] is True
    model = OnnxModel(polynomial)
    assert model.domain is not None
    assert model.domain.upper[3] == 60.0
    assert model.metadata["model"]["family"] == "polynomial"


def test_labels_of_a_batch_stand_in_the_file_and_give_the_same_mu(tmp_path: Path) -> None:
    names = sorted(set(FRAME["test_id"]))
    tests = pd.DataFrame({"test_id": names, "batch": [("old", "new")[k % 3 == 0] for k in range(len(names))]})
    shifted = FRAME["test_id"].isin(tests.loc[tests["batch"] == "old", "test_id"])
    frame = FRAME.assign(mu=FRAME["mu"] + 0.01 * shifted)
    model = (LinearFriction() + effects.Batch()).fit_frame(frame, tests=tests)
    model.save(tmp_path / "model")
    packed = OnnxModel(tmp_path / "model" / "model.onnx")
    assert packed.system_variables[0]["labels"] == ["new", "old"]
    others = tests.assign(batch="never seen")
    for table in (tests, others, None):  # a table without batches is the commonest batch
        expected = model.predict_frame(frame, tests=table)
        np.testing.assert_allclose(packed.predict_frame(frame, table), expected, rtol=1e-12)
        np.testing.assert_array_equal(
            load_model(tmp_path / "model").predict_frame(frame, tests=table), expected
        )
    old = packed.predict_frame(frame, tests) - packed.predict_frame(frame, others)
    assert np.ptp(old) > 0.005
    np.testing.assert_array_equal(packed.predict_frame(frame), packed.predict(frame[list(LOAD_NAMES)]))
    card = (tmp_path / "model" / "card.md").read_text(encoding="utf-8")
    assert "batch [1], start 1; 0 = new, 1 = old, any other number: none of these" in card


def test_labels_that_look_like_numbers_are_known_where_a_table_holds_no_other(tmp_path: Path) -> None:
    names = sorted(set(FRAME["test_id"]))
    tests = pd.DataFrame({"test_id": names, "batch": [("01", "02", "X")[k % 3] for k in range(len(names))]})
    frame = FRAME.merge(tests)
    frame["mu"] += 0.01 * (frame.pop("batch") == "02")
    model = (LinearFriction() + effects.Batch()).fit_frame(frame, tests=tests)
    packed = OnnxModel(model.to_onnx(tmp_path / "model.onnx"))
    expected = model.predict_frame(frame, tests)
    numbered = frame["test_id"].isin(tests.loc[tests["batch"] != "X", "test_id"])
    for rows in (["01", "02"], ["01", "02", ""]):  # read as 1 and 2, and as 1.0 and 2.0
        file = tmp_path / "tests.csv"
        cells = tests.assign(batch=tests["batch"].replace("X", ""))
        cells[cells["batch"].isin(rows)].to_csv(file, index=False)
        read = read_tests(file)
        assert pd.api.types.is_numeric_dtype(read["batch"])
        points = frame[numbered]
        np.testing.assert_array_equal(model.predict_frame(points, read), expected[numbered])
        np.testing.assert_allclose(packed.predict_frame(points, read), expected[numbered], rtol=1e-12)


def test_memory_steps_as_the_formula_says(wear: OnnxModel) -> None:
    assert [s["name"] for s in wear.states] == ["work", "time"]
    assert [v["name"] for v in wear.system_variables] == ["Ra"]
    loads = np.array([[10.0, 80.0, 1000.0, 1.0, 1.2], [0.0, 80.0, 1000.0, 1.0, 1.2]])
    np.testing.assert_allclose(wear.predict(loads), 0.06 + 2e-6, rtol=1e-14)
    mu, state = wear.step(loads, None, 0.5)
    np.testing.assert_allclose(mu, 0.06 + 2e-6, rtol=1e-14)
    np.testing.assert_allclose(state, [[2.0 + mu[0] * 1000 * 10 * 0.5, 0.5], [2.0, 0.5]], rtol=1e-14)
    again, later = wear.step(loads, state, 0.0)
    np.testing.assert_array_equal(later, state)
    np.testing.assert_allclose(again, 0.06 + 1e-6 * state[:, 0], rtol=1e-14)
    np.testing.assert_allclose(
        wear.predict(loads, state, system=[0.03]), 0.08 + 1e-6 * state[:, 0], rtol=1e-14
    )


def test_memory_runs_through_every_test_of_a_frame(wear: OnnxModel) -> None:
    frame = FRAME[FRAME["test_id"].isin(["t00", "t01"])].reset_index(drop=True)
    mu = wear.predict_frame(frame)
    for _, part in frame.groupby("test_id"):
        work, expected = 2.0, []
        for i, row in enumerate(part.itertuples()):
            before = 0.06 + 1e-6 * work
            if i:
                dt = row.t - part["t"].iloc[i - 1]
                work += before * row.sigma_n * row.v_rel * dt
            expected.append(0.06 + 1e-6 * work)
        np.testing.assert_allclose(mu[part.index], expected, rtol=1e-12)
    assert len(wear.predict_frame(frame.iloc[:0])) == 0
    tests = pd.DataFrame({"test_id": ["t00", "t01"], "Ra": [0.03, None]})
    rough = wear.predict_frame(frame, tests)
    first = (frame["test_id"] == "t00").to_numpy()
    assert rough[0] == pytest.approx(0.08 + 2e-6)
    np.testing.assert_array_equal(rough[~first], mu[~first])


def test_memory_metadata_and_derivative(wear: OnnxModel) -> None:
    model = onnx.load(wear.path)
    props = {p.key: json.loads(p.value) for p in model.metadata_props}
    assert props["tribofmu.state"][0] == {"name": "work", "unit": "J/mm2", "start": 2.0, "ode": True}
    assert props["tribofmu.system"] == [{"name": "Ra", "unit": "um", "start": 0.01, "min": 0.0, "max": 0.1}]
    assert [i.name for i in model.graph.input] == ["loads", "system", "state", "dt"]
    assert [o.name for o in model.graph.output] == ["mu", "state_next", "state_der"]


def test_wrong_shapes_for_memory_are_named(wear: OnnxModel, polynomial: Path) -> None:
    with pytest.raises(InputError, match=r"state has shape \(1, 2\), allowed: \(3, 2\)"):
        wear.step(anywhere(3), np.zeros((1, 2)), 0.1)
    with pytest.raises(InputError, match="2 system variables, allowed: 1"):
        wear.predict(anywhere(3), system=[0.1, 0.2])
    with pytest.raises(InputError, match="has no memory"):
        OnnxModel(polynomial).step(anywhere(3), None, 0.1)


def graph_of(
    inputs: list[tuple[str, int, list[Any]]], outputs: list[tuple[str, int, list[Any]]], nodes: list[Any]
) -> onnx.ModelProto:
    make = helper.make_tensor_value_info
    graph = helper.make_graph(nodes, "g", [make(*i) for i in inputs], [make(*o) for o in outputs])
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 21)], ir_version=10)


def refused(path: Path, words: str) -> None:
    with pytest.raises(InputError) as caught:
        OnnxModel(path)
    message = str(caught.value)
    assert str(path) in message and words in message
    assert "\n" not in message and len(message) < 500 + len(str(path))


def test_files_that_are_not_models(tmp_path: Path, polynomial: Path) -> None:
    path = tmp_path / "m.onnx"
    refused(path, "no such file")
    content = polynomial.read_bytes()
    for broken in (
        b"",
        b"hello",
        content[: len(content) // 2],
        b"\0" * 1000,
        np.random.default_rng(0).bytes(5000),
    ):
        path.write_bytes(broken)
        refused(path, "")
    with path.open("wb") as stream:
        stream.truncate(300 * 1024**2)
    refused(path, "314572800 bytes, allowed: at most 268435456")


def test_weights_in_other_files_are_refused(tmp_path: Path, polynomial: Path) -> None:
    model = onnx.load(polynomial)
    (tmp_path / "secret").write_bytes(b"\0" * 4096)
    tensor = next(t for t in model.graph.initializer if len(t.raw_data) > 8)
    tensor.ClearField("raw_data")
    tensor.data_location = TensorProto.EXTERNAL
    entry = tensor.external_data.add()
    entry.key, entry.value = "location", "../secret"
    path = tmp_path / "m.onnx"
    path.write_bytes(model.SerializeToString())
    refused(path, "stored in other files")


def test_other_signatures_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "m.onnx"
    identity = [helper.make_node("Identity", ["loads"], ["mu"])]
    single, double = TensorProto.FLOAT, TensorProto.DOUBLE
    cases = [
        graph_of([("loads", single, ["n", 5])], [("mu", single, ["n", 5])], identity),
        graph_of([("loads", double, ["n", 4])], [("mu", double, ["n", 4])], identity),
        graph_of(
            [("x", double, ["n", 5])],
            [("mu", double, ["n", 5])],
            [helper.make_node("Identity", ["x"], ["mu"])],
        ),
        graph_of(
            [("loads", double, ["n", 5]), ("state", double, ["n", 1])], [("mu", double, ["n", 5])], identity
        ),
    ]
    for model in cases:
        path.write_bytes(model.SerializeToString())
        refused(path, "allowed: loads double [n, 5]")


def test_graphs_that_could_run_forever_or_fill_the_memory_are_refused(tmp_path: Path) -> None:
    model = graph_of(
        [("loads", TensorProto.DOUBLE, ["n", 5])],
        [("mu", TensorProto.DOUBLE, ["n", 1])],
        [
            helper.make_node("ConstantOfShape", ["shape"], ["big"]),
            helper.make_node("ReduceSum", ["big", "axis"], ["one"], keepdims=1),
            helper.make_node("Cast", ["one"], ["mu"], to=TensorProto.DOUBLE),
        ],
    )
    model.graph.initializer.append(helper.make_tensor("axis", TensorProto.INT64, [1], [1]))
    model.graph.initializer.append(helper.make_tensor("shape", TensorProto.INT64, [2], [1, 10**13]))
    path = tmp_path / "m.onnx"
    path.write_bytes(model.SerializeToString())
    refused(path, "operator 'ConstantOfShape'")


def test_a_graph_that_cannot_run_or_gives_nan_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "m.onnx"
    loads, mu = ("loads", TensorProto.DOUBLE, ["n", 5]), ("mu", TensorProto.DOUBLE, ["n", 1])
    gather = helper.make_node("Gather", ["loads", "place"], ["one"], axis=1)
    for place, last, words in [
        (9, "Identity", "ONNX Runtime refuses the graph"),
        (0, "Log", "output 'mu' is [nan nan]"),
    ]:
        nodes = [
            gather,
            helper.make_node("Neg", ["one"], ["minus"]),
            helper.make_node(last, ["minus"], ["mu"]),
        ]
        model = graph_of([loads], [mu], nodes)
        model.graph.initializer.append(helper.make_tensor("place", TensorProto.INT64, [1], [place]))
        path.write_bytes(model.SerializeToString())
        refused(path, words)


def test_flipped_bytes_run_or_are_refused(tmp_path: Path, polynomial: Path) -> None:
    rng = np.random.default_rng(0)
    content, path, outcomes = polynomial.read_bytes(), tmp_path / "m.onnx", set()
    for _ in range(80):
        broken = bytearray(content)
        for place in rng.integers(0, len(content), 3):
            broken[place] = rng.integers(256)
        path.write_bytes(bytes(broken))
        try:
            OnnxModel(path).predict(anywhere(3))
        except InputError as error:
            assert "\n" not in str(error)
            outcomes.add("refused")
        else:
            outcomes.add("ran")
    assert outcomes == {"ran", "refused"}


def test_metadata_that_lies_is_refused(tmp_path: Path, polynomial: Path) -> None:
    path = tmp_path / "m.onnx"
    for key, value, words in [
        ("tribofmu.model", "{", "is not JSON"),
        ("tribofmu.state", '[{"start": 1.0}]', "'tribofmu.state' does not fit"),
        ("tribofmu.state", "5", "'tribofmu.state' does not fit"),
        ("tribofmu.domain", '{"T": 1}', "domain"),
    ]:
        model = onnx.load(polynomial)
        del model.metadata_props[:]
        entry = model.metadata_props.add()
        entry.key, entry.value = key, value
        path.write_bytes(model.SerializeToString())
        refused(path, words)


def test_a_foreign_file_without_metadata_predicts(tmp_path: Path) -> None:
    nodes = [
        helper.make_node("ReduceSum", ["loads", "axis"], ["mu"], keepdims=1),
    ]
    model = graph_of([("loads", TensorProto.DOUBLE, ["n", 5])], [("mu", TensorProto.DOUBLE, ["n", 1])], nodes)
    model.graph.initializer.append(helper.make_tensor("axis", TensorProto.INT64, [1], [1]))
    path = tmp_path / "m.onnx"
    path.write_bytes(model.SerializeToString())
    foreign = OnnxModel(path)
    loads = anywhere(5)
    np.testing.assert_allclose(foreign.predict(loads), loads.sum(axis=1), rtol=1e-15)
    assert foreign.domain is None and foreign.states == []
