"""One suite run over every friction model: what a user may rely on, whatever the family."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import clone

from friction_models import OnnxModel, TriboLoads, load_model
from friction_models.families.formula import FormulaFriction
from friction_models.families.registry import FAMILIES, make_model
from friction_models.loads import LOADS, FloatArray
from friction_models.models.base import FrictionModel

from ..friction_models.made_up import EDGES, anywhere, campaign
from ..friction_models.test_ops import ALLOWED

SMALL: dict[str, dict[str, int | tuple[int, ...]]] = {
    "ffnn": {"hidden": (12, 8), "members": 2, "epochs": 20},
    "gradient_boosting": {"trees": 30, "min_points": 10},
}
FRAME = campaign(40, 20)
BEYOND = np.abs(anywhere(200, seed=4)) * np.array([20.0, 3.0, 10.0, 50.0, 10.0])


#: Compositions stand for all: without memory, and with.
COMPOSED = ("linear + stribeck", "linear + work_exhaustion")


#: A law of a card, whose constants a fit adapts.
FORMULA = FormulaFriction(
    "a + b*T/100 + c*log(1 + v_rel) + d*exp(-sigma_n/1000) + e*sd*psi", dict.fromkeys("abcde", 0.01)
)


def fresh(name: str) -> FrictionModel:
    if name == FORMULA.family:
        return clone(FORMULA)
    family, *effects = name.split(" + ")
    model = make_model(family, **SMALL.get(family, {}))
    for effect in effects:
        model = model + effect
    return model


@pytest.fixture(scope="module", params=[*sorted(FAMILIES), *COMPOSED, FORMULA.family])
def model(request: pytest.FixtureRequest) -> FrictionModel:
    return fresh(request.param).fit_frame(FRAME)


@pytest.fixture(scope="module")
def folder(model: FrictionModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return model.save(tmp_path_factory.mktemp("saved") / "model")


@pytest.fixture(scope="module")
def session(folder: Path) -> OnnxModel:
    return OnnxModel(folder / "model.onnx")


def assert_valid(mu: FloatArray, points: int) -> None:
    assert mu.shape == (points,) and mu.dtype == np.float64
    assert np.isfinite(mu).all() and (mu >= 0).all()


def test_fit_returns_self_and_learned_attributes_end_in_an_underscore(model: FrictionModel) -> None:
    other = fresh(model.name)
    before = set(vars(other))
    assert other.fit(TriboLoads.from_frame(FRAME), FRAME["mu"]) is other
    assert all(name.endswith("_") for name in set(vars(other)) - before)
    assert before == set(other.get_params(deep=False))


def test_clone_is_unfitted_and_keeps_parameters(model: FrictionModel) -> None:
    twin = clone(model)
    assert twin._plain_params() == model._plain_params()
    assert not twin.is_fitted and model.is_fitted


def test_fit_is_repeatable(model: FrictionModel) -> None:
    again = clone(model).fit_frame(FRAME)
    np.testing.assert_array_equal(again.predict(BEYOND), model.predict(BEYOND))


def test_prediction_is_finite_and_never_negative_anywhere(model: FrictionModel) -> None:
    for loads in (EDGES, anywhere(500), BEYOND, EDGES[:1]):
        assert_valid(model.predict(loads), len(loads))
    assert_valid(model.predict(np.empty((0, 5))), 0)


physical = st.tuples(*(st.floats(q.lower, q.upper, allow_subnormal=False) for q in LOADS))


@settings(max_examples=60, deadline=None)
@given(st.lists(physical, min_size=1, max_size=8))
def test_prediction_is_valid_within_all_physical_limits_and_onnx_agrees(
    model: FrictionModel, session: OnnxModel, points: list[tuple[float, ...]]
) -> None:
    loads = np.array(points)
    mu = model.predict(loads)
    assert_valid(mu, len(loads))
    np.testing.assert_allclose(session.predict(loads), mu, rtol=1e-9, atol=1e-9)


def test_onnx_runtime_reproduces_predict(model: FrictionModel, session: OnnxModel) -> None:
    inside = np.vstack([anywhere(2000, seed=8), FRAME[[q.name for q in LOADS]].to_numpy()])
    np.testing.assert_allclose(session.predict(inside), model.predict(inside), rtol=0, atol=1e-9)
    for loads in (EDGES, BEYOND):
        np.testing.assert_allclose(session.predict(loads), model.predict(loads), rtol=1e-9, atol=1e-9)


def test_rows_do_not_see_each_other(model: FrictionModel) -> None:
    loads = anywhere(300)
    order = np.random.default_rng(0).permutation(300)
    together = model.predict(loads)
    np.testing.assert_allclose(model.predict(loads[order]), together[order], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(
        np.concatenate([model.predict(r) for r in loads[:5]]), together[:5], rtol=1e-12
    )


def test_prediction_leaves_its_input_alone(model: FrictionModel) -> None:
    loads = anywhere(50)
    kept = loads.copy()
    model.predict(loads)
    np.testing.assert_array_equal(loads, kept)


def test_save_and_load_is_identical(model: FrictionModel, folder: Path) -> None:
    same = load_model(folder)
    assert type(same) is type(model)
    assert same._plain_params() == model._plain_params()
    for loads in (anywhere(500), EDGES):
        np.testing.assert_array_equal(same.predict(loads), model.predict(loads))
    assert same.card == model.card
    assert same.domain == model.domain


def test_export_is_byte_identical(model: FrictionModel, folder: Path, tmp_path: Path) -> None:
    content = (folder / "model.onnx").read_bytes()
    assert model.to_onnx(tmp_path / "a.onnx").read_bytes() == content
    assert load_model(folder).to_onnx(tmp_path / "b.onnx").read_bytes() == content
    assert clone(model).fit_frame(FRAME).to_onnx(tmp_path / "c.onnx").read_bytes() == content


def test_graph_is_float64_with_allowed_operators(folder: Path) -> None:
    graph = onnx.load(folder / "model.onnx").graph
    assert {n.op_type for n in graph.node} <= ALLOWED
    assert onnx.TensorProto.FLOAT not in {t.data_type for t in graph.initializer}


def test_domain_is_the_range_of_the_training_data(model: FrictionModel, session: OnnxModel) -> None:
    loads = FRAME[[q.name for q in LOADS]].to_numpy()
    np.testing.assert_array_equal(model.domain.lower, loads.min(axis=0))
    np.testing.assert_array_equal(model.domain.upper, loads.max(axis=0))
    assert model.domain.contains(loads).all()
    assert (model.domain.distance(EDGES[2:3]) > 1).all()
    assert session.domain == model.domain


def test_card_and_view(model: FrictionModel) -> None:
    card = model.card
    assert card["family"] == model.family and card["data"]["tests"] == 40
    assert card["errors"]["train"]["points"] == len(FRAME)
    assert "mu = " in card["formula"] and "\n" not in card["formula"]
    assert len(model.view().data) == 3 * len(LOADS)


def test_a_single_point_is_enough_to_fit(model: FrictionModel) -> None:
    other = clone(model).fit(EDGES[-1:], [0.07])
    np.testing.assert_allclose(other.predict(EDGES[-1:]), 0.07, atol=5e-3)


def test_one_test_only_holds_nothing_out(model: FrictionModel) -> None:
    one = FRAME[FRAME["test_id"] == "t00"]
    fitted = clone(model).fit_frame(one)
    assert getattr(fitted, "validation_tests_", []) == []
    assert_valid(fitted.predict(EDGES), len(EDGES))


def test_better_than_nothing(model: FrictionModel) -> None:
    """Every family but the constant explains a good part of the variation of unseen tests."""
    if model.family == "constant":
        return
    unseen = campaign(30, 20, noise=0.0, seed=50)
    error = model.predict_frame(unseen) - unseen["mu"]
    assert np.mean(error**2) < 0.6 * np.var(unseen["mu"])


def test_whole_tests_are_held_out_in_training(model: FrictionModel) -> None:
    """What was held out to stop the training is a set of whole tests, smaller than all."""
    names = getattr(model, "validation_tests_", None)
    if names is None:
        return
    assert names and set(names) < set(FRAME["test_id"])


def test_frame_order_of_columns_and_extra_columns_do_not_matter(model: FrictionModel) -> None:
    shuffled = FRAME[FRAME.columns[::-1]].assign(extra="x")
    np.testing.assert_array_equal(model.predict_frame(shuffled), model.predict_frame(FRAME))
    assert isinstance(shuffled, pd.DataFrame)
