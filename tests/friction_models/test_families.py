"""Each family recovers what it can represent, and keeps its promises where it cannot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.ensemble import HistGradientBoostingRegressor

from friction_models import (
    ConstantFriction,
    FeedForwardFriction,
    GradientBoostingFriction,
    LinearFriction,
    PolynomialFriction,
    PowerLawFriction,
    load_model,
)
from friction_models.common import InputError
from friction_models.families.gradient_boosting import table_of
from friction_models.loads import LOAD_NAMES

from .made_up import anywhere, campaign, law


def test_constant_is_given_or_the_mean() -> None:
    loads = anywhere(50)
    np.testing.assert_array_equal(ConstantFriction(0.08).predict(loads), np.full(50, 0.08))
    mu = law(loads)
    fitted = ConstantFriction().fit(loads, mu)
    np.testing.assert_allclose(fitted.predict(loads), np.mean(mu), rtol=1e-15)
    kept = ConstantFriction(0.04).fit(loads, mu)
    np.testing.assert_array_equal(kept.predict(loads), 0.04)
    with pytest.raises(InputError, match=r"mu is -0\.1, allowed: a number from 0 to 10"):
        ConstantFriction(-0.1).predict(loads)
    with pytest.raises(InputError, match=r"mu is '0\.1'"):
        ConstantFriction("0.1").predict(loads)  # type: ignore[arg-type]


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-1, 1), min_size=5, max_size=5), st.integers(0, 1000))
def test_linear_recovers_exact_coefficients(slopes: list[float], seed: int) -> None:
    loads = anywhere(60, seed)
    coef = np.array(slopes) * np.array([1e-5, 1e-5, 1e-6, 1e-4, 1e-3])
    mu = 0.2 + loads @ coef
    model = LinearFriction().fit(loads, mu)
    np.testing.assert_allclose(model.coef_, coef, rtol=1e-8, atol=1e-16)
    np.testing.assert_allclose(model.intercept_, 0.2, rtol=1e-11)


def test_linear_leaves_a_constant_load_alone() -> None:
    loads = anywhere(60)
    loads[:, 4] = 1.069
    model = LinearFriction().fit(loads, 0.1 + 1e-5 * loads[:, 1])
    assert model.coef_[4] == 0.0
    np.testing.assert_allclose(model.coef_[1], 1e-5, rtol=1e-9)


def tied(decimals: int, seed: int = 0) -> np.ndarray:
    """Return loads of which T and psi are formulas of v_rel and sd, rounded as a file has them."""
    loads = anywhere(300, seed)
    v, _, _, sd, _ = loads.T
    loads[:, 1] = np.round(20.0 + 0.1 * v + 2.0 * sd, decimals)
    loads[:, 4] = np.round(1.0 + 0.05 * sd, decimals)
    return loads


@pytest.mark.parametrize("decimals", [7, 9])
def test_rounding_of_loads_that_follow_from_one_another_is_no_information(decimals: int) -> None:
    loads = tied(decimals)
    noise = np.random.default_rng(1).normal(0.0, 0.003, len(loads))
    mu = 0.1 + 1e-4 * loads[:, 0] + 1e-5 * loads[:, 2] + 5e-4 * loads[:, 3] + noise
    whole = [loads.min(axis=0), loads.max(axis=0)]
    box = np.random.default_rng(2).uniform(*whole, (200, 5))
    for model in (LinearFriction(), PolynomialFriction(degree=1, ridge=0.0)):
        model.fit(loads, mu)
        assert np.abs(model.predict(loads) - mu).mean() < 0.004, "as good as the noise where data lie"
        assert model.predict(box).max() < 0.6, (
            f"{model.family}: a corner of the domain is not where the data explode"
        )


def test_loads_that_cannot_be_told_apart_are_named(tmp_path: Path) -> None:
    frame = campaign(8, 20)
    frame["psi"] = np.round(1.0 + 0.05 * frame["sd"], 9)
    model = LinearFriction().fit_frame(frame)
    model.save(tmp_path / "model")
    for known in (model, load_model(tmp_path / "model")):
        assert known.card["data"]["not_told_apart"] == ["sd", "psi"]
    assert "sd and psi follow from one another" in (tmp_path / "model" / "card.md").read_text()
    assert "not_told_apart" not in LinearFriction().fit_frame(campaign(8, 20)).card["data"]
    assert "not_told_apart" not in ConstantFriction().fit_frame(frame).card["data"]


def test_a_power_law_shares_between_loads_that_follow_from_one_another() -> None:
    loads = anywhere(300)
    loads[:, 4] = np.round((loads[:, 3] + 1.0) ** 0.5, 9)  # a power of sd + d0
    mu = 0.2 * (loads[:, 3] + 1.0) ** -0.3 * np.random.default_rng(1).lognormal(0.0, 0.02, len(loads))
    model = PowerLawFriction().fit(loads, mu)
    np.testing.assert_allclose(model.coef_[4] + 0.5 * model.coef_[5], -0.3, atol=0.01)
    # Both columns are the same when standardised: each carries half.
    np.testing.assert_allclose(model.coef_[4], 0.5 * model.coef_[5], atol=1e-6)


def test_polynomial_represents_every_second_order_surface() -> None:
    rng = np.random.default_rng(3)
    loads, new = anywhere(400), anywhere(100, seed=9)
    scale = np.array([500.0, 400.0, 2750.0, 60.0, 20.0])
    matrix, slope = rng.normal(0, 0.01, (5, 5)), rng.normal(0, 0.01, 5)

    def surface(x: np.ndarray) -> np.ndarray:
        z = x / scale
        return 0.3 + z @ slope + np.einsum("ni,ij,nj->n", z, matrix, z)

    exact = PolynomialFriction(ridge=0.0).fit(loads, surface(loads))
    np.testing.assert_allclose(exact.predict(new), surface(new), atol=1e-12)
    assert len(exact.terms) == 20
    mild = PolynomialFriction().fit(loads, surface(loads))
    np.testing.assert_allclose(mild.predict(new), surface(new), atol=1e-5)


def test_polynomial_survives_loads_that_never_vary() -> None:
    loads = anywhere(100)
    loads[:, [2, 4]] = 1000.0, 1.069
    model = PolynomialFriction().fit(loads, law(loads))
    assert np.isfinite(model.coef_).all()
    assert model.errors_["train"]["rmse"] < 0.005


@settings(max_examples=15, deadline=None)
@given(
    st.floats(0.03, 0.12),
    st.floats(-0.4, 0.4),
    st.floats(-0.3, 0.3),
    st.floats(-0.3, 0.3),
    st.floats(-0.2, 0.2),
    st.floats(-0.1, 0.2),
)
def test_power_law_recovers_exact_exponents(
    c: float, b: float, e: float, a: float, d: float, p: float
) -> None:
    loads = anywhere(80, seed=5)
    v, T, sigma, sd, psi = loads.T
    mu = c * ((v + 1) / 100) ** b * np.exp(e * T / 100) * ((sigma + 100) / 1000) ** a
    mu = mu * ((sd + 1) / 10) ** d * psi**p
    model = PowerLawFriction().fit(loads, mu)
    np.testing.assert_allclose(model.coef_, [np.log(c), b, e, a, d, p], atol=1e-8)


def test_power_law_is_least_squares_of_mu_not_of_its_logarithm() -> None:
    frame = campaign(12)
    model = PowerLawFriction().fit_frame(frame)
    best = model.errors_["train"]["rmse"]
    for j in range(6):
        for step in (-0.01, 0.01):
            moved = PowerLawFriction().fit_frame(frame)
            moved.coef_ = model.coef_ + step * np.eye(6)[j]
            rmse = np.sqrt(np.mean((moved.predict_frame(frame) - frame["mu"]) ** 2))
            assert rmse > best


def test_power_law_never_exceeds_the_physical_limit() -> None:
    model = PowerLawFriction().fit(anywhere(80), law(anywhere(80)))
    model.coef_ = np.array([0.0, 5.0, 5.0, 5.0, 5.0, 5.0])
    assert model.predict([[1e5, 2000.0, 1e5, 1e6, 1e3]])[0] == pytest.approx(10.0)


def test_trees_are_scikit_learns_trees() -> None:
    frame = campaign(12)
    loads, mu = frame[list(LOAD_NAMES)].to_numpy(), frame["mu"].to_numpy()
    ours = GradientBoostingFriction(trees=40, min_points=5, leaves=64, validation_fraction=0).fit(loads, mu)
    theirs = HistGradientBoostingRegressor(
        max_iter=40,
        learning_rate=0.08,
        max_leaf_nodes=64,
        min_samples_leaf=5,
        l2_regularization=1.0,
        early_stopping=False,
    ).fit(loads, mu)
    # On thresholds, just beside them, and anywhere.
    on = np.tile(loads[:5], (40, 1))
    on[:, 0] = np.resize(ours.trees_.threshold, len(on))
    points = np.vstack([loads, anywhere(3000), on, np.nextafter(on, np.inf), np.nextafter(on, -np.inf)])
    np.testing.assert_allclose(
        ours.predict(np.abs(points)), theirs.predict(np.abs(points)), rtol=0, atol=1e-14
    )
    assert ours.trees_.nodes.max() == 63


def test_a_tree_of_one_leaf_and_a_flat_target_are_fine() -> None:
    loads = anywhere(200)
    model = GradientBoostingFriction(trees=5).fit(loads, np.full(200, 0.07))
    np.testing.assert_allclose(model.predict(loads), 0.07, atol=1e-15)
    dtype = [
        ("is_leaf", "u1"),
        ("value", "f8"),
        ("feature_idx", "i8"),
        ("num_threshold", "f8"),
        ("left", "u4"),
        ("right", "u4"),
    ]
    stump = np.array([(0, 0.0, 2, 10.0, 2, 1), (1, 0.5, 0, 0.0, 0, 0), (1, -0.5, 0, 0.0, 0, 0)], dtype=dtype)
    leaf = np.array([(1, 0.25, 0, 0.0, 0, 0)], dtype=dtype)
    table, constant = table_of([leaf, stump, leaf])
    assert constant == 0.5
    np.testing.assert_array_equal(
        table.evaluate(np.array([[0, 0, 10.0, 0, 0], [0, 0, 10.1, 0, 0]])), [[-0.5], [0.5]]
    )


def test_number_of_trees_is_chosen_on_whole_tests() -> None:
    frame = campaign(20, noise=0.0)
    # Each test has its own offset: more trees learn the training tests by heart.
    offsets = dict(zip(frame["test_id"].unique(), np.random.default_rng(0).normal(0, 0.02, 20)))
    frame["mu"] = np.maximum(frame["mu"] + frame["test_id"].map(offsets), 0.0)
    model = GradientBoostingFriction(trees=150, min_points=5).fit_frame(frame)
    assert len(model.trees_.nodes) < 150
    assert len(model.validation_tests_) == 4
    assert set(model.validation_tests_) <= set(frame["test_id"])


def test_network_learns_the_law_on_tests_it_has_not_seen() -> None:
    frame = campaign(60, 40)
    unseen = campaign(10, 40, noise=0.0, seed=77)
    model = FeedForwardFriction(epochs=40).fit_frame(frame)
    error = model.predict_frame(unseen) - unseen["mu"]
    assert np.sqrt(np.mean(error**2)) < 0.004
    linear = LinearFriction().fit_frame(frame)
    assert np.mean(np.abs(error)) < 0.6 * np.mean(np.abs(linear.predict_frame(unseen) - unseen["mu"]))


def test_network_is_the_same_for_the_same_seed_only() -> None:
    frame = campaign(8, 20)

    def weights(seed: int) -> np.ndarray:
        return FeedForwardFriction(hidden=(6,), epochs=3, seed=seed).fit_frame(frame).networks_[1][0][0]

    np.testing.assert_array_equal(weights(1), weights(1))
    assert not np.array_equal(weights(1), weights(2))


def test_network_stops_early_and_keeps_the_best_epoch() -> None:
    frame = campaign(8, 30)
    frame["mu"] = np.random.default_rng(0).uniform(0, 0.2, len(frame))
    model = FeedForwardFriction(hidden=(32,), epochs=400, patience=5, batch_size=32).fit_frame(frame)
    assert len(model.epochs_) == 4 and max(model.epochs_) < 300
    # Each network has held out two tests of its own.
    assert 2 < len(model.validation_tests_) <= 8


def test_a_network_never_learns_from_the_tests_it_holds_out() -> None:
    """With one network, what stands in the held-out tests can only change when training stops."""
    frame = campaign(8, 20)
    options = {"hidden": (6,), "members": 1, "epochs": 1}
    first = FeedForwardFriction(**options).fit_frame(frame)
    spoilt = frame.copy()
    held = spoilt["test_id"].isin(first.validation_tests_)
    # In reverse they keep mean and spread, so that the scaling of mu stays the same.
    spoilt.loc[held, "mu"] = spoilt.loc[held, "mu"].to_numpy()[::-1]
    second = FeedForwardFriction(**options).fit_frame(spoilt)
    assert first.validation_tests_ == second.validation_tests_ and len(first.validation_tests_) == 2
    for (w1, b1), (w2, b2) in zip(first.networks_[0], second.networks_[0]):
        np.testing.assert_allclose(w1, w2, rtol=1e-9)
        np.testing.assert_allclose(b1, b2, rtol=1e-9)


def test_the_mean_of_networks_is_their_mean() -> None:
    frame = campaign(8, 20)
    model = FeedForwardFriction(hidden=(5,), members=3, epochs=2).fit_frame(frame)
    whole, networks = model.predict_frame(frame), model.networks_
    parts = []
    for network in networks:
        model.networks_ = [network]
        parts.append(model.predict_frame(frame))
    np.testing.assert_allclose(np.mean(parts, axis=0), whole, rtol=1e-12)


def test_training_does_not_change_the_threads_of_torch() -> None:
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        FeedForwardFriction(hidden=(4,), epochs=1, threads=1).fit_frame(campaign(4, 10))
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(before)


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (PolynomialFriction(degree=7), "degree is 7, allowed: a whole number from 1 to 4"),
        (PolynomialFriction(ridge=-1.0), "ridge is -1.0"),
        (PowerLawFriction(v_offset=0.0), "v_offset is 0.0"),
        (GradientBoostingFriction(leaves=100), "leaves is 100"),
        (GradientBoostingFriction(trees=2.5), "trees is 2.5"),  # type: ignore[arg-type]
        (FeedForwardFriction(activation="gelu"), "unknown activation 'gelu'; allowed: relu, sigmoid, tanh"),
        (FeedForwardFriction(hidden=()), r"hidden is \(\), allowed: 1 to 8 widths"),
        (FeedForwardFriction(hidden=(4, 0)), "hidden is 0"),
        (FeedForwardFriction(members=0), "members is 0, allowed: a whole number from 1 to 64"),
        (FeedForwardFriction(hidden=5), "hidden is 5"),  # type: ignore[arg-type]
        (FeedForwardFriction(learning_rate=float("nan")), "learning_rate is nan"),
    ],
)
def test_bad_parameters_are_named(model: PolynomialFriction, message: str) -> None:
    with pytest.raises(InputError, match=message):
        model.fit_frame(campaign(4, 10))


@pytest.mark.parametrize(("low", "high"), [(0.1, 1.0), (0.005, 0.03), (5.0, 60.0)])
def test_power_law_holds_far_below_the_pressures_of_forming(low: float, high: float, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    loads = anywhere(300, seed=6)
    loads[:, 2] = np.exp(rng.uniform(np.log(low), np.log(high), 300))
    mu = 0.1 * (loads[:, 2] / high) ** -0.4 * ((loads[:, 0] + 1.0) / 100.0) ** -0.1
    model = PowerLawFriction().fit(loads, mu)
    assert np.sqrt(np.mean((model.predict(loads) / mu - 1.0) ** 2)) < 0.03
    coarse = PowerLawFriction(sigma_offset=100.0).fit(loads, mu)  # what every model had before
    assert np.sqrt(np.mean((coarse.predict(loads) / mu - 1.0) ** 2)) > 0.05
    same = load_model(model.save(tmp_path / "model"))
    np.testing.assert_array_equal(same.predict(loads), model.predict(loads))
    assert same.sigma_offset is None and f"sigma_n + {0.2 * np.median(loads[:, 2]):g})" in same.formula_text()  # type: ignore[attr-defined]


def test_power_law_of_before_is_read_and_forming_pressures_keep_its_offset() -> None:
    loads = anywhere(80)
    model = PowerLawFriction().fit(loads, law(loads))
    assert model.sigma_offset_ == 100.0
    content, arrays = model.parts()
    old = {**content, "params": {"sigma_offset": 50.0, "v_offset": 1.0, "sd_offset": 1.0}, "learned": {}}
    read = PowerLawFriction.from_parts(old, arrays)
    given = PowerLawFriction(sigma_offset=50.0)
    given.sigma_offset_, given.coef_, given.domain_ = 50.0, model.coef_, model.domain
    np.testing.assert_array_equal(read.predict(loads), given.predict(loads))
    with pytest.raises(InputError, match="sigma_offset is -1"):
        PowerLawFriction.from_parts({**content, "learned": {"sigma_offset": -1.0}}, arrays)
