"""Splits by whole tests, error measures, evaluation and search."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_models import ConstantFriction, DataSet, LinearFriction, PolynomialFriction
from friction_models.common import InputError
from friction_models.training import (
    cross_validate,
    error_measures,
    evaluate,
    grid_search,
    hold_out,
    k_fold,
    train,
)

from .made_up import campaign


def test_measures_are_what_their_names_say() -> None:
    mu, predicted = np.array([0.1, 0.1, 0.2, 0.2]), np.array([0.1, 0.3, 0.1, 0.2])
    m = error_measures(mu, predicted, np.array(["a", "a", "b", "b"]))
    assert m["mae"] == pytest.approx(0.075)
    assert m["rmse"] == pytest.approx(np.sqrt(0.05 / 4))
    assert m["bias"] == pytest.approx(0.025)
    assert m["max_error"] == pytest.approx(0.2)
    assert m["mae_worst_test"] == pytest.approx(0.1)
    assert (m["points"], m["tests"]) == (4, 2)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 12), min_size=4, max_size=80), st.floats(0.05, 0.9), st.integers(0, 99))
def test_hold_out_keeps_tests_whole_whatever_their_order(ids: list[int], fraction: float, seed: int) -> None:
    groups = np.array([f"t{i}" for i in ids])
    kept, held = hold_out(groups, len(groups), fraction, seed)
    assert not (kept & held).any() and (kept | held).all()
    assert not set(groups[kept]) & set(groups[held])
    tests = len(set(ids))
    assert len(set(groups[held])) == (0 if tests < 4 else min(max(1, round(fraction * tests)), tests - 1))
    turned = hold_out(groups[::-1], len(groups), fraction, seed)[1]
    assert set(groups[::-1][turned]) == set(groups[held])


@settings(max_examples=25, deadline=None)
@given(st.integers(2, 20), st.integers(2, 6), st.integers(0, 99))
def test_every_test_is_held_out_once(tests: int, folds: int, seed: int) -> None:
    groups = np.repeat([f"t{i}" for i in range(tests)], 3)
    if folds > tests:
        with pytest.raises(InputError, match=f"{folds} folds with {tests} tests"):
            list(k_fold(groups, folds, seed))
        return
    parts = list(k_fold(groups, folds, seed))
    assert (np.sum([held for _, held in parts], axis=0) == 1).all()
    assert all(not set(groups[kept]) & set(groups[held]) for kept, held in parts)


def roles(frame: pd.DataFrame, held: int) -> pd.DataFrame:
    ids = list(frame["test_id"].unique())
    return pd.DataFrame({"test_id": ids, "role": ["train"] * (len(ids) - held) + ["test"] * held})


def test_evaluation_reports_each_role_and_each_test() -> None:
    frame = campaign(8, 20)
    frame["mu"] = 0.1
    frame.loc[frame["test_id"] == "t07", "mu"] = 0.2
    result = evaluate(ConstantFriction(0.11), frame, roles(frame, 2))
    assert list(result.roles) == ["train", "test"]
    assert result.roles["train"]["mae"] == pytest.approx(0.01)
    assert result.roles["test"]["mae"] == pytest.approx(0.05)
    assert result.overall["mae"] == pytest.approx((7 * 0.01 + 0.09) / 8)
    assert result.per_test["test_id"].iloc[0] == "t07"
    assert result.per_test["bias"].iloc[0] == pytest.approx(-0.09)
    assert result.per_test["points"].sum() == len(frame)
    content = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert content["roles"]["test"]["tests"] == 2
    text = result.report()
    assert "t07" in text and "train" in text and "MAE" in text


def test_evaluation_without_roles_or_tests() -> None:
    frame = campaign(4, 20)
    result = evaluate(ConstantFriction(0.08), frame)
    assert result.roles == {} and result.overall["tests"] == 4
    assert json.loads(json.dumps(result.to_dict(), allow_nan=False))["per_test"][0]["role"] is None
    assert evaluate(ConstantFriction(0.08), frame.drop(columns=["test_id", "t"])).overall["tests"] == 1
    with pytest.raises(InputError, match="column 'mu'"):
        evaluate(ConstantFriction(0.08), frame.drop(columns="mu"))
    with pytest.raises(InputError, match="no rows"):
        evaluate(ConstantFriction(0.08), frame.iloc[:0])


def test_evaluation_counts_points_outside_the_domain() -> None:
    frame = campaign(6, 20)
    half = LinearFriction().fit_frame(frame[frame["sd"] <= 30])
    result = evaluate(half, frame)
    assert result.overall["outside_domain"] == pytest.approx(np.mean(frame["sd"] > 30))


def test_evaluation_refuses_a_model_that_gives_nan() -> None:
    class Broken:
        def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> np.ndarray:
            return np.full(len(data), np.nan)

    with pytest.raises(InputError, match="finite"):
        evaluate(Broken(), campaign(4, 10))


def test_train_uses_training_tests_only_and_records_all_errors() -> None:
    frame = campaign(10, 20)
    frame.loc[frame["test_id"] == "t09", "mu"] = 1.0
    data = DataSet(frame, roles(frame, 1), {"synthetic": True})
    model = LinearFriction()
    result = train(model, data)
    assert model.errors_["train"]["mae"] < 0.02 < model.errors_["test"]["mae"]
    assert "t09" not in model.card["splits"]["train"]
    assert model.card["data"]["synthetic"] is True and result.synthetic is True
    assert "synthetic" in result.report()


def test_train_refuses_a_data_set_without_training_tests() -> None:
    frame = campaign(4, 10)
    tests = roles(frame, 1).assign(role="held out")
    with pytest.raises(InputError, match=r"role.*'held out'.*allowed: train"):
        train(LinearFriction(), DataSet(frame, tests))


def test_cross_validation_predicts_every_test_unseen() -> None:
    frame = campaign(10, 20)
    frame.loc[frame["test_id"] == "t03", "mu"] = 1.0
    result = cross_validate(ConstantFriction(), frame, folds=10)
    own = (frame["test_id"] == "t03").to_numpy()
    # The model that predicts t03 has not seen its 1.0.
    assert result.predicted[own].max() < 0.2
    assert len(result.folds) == 10 and result.measures["tests"] == 10


def test_grid_search_finds_the_degree_that_made_the_data() -> None:
    frame = campaign(16, 20, noise=0.0)
    frame["mu"] = 0.05 + 1e-8 * frame["sigma_n"] ** 2 + 1e-4 * frame["psi"] ** 2
    seen: list[tuple[int, int]] = []
    result = grid_search(
        PolynomialFriction(ridge=1e-9),
        {"degree": [1, 2]},
        frame,
        folds=4,
        progress=lambda i, n: seen.append((i, n)),
    )
    assert result.best_params == {"degree": 2}
    assert result.model.degree == 2 and result.model.is_fitted
    assert list(result.table["degree"]) == [2, 1]
    assert result.table["mae"].is_monotonic_increasing
    assert seen == [(1, 2), (2, 2)]
    with pytest.raises(InputError, match="did you mean 'degree'"):
        grid_search(PolynomialFriction(), {"degre": [1]}, frame)
    with pytest.raises(InputError, match="no value to try for 'degree'"):
        grid_search(PolynomialFriction(), {"degree": []}, frame)


def test_grid_search_over_network_widths() -> None:
    from friction_models import FeedForwardFriction

    result = grid_search(FeedForwardFriction(epochs=3), {"hidden": [(2,), (8, 4)]}, campaign(6, 20), folds=2)
    assert result.model.hidden in [(2,), (8, 4)]
    assert list(result.table.columns) == ["hidden", "mae", "rmse", "mae_std"]
