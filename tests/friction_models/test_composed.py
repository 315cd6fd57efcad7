"""Composed models: fit, prediction with memory, files, errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from sklearn.base import clone

from benchmarks.discovery_campaigns import campaign
from friction_models import (
    ConstantFriction,
    LinearFriction,
    PolynomialFriction,
    TriboLoads,
    effects,
    load_model,
)
from friction_models.common import InputError
from friction_models.families.composed import ComposedFriction


@pytest.fixture(scope="module")
def data() -> tuple[pd.DataFrame, pd.DataFrame]:
    points, tests, _ = campaign("stribeck", seed=5, strength=1.5, thin=10, extra=20)
    return points, tests


def test_plus_composes_and_clones(data: tuple[pd.DataFrame, pd.DataFrame]) -> None:
    model = LinearFriction() + effects.Stribeck() + "wear_out"
    assert isinstance(model, ComposedFriction)
    assert [effects.make_effect(e).name for e in model.effects] == ["stribeck", "wear_out"]
    assert model.name == "linear + stribeck + wear_out" and not model.is_fitted
    assert clone(model).name == model.name


def test_fit_lowers_the_error_and_says_what_it_learned(data: tuple[pd.DataFrame, pd.DataFrame]) -> None:
    points, tests = data
    plain = LinearFriction().fit_frame(points, tests)
    model = (LinearFriction() + effects.Stribeck()).fit_frame(points, tests)
    assert model.errors_["train"]["rmse"] < plain.errors_["train"]["rmse"]
    assert model.amplitudes_[0]["delta_s"] > 0.003
    assert "v_s" in model.formula_text() and model.card["family"] == "composed"
    # the scatter between tests (0.005) is noise, and is found as such
    assert 0.004 < model.noise_floor_["test"] < 0.0065


def test_offsets_of_tests_do_not_bias_what_varies_within_them() -> None:
    points, tests, hidden = campaign(
        "running_in", seed=9, strength=1.0, scatter=0.008, thin=8, twin_errors=0.0
    )
    model = (LinearFriction() + effects.RunningIn()).fit_frame(points, tests)
    rising = points["sd"] < 10.0
    shape, amplitude = model.shapes_[0]["s_r"], model.amplitudes_[0]["delta_r"]
    found = amplitude * np.exp(-points["sd"] / shape)
    error = (found - found.mean()) - (hidden - hidden.mean())
    assert np.std(error[rising]) < 0.15 * np.std(hidden[rising])


def test_own_friction_drives_the_work_not_the_measured_one(data: tuple[pd.DataFrame, pd.DataFrame]) -> None:
    points, tests = data
    model = (LinearFriction() + effects.WorkExhaustion(W_c=3.0, n=2.0)).fit_frame(points, tests)
    loads = TriboLoads.from_frame(points, tests)
    predicted = model.predict(loads)
    first = loads.segments()[0]
    assert loads.t is not None
    work, before = 0.0, None
    base, amplitude = model.base_.predict(loads), model.amplitudes_[0]["delta_W"]
    for i in range(first.start, first.stop):
        if before is not None:
            own = base[i] + amplitude * (1 - np.exp(-((work / 3.0) ** 2)))
            work += 1e-3 * max(own, 0.0) * loads.sigma_n[i] * loads.v_rel[i] * (loads.t[i] - loads.t[before])
        assert predicted[i] == pytest.approx(
            max(base[i] + amplitude * (1 - np.exp(-((work / 3.0) ** 2))), 0.0), abs=1e-9
        )
        before = i


def test_every_test_starts_with_fresh_contact(data: tuple[pd.DataFrame, pd.DataFrame]) -> None:
    points, tests = data
    model = (LinearFriction() + effects.RateState()).fit_frame(points, tests)
    loads = TriboLoads.from_frame(points, tests)
    everything = model.predict(loads)
    last = loads.segments()[-1]
    assert np.allclose(
        model.predict(loads.take(np.arange(last.start, last.stop))), everything[last], atol=1e-14
    )
    # an array has no tests: every row is fresh contact, whatever stands beside it
    array = loads.as_array()[:7]
    assert np.array_equal(model.predict(array)[3:4], model.predict(array[3:4]))


@pytest.mark.parametrize("base", [ConstantFriction(), PolynomialFriction()])
def test_other_bases(base: object, data: tuple[pd.DataFrame, pd.DataFrame], tmp_path: Path) -> None:
    points, tests = data
    model = (base + effects.Stribeck()).fit_frame(points, tests)  # type: ignore[operator]
    model.save(tmp_path / "m")
    again = load_model(tmp_path / "m")
    assert np.array_equal(again.predict_frame(points, tests), model.predict_frame(points, tests))
    assert again.noise_floor_ == model.noise_floor_  # type: ignore[attr-defined]


def test_system_variable_follows_metadata_and_has_a_default(data: tuple[pd.DataFrame, pd.DataFrame]) -> None:
    points, tests = data
    model = (LinearFriction() + effects.ToolRoughness() + effects.Batch()).fit_frame(points, tests)
    names = [v.name for v in model.system_variables]
    assert names == ["Ra", "batch"]
    one = points.iloc[:1]
    rough = tests.assign(Ra=tests["Ra"] + 0.1)
    change = model.predict_frame(one, rough) - model.predict_frame(one, tests)
    assert change[0] == pytest.approx(0.1 * model.amplitudes_[0]["c_Ra"], abs=1e-12)
    assert np.isfinite(model.predict(one[["v_rel", "T", "sigma_n", "sd", "psi"]].to_numpy())).all()


def test_errors_name_what_is_missing(data: tuple[pd.DataFrame, pd.DataFrame]) -> None:
    points, tests = data
    with pytest.raises(InputError, match="needs the column 'Ra' in the table of tests"):
        (LinearFriction() + effects.ToolRoughness()).fit_frame(points)
    with pytest.raises(InputError, match="stands twice"):
        (LinearFriction() + "stribeck" + "stribeck").fit_frame(points, tests)
    with pytest.raises(InputError, match="unknown effect"):
        (LinearFriction() + "stribbeck").fit_frame(points, tests)
    with pytest.raises(InputError, match="not fitted"):
        (LinearFriction() + "stribeck").predict(points[["v_rel", "T", "sigma_n", "sd", "psi"]].to_numpy())


def test_an_effect_of_mu_itself_agrees_with_mu_however_steep_it_is() -> None:
    """The friction coefficient that a flash temperature sees is the one that comes out."""
    rng = np.random.default_rng(0)
    points = np.column_stack(
        [
            rng.uniform(1.0, 500.0, 400),
            np.full(400, 80.0),
            rng.uniform(300.0, 2500.0, 400),
            np.zeros(400),
            np.ones(400),
        ]
    )
    for delta, n in ((0.02, 1.0), (0.1, 4.0), (0.4, 6.0)):
        model = (ConstantFriction() + effects.FlashTemperature(q_c=300.0, n=n)).fit(
            points, 0.05 + 0.02 * rng.uniform(size=400)
        )
        level = model.base_.value
        model.amplitudes_ = [{"delta_f": delta}]
        mu = model.predict(points)
        heating = mu * points[:, 2] * np.sqrt(points[:, 0])
        assert mu == pytest.approx(level + delta / (1.0 + (heating / 300.0) ** n), abs=1e-9)
