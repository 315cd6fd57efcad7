"""Uncertain loads in a fit: against York's and Deming's regression, weighted means, and laws that are known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest

from friction_models import ConstantFriction, DataSet, LinearFriction, TriboLoads
from friction_models.common import InputError
from friction_models.families.registry import make_model
from friction_models.models.base import FrictionModel
from friction_models.models.effective_variance import honoured_sentence, scatter_beside
from friction_models.training import cross_validate
from friction_models.training.evaluation import train

Array = npt.NDArray[np.float64]


def york(x: Array, y: Array, u_x: Array, u_y: Array) -> tuple[float, float]:
    """Return slope and intercept of York et al., Am. J. Phys. 72 (2004) 367, for errors that are not correlated."""
    slope = float(np.polyfit(x, y, 1)[0])
    for _ in range(100):
        weight = 1.0 / (u_y**2 + slope**2 * u_x**2)
        mean_x, mean_y = np.average(x, weights=weight), np.average(y, weights=weight)
        dx, dy = x - mean_x, y - mean_y
        beta = weight * (dx * u_y**2 + slope * dy * u_x**2)
        slope = float(np.sum(weight * beta * dy) / np.sum(weight * beta * dx))
    return slope, float(mean_y - slope * mean_x)


def line(seed: int, u_T: Array, scatter: float, slope: float = -1e-4) -> pd.DataFrame:
    """Return points of a straight law of T, each with an error of its own in T and in mu."""
    rng = np.random.default_rng(seed)
    T = rng.uniform(20.0, 400.0, len(u_T))
    mu = 0.12 + slope * T + scatter * rng.standard_normal(len(T))
    return pd.DataFrame({"T": T + u_T * rng.standard_normal(len(T)), "u_T": u_T, "mu": mu})


def test_a_straight_law_is_near_york_where_least_squares_is_not() -> None:
    u_T = np.tile([0.5, 40.0], 100)
    off_york, off_plain, off_truth = [], [], []
    for seed in range(40):
        frame = line(seed, u_T, 0.001)
        T, mu = frame["T"].to_numpy(), frame["mu"].to_numpy()
        exact = york(T, mu, u_T, np.full(len(T), 0.001))[0]
        slope = LinearFriction().fit_frame(frame).coef_[1]
        off_york.append(slope - exact)
        off_plain.append(np.polyfit(T, mu, 1)[0] - exact)
        off_truth.append(slope + 1e-4)
    assert np.mean(off_plain) > 5e-6  # least squares: too flat by 6 %
    assert abs(np.mean(off_york)) < 2e-6 and np.std(off_york) < 2e-6
    assert abs(np.mean(off_truth)) < 2e-6


def test_equal_errors_leave_the_slope_too_flat_as_deming_says() -> None:
    """What weights cannot honour: where all points are alike, the law is that of least squares."""
    frame = line(3, np.full(20_000, 60.0), 0.002)
    model = LinearFriction().fit_frame(frame)
    plain = LinearFriction().fit_frame(frame, load_uncertainty=False)
    assert model.coef_.tobytes() == plain.coef_.tobytes()
    T, mu = frame["T"].to_numpy(), frame["mu"].to_numpy()
    variance, s_xy, s_yy = T.var(), np.cov(T, mu, bias=True)[0, 1], mu.var()
    ratio = (0.002 / 60.0) ** 2
    part = s_yy - ratio * variance
    deming = (part + np.sqrt(part**2 + 4.0 * ratio * s_xy**2)) / (2.0 * s_xy)
    assert deming == pytest.approx(-1e-4, rel=0.01)
    assert model.coef_[1] / deming == pytest.approx(1.0 - 60.0**2 / variance, rel=0.01)
    assert model.training_["data"]["load_uncertainty"]["effective_points"] == pytest.approx(20_000)


def test_the_weights_are_those_of_the_effective_variance() -> None:
    """At the slope found, the fit is that of weights written out by hand."""
    frame = line(1, np.tile([1.0, 25.0, 60.0], 60), 0.002)
    model = LinearFriction().fit_frame(frame)
    facts = model.training_["data"]["load_uncertainty"]
    u = model.coef_[1] * frame["u_T"].to_numpy()
    weight = 1.0 / (facts["scatter"] ** 2 + u**2)
    slope, level = np.polyfit(frame["T"], frame["mu"], 1, w=np.sqrt(weight))
    assert model.coef_[1] == pytest.approx(slope, rel=1e-4)
    assert model.intercept_ == pytest.approx(level, rel=1e-4)
    assert facts["scatter"] == pytest.approx(0.002, rel=0.15)
    assert facts["effective_points"] == pytest.approx(weight.sum() ** 2 / (weight**2).sum(), rel=1e-3)
    assert facts["by_load"]["T"] == pytest.approx(np.sqrt(np.mean(u**2)), rel=1e-3)


def test_the_scatter_beside_known_errors() -> None:
    rng = np.random.default_rng(0)
    known = rng.uniform(0.0, 0.004, 50_000)
    residual = np.hypot(0.003, known) * rng.standard_normal(50_000)
    assert scatter_beside(residual, known**2) == pytest.approx(0.003**2, rel=0.03)
    # stated too large: a quarter of what is stated remains, so that no point stands alone
    assert scatter_beside(0.1 * residual, known**2) == pytest.approx(0.25 * np.mean(known**2))


def few(seed: int = 0) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    low, high = [5.0, 20.0, 300.0, 0.0, 1.0], [400.0, 250.0, 2500.0, 50.0, 8.0]
    loads = rng.uniform(low, high, (60, 5))
    mu = 0.03 + 0.05 * np.exp(-loads[:, 0] / 150.0) + 1e-5 * loads[:, 2] + 0.003 * rng.standard_normal(60)
    return loads, mu, rng.integers(1, 4, 60).astype(float)


@pytest.mark.parametrize(
    "model",
    [
        ConstantFriction(),
        LinearFriction(),
        make_model("polynomial", degree=1),
        make_model("power_law"),
        make_model("gradient_boosting", trees=8, min_points=1, l2=0.0, validation_fraction=0.0),
    ],
    ids=lambda model: model.family,
)
def test_a_point_of_weight_three_is_three_points(model: FrictionModel) -> None:
    loads, mu, weight = few()
    rows = np.repeat(np.arange(len(mu)), weight.astype(int))
    expected = model.fit(loads[rows], mu[rows]).predict(loads)
    plain = model.fit(loads, mu).predict(loads)
    found = model.fit(loads, mu, sample_weight=7.0 * weight).predict(loads)
    assert found == pytest.approx(expected, rel=1e-4)
    assert np.max(np.abs(found - plain)) > 1e-4


def test_the_mean_of_a_weighted_constant() -> None:
    model = ConstantFriction().fit(
        [[50, 20, 500, 0, 1], [50, 20, 900, 0, 1]], [0.25, 0.75], sample_weight=[3, 1]
    )
    assert model.value == 0.375


#: Family, further parameters, seeds, and the largest share of the error that is to be left.
KINDS: list[tuple[str, dict[str, float], int, float]] = [
    ("linear", {}, 20, 0.8),
    ("polynomial", {}, 20, 0.85),
    ("power_law", {}, 10, 0.9),
    ("gradient_boosting", {"trees": 40, "validation_fraction": 0.0, "min_points": 20}, 6, 0.9),
    ("ffnn", {"members": 2, "epochs": 25, "validation_fraction": 0.0}, 2, 0.9),
]


def campaign(seed: int) -> tuple[pd.DataFrame, TriboLoads, Array]:
    """Return tests whose temperature is off, each by an error common to its points; the true loads and friction."""
    rng = np.random.default_rng(seed)
    tests, each = 40, 12
    u_T = np.repeat(np.where(np.arange(tests) % 2, 70.0, 3.0), each)
    v_rel, sigma_n, start = (
        np.repeat(rng.uniform(*ends, tests), each) for ends in ((5.0, 300.0), (500.0, 2500.0), (20.0, 250.0))
    )
    sd = np.tile(np.linspace(1.0, 50.0, each), tests)
    T = start + sd
    names = np.repeat([f"t{k:02d}" for k in range(tests)], each)
    mu = 0.13 - 2e-4 * T + 0.03 * np.exp(-v_rel / 40.0)
    loads = TriboLoads(v_rel, T, sigma_n, sd, np.full(len(T), 1.2), test_id=names)
    off = np.repeat(rng.standard_normal(tests), each) * u_T
    offset = 0.001 * np.repeat(rng.standard_normal(tests), each)
    frame = loads.to_frame().assign(
        T=np.maximum(T + off, 0.0), u_T=u_T, mu=mu + offset + 0.002 * rng.standard_normal(len(T))
    )
    return frame, loads, mu


@pytest.mark.parametrize(("family", "params", "seeds", "most"), KINDS, ids=lambda x: str(x)[:12])
def test_the_law_is_nearer_the_truth_than_without(
    family: str, params: dict[str, float], seeds: int, most: float
) -> None:
    model = make_model(family, **params)
    kept, ignored = [], []
    for seed in range(seeds):
        frame, loads, truth = campaign(seed)
        for errors, honoured in ((kept, True), (ignored, False)):
            predicted = model.fit_frame(frame, load_uncertainty=honoured).predict(loads)
            errors.append(float(np.sqrt(np.mean((predicted - truth) ** 2))))
    assert np.mean(np.array(kept) < np.array(ignored)) >= 0.8
    assert np.sqrt(np.mean(np.square(kept))) < most * np.sqrt(np.mean(np.square(ignored)))


def test_without_uncertain_loads_nothing_changes() -> None:
    frame = campaign(0)[0]
    plain = frame.drop(columns="u_T")
    for family in ("constant", "linear", "polynomial", "power_law"):
        model = make_model(family)
        expected = model.fit_frame(plain).predict_frame(plain).to_numpy()
        assert "load_uncertainty" not in model.training_["data"]
        for same in (plain.assign(u_T=0.0), plain.assign(u_psi=0.0)):
            assert model.fit_frame(same).predict_frame(plain).to_numpy().tobytes() == expected.tobytes()
        assert (
            model.fit_frame(frame, load_uncertainty=False).predict_frame(plain).to_numpy().tobytes()
            == expected.tobytes()
        )


def test_a_constant_law_does_not_care() -> None:
    frame = campaign(0)[0]
    model = ConstantFriction().fit_frame(frame)
    assert model.value == ConstantFriction().fit_frame(frame, load_uncertainty=False).value
    assert model.training_["data"]["load_uncertainty"]["effective_points"] == pytest.approx(len(frame))
    text = honoured_sentence(model.training_["data"]["load_uncertainty"], len(frame))
    assert text == "Uncertain loads change nothing: the law does not depend on them."


def test_uncertainties_that_are_small_beside_the_scatter_change_nothing() -> None:
    """Trees change with the least weight: they are not to change where nothing is to be won."""
    frame = campaign(0)[0].assign(u_T=campaign(0)[0]["u_T"] / 20.0)
    for family in ("linear", "gradient_boosting"):
        model = make_model(family).fit_frame(frame)
        plain = make_model(family).fit_frame(frame.drop(columns="u_T"))
        assert (
            model.predict_frame(frame).to_numpy().tobytes() == plain.predict_frame(frame).to_numpy().tobytes()
        )
        facts = model.training_["data"]["load_uncertainty"]
        assert 0.99 * len(frame) < facts["effective_points"] < len(frame)
        assert "say nearly the same of all points: all weigh alike." in honoured_sentence(facts, len(frame))


def test_folds_honour_them_too() -> None:
    """Cross-validation trains networks together; each with the weights of its own fold."""
    frame = campaign(1)[0]
    for model in (LinearFriction(), make_model("ffnn", members=1, epochs=3)):
        honoured = cross_validate(model, frame, folds=3).predicted
        assert (
            np.max(np.abs(honoured - cross_validate(model, frame.drop(columns="u_T"), folds=3).predicted))
            > 1e-4
        )


class Unweighted(ConstantFriction):
    """A family of somebody else, whose fit knows no weights."""

    family = "unweighted"

    def _fit(self, loads: TriboLoads, mu: Array, groups: Any) -> None:  # type: ignore[override]
        self.mean_ = float(mu.mean())


def test_a_family_without_weights_is_fitted_as_before() -> None:
    frame = campaign(0)[0]
    model = Unweighted().fit_frame(frame)
    assert model.value == pytest.approx(frame["mu"].mean())
    assert "load_uncertainty" not in model.training_["data"]
    with pytest.raises(InputError, match="the unweighted family takes no sample_weight"):
        model.fit(TriboLoads.from_frame(frame), frame["mu"], sample_weight=np.ones(len(frame)))


@pytest.mark.parametrize(
    ("weights", "said"),
    [
        ([1.0], r"sample_weight has shape \(1,\); allowed: \(2,\)"),
        ([1.0, -1.0], r"sample_weight, row 1: -1\.0; allowed"),
        ([np.nan, 1.0], r"sample_weight, row 0: nan; allowed"),
        ([0.0, 0.0], "sample_weight is 0 at all points"),
    ],
)
def test_bad_weights_are_refused(weights: list[float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        LinearFriction().fit([[50, 20, 500, 0, 1], [50, 20, 900, 0, 1]], [0.1, 0.2], sample_weight=weights)


def test_uncertainties_of_another_shape_or_load_are_refused() -> None:
    point = ([50.0], [20.0], [500.0], [0.0], [1.0])
    with pytest.raises(InputError, match=r"the uncertainty of 'T' has shape \(2,\); allowed: \(1,\)"):
        TriboLoads(*point, uncertainty={"T": np.ones(2)})
    with pytest.raises(InputError, match="unknown load with an uncertainty 'sigma'"):
        TriboLoads(*point, uncertainty={"sigma": np.ones(1)})
    bad = campaign(0)[0].assign(u_T=-1.0)
    with pytest.raises(InputError, match=r"column 'u_T', row 0: -1\.0; allowed: finite numbers from 0"):
        LinearFriction().fit_frame(bad)


def test_the_card_says_it() -> None:
    from friction_models.models.model_card import card_text

    frame = campaign(0)[0]
    data = DataSet(frame)
    model = LinearFriction()
    train(model, data)
    text = card_text(model.card)
    assert "- Uncertain loads honoured: weights by effective variance, worth " in text and "mostly T" in text
    assert 0.3 * len(frame) < model.card["data"]["load_uncertainty"]["effective_points"] < 0.9 * len(frame)
    train(model, data.without_load_uncertainty())
    assert "Uncertain loads" not in card_text(model.card)


@pytest.mark.parametrize(
    ("head", "units", "expected"),
    [
        ("T,u_T [K],u_sigma_n [GPa],u_psi [%]", None, (5.0, 10.0, 0.02)),
        ("T,u_T [degC],u_sigma_n [Pa],u_psi", None, (5.0, 1e-8, 2.0)),
        ("T,u_T,u_sigma_n,u_psi", "degF,degF,MPa,1", (5.0 / 1.8, 0.01, 2.0)),
    ],
)
def test_uncertainties_are_read_in_their_units(
    tmp_path: Path, head: str, units: str | None, expected: tuple[float, float, float]
) -> None:
    """A difference of temperature has no zero: 5 degC are 5 K."""
    lines = [f"test_id,sigma_n,psi,mu,{head}", *([f",MPa,1,1,{units}"] if units else [])]
    lines += ["a,500,1.1,0.1,20,5,0.01,2", "b,600,1.2,0.1,30,5,0.01,2"]
    (tmp_path / "points.csv").write_text("\n".join(lines) + "\n")
    stated = DataSet.load(tmp_path / "points.csv").loads().stated_uncertainty()
    assert tuple(stated[load][1] for load in ("T", "sigma_n", "psi")) == pytest.approx(expected)
