"""Prediction intervals: what share of the points of new tests they hold, where they widen, what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models import (
    ComposedFriction,
    FeedForwardFriction,
    LinearFriction,
    OnnxModel,
    PolynomialFriction,
    load_model,
)
from friction_models.common import InputError
from friction_models.effects import Stribeck
from friction_models.loads import LOAD_NAMES, DataSet, TriboLoads
from friction_models.models.base import FrictionModel
from friction_models.models.domain import Domain
from friction_models.models.intervals.calibration import TESTS_FOR_LOADS, folds_of, thinned
from friction_models.models.intervals.prediction_interval import PROBABILITIES, PredictionInterval
from friction_models.models.model_card import card_text
from friction_models.training.interval_coverage import (
    add_interval,
    coverage_measures,
    measured_coverage,
    not_measured,
    wilson,
)

from .made_up import EDGES, anywhere, campaign

OFFSET = 0.006
GAP = {"load": "T", "low": 50.0, "high": 150.0, "extra": 0.002}


@cache
def plan() -> pd.DataFrame:
    return campaign(130, 20)


def scattered(tests: int, seed: int, steep: bool = False) -> pd.DataFrame:
    """Return made-up tests drawn by `seed`, each with an offset of its own; with `steep` it is larger at higher speed."""
    rng = np.random.default_rng(1000 + seed)
    drawn = rng.permutation(130)[:tests]
    data = plan().iloc[(20 * drawn[:, None] + np.arange(20)).ravel()].reset_index(drop=True)
    offset = rng.normal(0.0, OFFSET, tests)
    if steep:
        fastest = data["v_rel"].to_numpy().reshape(tests, 20).max(axis=1)
        offset *= np.where(fastest > 250.0, 2.0, np.where(fastest > 50.0, 1.0, 0.5))
    mu = data["mu"].to_numpy() + np.repeat(offset, 20) + rng.normal(0.0, 0.0015, 20 * tests)
    names = np.repeat([f"t{k:03d}" for k in range(tests)], 20)
    return data.assign(mu=np.maximum(mu, 0.0), test_id=names)


def halves(data: pd.DataFrame, train: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    _, test = np.unique(data["test_id"].to_numpy().astype(str), return_inverse=True)
    return data[test < train], data[test >= train]


def calibrated(model: FrictionModel, data: pd.DataFrame, **options: Any) -> FrictionModel:
    return model.fit_frame(data).calibrate(TriboLoads.from_frame(data), data["mu"], **options)


def covered(model: FrictionModel, data: pd.DataFrame, level: float | None = None) -> dict[str, float]:
    low, high = model.predict_interval_frame(data, level=level)
    ids = data["test_id"].to_numpy().astype(str)
    return coverage_measures(data["mu"].to_numpy(), low, high, ids, 0.95)


@pytest.fixture(scope="module")
def model() -> FrictionModel:
    return calibrated(LinearFriction(), scattered(40, 3))


@pytest.mark.parametrize(
    ("family", "train"), [(LinearFriction, 60), (PolynomialFriction, 40), (LinearFriction, 12)]
)
def test_new_tests_lie_within_as_often_as_the_level_says(family: type[FrictionModel], train: int) -> None:
    shares, narrow = [], []
    for seed in range(16):
        seen, new = halves(scattered(train + 40, seed), train)
        model = calibrated(family(), seen)
        shares.append(covered(model, new)["share"])
        narrow.append(covered(model, new, level=0.8)["share"])
    # 0.95 +- what 16 calibrations on so many tests leave open; few tests make it cautious rather than bold.
    assert 0.93 <= np.mean(shares) <= 0.99
    assert np.mean([0.90 <= s <= 1.0 for s in shares]) >= 0.8
    assert 0.76 <= np.mean(narrow) <= (0.88 if train > 19 else 0.93)


def test_a_better_coverage_is_never_less_sure() -> None:
    groups = np.repeat([f"t{k}" for k in range(10)], 100)
    lows = []
    for missed in (40, 10, 1, 0):
        mu = np.zeros(1000)
        mu[:missed] = 1.0
        measures = coverage_measures(mu, mu * 0.0 - 0.5, mu * 0.0 + 0.5, groups, 0.95)
        lows.append(measures["share_low"])
    assert lows == sorted(lows) and lows[-1] == pytest.approx(wilson(1.0, 30)[0])


def test_points_taken_as_independent_would_promise_too_much() -> None:
    naive, ours = [], []
    for seed in range(6):
        seen, new = halves(scattered(45, seed), 15)
        model = calibrated(PolynomialFriction(), seen)
        margin = np.quantile(np.abs(model.predict_frame(seen) - seen["mu"]), 0.95)
        naive.append(np.mean(np.abs(model.predict_frame(new) - new["mu"]) <= margin))
        ours.append(covered(model, new)["share"])
    assert np.mean(naive) < 0.80 and np.mean(ours) > 0.93


def test_width_follows_the_loads_where_the_tests_show_it() -> None:
    found = []
    for steep in (False, True):
        slopes = []
        for seed in range(12):
            interval = calibrated(PolynomialFriction(), scattered(81, seed, steep)).interval
            assert interval is not None
            slopes.append(interval.slopes)
        found.append(np.mean([any(s) for s in slopes]))
        speed = np.mean([s[0] for s in slopes if any(s)] or [0.0])
    assert found[0] <= 0.34 and found[1] >= 0.4
    assert speed > 0.1
    few = calibrated(LinearFriction(), scattered(TESTS_FOR_LOADS - 1, 0, steep=True)).interval
    assert few is not None and not any(few.slopes)


def test_outside_the_domain_it_widens_from_the_border_on(model: FrictionModel) -> None:
    border = model.domain.centre.copy()
    border[1] = model.domain.upper[1]
    beyond = border.copy()
    beyond[1] += 2.0 * model.domain.scale[1]
    low, high = model.predict_interval(np.array([model.domain.centre, border, beyond]))
    width = high - model.predict(np.array([model.domain.centre, border, beyond]))
    assert width[1] == pytest.approx(width[0]) and width[2] == pytest.approx(3.0 * width[1])
    for loads in (EDGES, anywhere(200)):
        low, high = model.predict_interval(loads)
        mu = model.predict(loads)
        assert (low >= 0.0).all() and (low <= mu).all() and (mu <= high).all() and np.isfinite(high).all()
    assert all(len(b) == 0 for b in model.predict_interval(np.empty((0, 5))))


def test_factor_is_the_quantile_corrected_for_one_test_more() -> None:
    content = {
        "level": 0.95, "tests": 19, "points": 190, "constant": 0.0, "slopes": dict.fromkeys(LOAD_NAMES, 0.0),
        "scores": PROBABILITIES.tolist(), "source": "by hand",
    }  # fmt: skip
    domain = Domain.physical()
    interval = PredictionInterval.from_dict(content, domain)
    assert interval.method() == "conformal" and interval.factor() == 1.0  # the largest of 19 is just enough
    assert interval.factor(0.5) == pytest.approx(0.53)  # 0.5 * 20 / 19 = 0.526, the next probability kept
    assert interval.method(0.96) == "student"
    # Uniform scores have a mean square of 1/3; t(18 degrees of freedom, 0.98) = 2.214.
    assert interval.factor(0.96) == pytest.approx(2.2137 * np.sqrt(20 / 19 / 3), rel=1e-3)
    assert PredictionInterval.from_dict(json.loads(json.dumps(interval.to_dict())), domain) == interval


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"scores": [1.0]}, "1 scores"),
        ({"scores": [float("nan")] * len(PROBABILITIES)}, "finite"),
        ({"scores": PROBABILITIES[::-1].tolist()}, "never fall"),
        ({"constant": 1e9}, "too large"),
        ({"constant": 1e3}, "rises to 1"),
        ({"slopes": dict.fromkeys(LOAD_NAMES, 0.0) | {"T": 1e3}}, "rises to"),
        ({"slopes": {"v_rel": 1.0}}, "missing"),
        ({"level": 1.0}, "0.5 to 0.999"),
        ({"tests": 2}, "tests is 2"),
        ({"coverage": {"test": 3}}, "missing or not a number"),
        ({"coverage": {"test": {"share": 0.9}}}, "coverage of 1 roles"),
        ({"source": "x" * 1000}, "too long"),
        ({"coverage": [3]}, "missing or not a number"),
        ({"between": 3}, "between = 3"),
        ({"between": [{"load": "v"}]}, "allowed: load"),
        ({"between": [GAP | {"extra": -0.1}]}, "between.extra is -0.1"),
        ({"between": [GAP | {"high": 20.0}]}, "low below high"),
        ({"between": [{**GAP, "load": "psi", "low": -2.0}]}, "between.low is -2"),
        ({"between": [{**GAP, "load": "v_rel", "low": -5.0}]}, "between.low is -5"),
        ({"between": [GAP] * 21}, "at most 20"),
    ],
)
def test_stored_intervals_are_checked(model: FrictionModel, change: dict[str, object], said: str) -> None:
    assert model.interval is not None
    with pytest.raises(InputError, match=said):
        PredictionInterval.from_dict(model.interval.to_dict() | change, model.domain)


def test_width_along_a_load_that_hardly_varies_is_kept(tmp_path: Path) -> None:
    """Its slope is steep, and the constant as large."""
    rng = np.random.default_rng(1)
    tests, points = 60, 10
    ids = np.repeat([f"t{k:02d}" for k in range(tests)], points)
    speed, psi = np.repeat(
        [rng.uniform(10.0, 200.0, tests), 1.2 + rng.uniform(0.0, 1e-3, tests)], points, axis=1
    )
    loads = np.column_stack([speed, np.full(len(ids), 300.0), np.full(len(ids), 200.0), 0.1 * speed, psi])
    offset = np.repeat(0.002 * rng.normal(size=tests), points) * np.exp(3e3 * (psi - 1.2005))
    model = LinearFriction().fit(loads, np.clip(0.1 + offset, 0.0, 1.0), ids)
    model.calibrate(loads, np.clip(0.1 + offset, 0.0, 1.0), ids)
    assert model.interval is not None and max(map(abs, model.interval.slopes)) > 100.0
    read = load_model(model.save(tmp_path / "model"))
    assert read.interval == model.interval
    assert read.predict_interval(loads)[1] == pytest.approx(model.predict_interval(loads)[1])


def test_too_few_tests_are_refused() -> None:
    data = scattered(6, 0)
    seen, _ = halves(data, 3)
    with pytest.raises(InputError, match="3 tests, allowed: at least 4"):
        calibrated(LinearFriction(), seen)
    with pytest.raises(InputError, match="0 tests"):
        LinearFriction().fit(seen[list(LOAD_NAMES)], seen["mu"]).calibrate(
            seen[list(LOAD_NAMES)].to_numpy(), seen["mu"]
        )
    with pytest.raises(InputError, match="level is 1"):
        calibrated(LinearFriction(), data, level=1.5)
    with pytest.raises(InputError, match="not fitted"):
        LinearFriction().calibrate(TriboLoads.from_frame(data), data["mu"])
    with pytest.raises(InputError, match="call calibrate first"):
        LinearFriction().fit_frame(data).predict_interval_frame(data)


def test_a_new_fit_has_no_interval_and_models_without_one_say_nothing_of_it(
    model: FrictionModel, tmp_path: Path
) -> None:
    data = scattered(40, 3)
    plain = LinearFriction().fit_frame(data)
    assert "interval" not in plain.card and plain.interval_level is None
    again = calibrated(LinearFriction(), data)
    assert again.fit_frame(data).interval is None
    plain.save(tmp_path / "plain"), again.save(tmp_path / "again"), model.save(tmp_path / "with")
    for name in ("model.onnx", "card.json"):
        assert (tmp_path / "plain" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()
    session = OnnxModel(tmp_path / "plain" / "model.onnx")
    assert not session.has_interval
    with pytest.raises(InputError, match="no prediction interval"):
        session.predict_interval(anywhere(2))
    assert "## Prediction interval" in (tmp_path / "with" / "card.md").read_text()
    assert load_model(tmp_path / "with").interval == model.interval


def test_networks_use_the_tests_they_left_out() -> None:
    data = campaign(60, 4, seed=1)
    loads, mu, ids = (
        TriboLoads.from_frame(data),
        data["mu"].to_numpy(),
        data["test_id"].to_numpy().astype(str),
    )
    model = FeedForwardFriction(hidden=(4,), members=8, epochs=2).fit_frame(data)
    predicted, source = model.left_out(loads, mu, ids, 5, 0)
    seen = np.isfinite(predicted)
    assert set(ids[seen]) == set(model.validation_tests_) and "networks" in source
    assert np.abs(predicted[seen] - model.predict(loads)[seen]).max() > 0.0
    always = FeedForwardFriction(hidden=(4,), members=1, epochs=2, validation_fraction=0.0).fit_frame(data)
    predicted, source = always.left_out(loads, mu, ids, 2, 0)
    assert np.isfinite(predicted).all() and "folds" in source


def test_folds_leave_out_whole_tests_and_thin_long_ones() -> None:
    ids = np.repeat(["b", "a", "c"], [1000, 150, 3])
    rows = thinned(ids)
    assert [int((ids[rows] == t).sum()) for t in "abc"] == [100, 100, 3]
    assert {0, 999, 1000, 1149} <= set(rows.tolist()) and (np.diff(rows) > 0).all()
    data = scattered(8, 2)
    loads, mu = TriboLoads.from_frame(data), data["mu"].to_numpy()
    names = data["test_id"].to_numpy().astype(str)
    model = LinearFriction().fit_frame(data)
    predicted, _ = folds_of(model, loads, mu, names, 8, 0)
    own = names == names[0]
    alone = LinearFriction().fit(loads.take(~own), mu[~own], names[~own])
    np.testing.assert_allclose(predicted[own], alone.predict(loads.take(own)), rtol=1e-12)


def test_coverage_counts_every_test_alike() -> None:
    ids = np.repeat(["a", "b"], [90, 10])
    mu = np.r_[np.full(90, 0.1), np.full(10, 0.3)]
    measures = coverage_measures(mu, np.zeros(100), np.full(100, 0.2), ids, 0.95)
    assert measures["share"] == 0.5 and measures["points"] == 0.9 and measures["worst_test"] == 0.0
    # Wilson (1927): 81 of 100 gives 0.7222 to 0.8749.
    assert wilson(0.81, 100) == pytest.approx((0.7222, 0.8749), abs=1e-4)
    assert measures["share_low"] == pytest.approx(wilson(0.5, 2)[0])


def test_coverage_is_measured_on_the_tests_held_out() -> None:
    points = scattered(60, 5)
    names = sorted(set(points["test_id"]))
    tests = pd.DataFrame({"test_id": names, "role": ["train"] * 40 + ["test"] * 20})
    data = DataSet(points, tests, {"synthetic": True})
    train = data.select("train")
    model = LinearFriction().fit_frame(train.points, train.tests)
    interval = add_interval(model, data)
    assert set(interval.coverage) == {"test"} and interval.coverage["test"]["tests"] == 20
    assert 0.8 <= interval.coverage["test"]["share"] <= 1.0
    assert set(measured_coverage(model, data)) == {"train", "test", "all"}
    assert model.card["interval"]["coverage"]["test"]["expected"] == 0.95


def test_what_no_test_measured_is_told_beside_the_interval() -> None:
    """Tests at three speeds, spread over temperature and pressure: only the speed has gaps."""

    def at(speeds: tuple[float, ...]) -> DataSet:
        rng = np.random.default_rng(1)
        parts = []
        for k in range(60):
            v, T, p = speeds[k % len(speeds)], rng.uniform(20.0, 300.0), rng.uniform(500.0, 2000.0)
            loads = {"v_rel": v, "T": T, "sigma_n": p, "sd": np.linspace(0.5, 20.0, 15), "psi": 1.1}
            parts.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": 0.1 + 0.001 * rng.normal()}))
        return DataSet(pd.concat(parts, ignore_index=True), None)

    assert "(v_rel 5 to 50 and 50 to 500 mm/s)" in not_measured(at((5.0, 50.0, 500.0)))
    assert not_measured(at((5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 500.0))) == ""


def curved(
    levels: tuple[float, ...], bend: float, scatter: float = 0.0
) -> tuple[TriboLoads, np.ndarray, np.ndarray]:
    """Return tests at levels of T whose friction is a parabola in T, and a line in all other loads."""
    rng = np.random.default_rng(3)
    tests = [f"t{k:02d}" for k in range(10 * len(levels))]
    T = np.repeat(np.tile(levels, 10), 8)
    v, p = (np.repeat(rng.uniform(*ends, len(tests)), 8) for ends in ((5.0, 500.0), (400.0, 2000.0)))
    loads = TriboLoads(v, T, p, np.tile(np.linspace(1.0, 20.0, 8), len(tests)), np.ones(len(T)))
    offsets = np.repeat(scatter * rng.normal(size=len(tests)), 8)
    return loads, 0.1 - 1e-5 * v + bend * T**2 + offsets, np.repeat(tests, 8)


def test_between_levels_it_widens_by_what_a_fit_without_a_level_misses_there() -> None:
    """A line through 0 and 200 degC misses the parabola at 100 degC by ``bend * 100**2``."""
    loads, mu, tests = curved((0.0, 100.0, 200.0), 1e-6)
    model = LinearFriction().fit(loads, mu, tests).calibrate(loads, mu, tests)
    assert model.interval is not None
    # less what tests left out one by one are missed by: a line through three levels lies off by a third at the middle one
    assert [(w.load, w.low, w.high) for w in model.interval.between] == [
        ("T", 0.0, 100.0),
        ("T", 100.0, 200.0),
    ]
    for widening in model.interval.between:
        assert 0.8 * 0.01 < widening.extra < 0.01
    low, high = model.predict_interval([[50, T, 1000, 5, 1] for T in (0.0, 50.0, 75.0, 100.0, 200.0, 250.0)])
    half = 0.5 * (high - low)
    assert half[0] == pytest.approx(half[3]) == pytest.approx(half[4])  # at the levels
    assert half[1] - half[0] == pytest.approx(model.interval.between[0].extra)
    assert half[2] - half[0] == pytest.approx(0.5 * model.interval.between[0].extra)
    assert half[5] == pytest.approx(1.25 * half[4])  # beyond the domain by a quarter of its range
    assert "Between the levels of the plan more, in the middle by" in card_text(model.card)


@pytest.mark.parametrize(
    ("levels", "bend", "scatter"),
    [
        (
            (0.0, 100.0, 200.0),
            0.0,
            0.002,
        ),  # a line is what the law is: scatter of ten tests is all that is missed
        ((0.0, 200.0), 1e-6, 0.0),  # of two levels none lies between others
        (tuple(np.linspace(0.0, 200.0, 9)), 1e-6, 0.0),  # no gaps
    ],
)
def test_where_levels_show_no_miss_it_stays_as_wide(
    levels: tuple[float, ...], bend: float, scatter: float
) -> None:
    loads, mu, tests = curved(levels, bend, scatter)
    model = LinearFriction().fit(loads, mu, tests).calibrate(loads, mu, tests)
    assert model.interval is not None
    assert all(w.extra == 0.0 for w in model.interval.between)
    assert bool(model.interval.between) == (bend == 0.0)  # there a level was left out, and not missed


@pytest.mark.parametrize("seed", range(3))
def test_halfway_between_three_levels_it_holds_what_it_promises(seed: int) -> None:
    """Friction falls with speed by a law of no family: at 5, 50 and 500 mm/s line and effect meet it, at 16 and 160 mm/s they do not."""
    rng = np.random.default_rng(seed)

    def at(speeds: tuple[float, ...], count: int) -> tuple[TriboLoads, np.ndarray, np.ndarray]:
        v = np.repeat(np.tile(speeds, count), 5)
        names = [f"t{k:03d}" for k in range(len(v) // 5)]
        sd, same = np.tile(np.linspace(1.0, 20.0, 5), len(names)), np.ones(len(v))
        mu = 0.06 + 0.04 / (1.0 + (v / 20.0) ** 1.7) + np.repeat(rng.normal(0.0, 0.001, len(names)), 5)
        return TriboLoads(v, 20.0 * same, 800.0 * same, sd, same), mu, np.repeat(names, 5)

    loads, mu, tests = at((5.0, 50.0, 500.0), 12)
    further, friction, _ = at((16.0, 160.0), 20)
    model = ComposedFriction(LinearFriction(), [Stribeck()]).fit(loads, mu, tests).calibrate(loads, mu, tests)
    held = []
    for between in (model.interval_.between, ()):
        model.interval_ = replace(model.interval_, between=between)
        low, high = model.predict_interval(further)
        held.append(float(np.mean((friction >= low) & (friction <= high))))
    assert held[0] > 0.95 > 0.3 > held[1]
