"""Intervals of fitted parameters hold the true ones about as often as they say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from friction_models import ConstantFriction, LinearFriction
from friction_models.discovery.answer.fit_warnings import about_the_fit
from friction_models.discovery.causes.run_order import about_jumps, jumps_in_order
from friction_models.effects import make_effect
from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.fit.parameters import fit_terms
from friction_models.estimation.search.base_law import base_law

from .estimation_cases import measured

DELTA, LENGTH = 0.03, 6.0
#: Offsets of lots of lubricant; their mean is zero.
LOTS = {"lot A": 0.012, "lot B": -0.004, "lot C": 0.003, "lot D": -0.011}
HOTTER = {"delta_b": 0.03, "T_b": 130.0, "w": 12.0}


def running_in(seed: int, tests: int = 30) -> BinnedTests:
    """Return tests whose friction falls over the first millimetres, each with an offset and noise of its own."""
    rng = np.random.default_rng([seed, 8])
    frames = []
    for k in range(tests):
        sd = np.linspace(0.2, 50.0, 60)
        own = DELTA * (1.0 + 0.1 * rng.normal())  # tests differ in the size of the effect, too
        mu = 0.08 + own * np.exp(-sd / LENGTH) + rng.normal(0.0, 0.003) + rng.normal(0.0, 0.001, 60)
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", "sd": sd, "v_rel": 50.0, "mu": mu}))
    return prepare(pd.concat(frames, ignore_index=True))


@pytest.mark.parametrize("seeds", [12, pytest.param(30, marks=pytest.mark.nightly)])
def test_intervals_hold_the_truth(seeds: int) -> None:
    inside = {"delta_r": 0, "s_r": 0}
    for seed in range(seeds):
        campaign = running_in(seed)
        (term,) = fit_terms(
            campaign, base_law(ConstantFriction(), campaign), [make_effect("running_in")]
        ).terms
        for name, truth in (("delta_r", DELTA), ("s_r", LENGTH)):
            low, high = term.intervals[name]
            value = {**term.amplitudes, **term.shape}[name]
            assert low < value < high
            inside[name] += low <= truth <= high
    assert all(n >= 0.83 * seeds for n in inside.values()), inside


def breakdown(seed: int, tests: int = 24) -> BinnedTests:
    """Return tests of which few are hot enough to tell how a lubricant breaks down: a fit follows each of them."""
    rng = np.random.default_rng([seed, 24])
    frames = []
    for k in range(tests):
        sd = np.linspace(0.3, 40.0, 40)
        v_rel, sigma_n = np.exp(rng.uniform(np.log(10.0), np.log(500.0))), rng.uniform(300.0, 2500.0)
        T = rng.uniform(20.0, 200.0) + 0.002 * v_rel * sd
        law = (
            0.1
            - 1e-5 * sigma_n
            + 5e-5 * T
            + HOTTER["delta_b"] / (1.0 + np.exp(-(T - HOTTER["T_b"]) / HOTTER["w"]))
        )
        mu = law + rng.normal(0.0, 0.005) + rng.normal(0.0, 0.0015, 40)
        frames.append(
            pd.DataFrame(
                {"test_id": f"t{k:02d}", "v_rel": v_rel, "T": T, "sigma_n": sigma_n, "sd": sd, "mu": mu}
            )
        )
    return prepare(pd.concat(frames, ignore_index=True))


def test_intervals_hold_what_few_tests_tell() -> None:
    inside, of = 0, 0
    for seed in range(24):
        campaign = breakdown(seed)
        law = base_law(LinearFriction(), campaign, 0)
        (term,) = fit_terms(campaign, law, [make_effect("thermal_breakdown")]).terms
        for name, truth in HOTTER.items():
            low, high = term.intervals[name]
            inside, of = inside + (low <= truth <= high), of + 1
    assert inside >= 0.9 * of, (inside, of)


def at_three_speeds(seed: int) -> BinnedTests:
    """Return tests at three speeds, which do not tell how a fall and the slope of a line share what they show."""
    rng = np.random.default_rng([seed, 33])
    frames = []
    for k in range(27):
        v_rel, sd = (5.0, 50.0, 400.0)[k % 3], np.linspace(0.3, 30.0, 10)
        mu = (
            0.1
            + 0.035 * np.exp(-((v_rel / 25.0) ** 0.9))
            + rng.normal(0.0, 0.0015)
            + rng.normal(0.0, 0.001, 10)
        )
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", "v_rel": v_rel, "sd": sd, "mu": mu}))
    return prepare(pd.concat(frames, ignore_index=True))


def test_what_the_levels_of_a_plan_leave_open_is_not_known() -> None:
    """Of four parameters of the speed three levels tell two: the interval of delta_s was 0.021 to 0.022, and the truth 0.035."""
    inside = {"delta_s": 0, "v_s": 0, "d": 0}
    for seed in range(12):
        campaign = at_three_speeds(seed)
        (term,) = fit_terms(campaign, base_law(LinearFriction(), campaign), [make_effect("stribeck")]).terms
        for name, truth in (("delta_s", 0.035), ("v_s", 25.0), ("d", 0.9)):
            low, high = term.intervals[name]
            inside[name] += low <= truth <= high
    assert all(n >= 10 for n in inside.values()), inside


def lots(seed: int) -> BinnedTests:
    """Return tests with lots of lubricant that lie at levels of their own: 13, 10, 6 and 3 tests of them."""
    rng = np.random.default_rng([seed, 51])
    lot = rng.permutation(np.repeat(list(LOTS), (13, 10, 6, 3)))
    names = [f"t{k:02d}" for k in range(len(lot))]
    frames = []
    for k, own in enumerate(lot):
        sd, T = np.linspace(0.2, 50.0, 8), rng.uniform(20.0, 200.0)
        mu = 0.1 + LOTS[own] - 1e-4 * (T - 100.0) + rng.normal(0.0, 0.004) + rng.normal(0.0, 0.002, 8)
        frames.append(pd.DataFrame({"test_id": names[k], "sd": sd, "v_rel": 50.0, "T": T, "mu": mu}))
    return prepare(pd.concat(frames), pd.DataFrame({"test_id": names, "batch": lot}))


@pytest.mark.nightly
def test_intervals_of_offsets_of_levels_hold_the_truth() -> None:
    inside, width = [], []
    for seed in range(40):
        campaign = lots(seed)
        fitted = fit_terms(campaign, base_law(LinearFriction(), campaign), [make_effect("batch")])
        intervals = fitted.terms[0].intervals
        assert list(intervals) == [f"c_b[{lot}]" for lot in LOTS]
        inside.append([low <= truth <= high for truth, (low, high) in zip(LOTS.values(), intervals.values())])
        width.append([high - low for low, high in intervals.values()])
        # that one offset is less where another is more is no tie of the data
        assert not any("batch" in first and "batch" in second for first, second, _ in fitted.correlations)
    assert np.mean(inside) > 0.88
    # the scatter of three tests, and of thirteen
    assert np.mean(width, axis=0)[3] < 0.015 and np.mean(width, axis=0)[0] < 0.008


def test_more_tests_narrow_an_interval() -> None:
    def width(tests: int) -> float:
        campaign = running_in(1, tests)
        (term,) = fit_terms(
            campaign, base_law(ConstantFriction(), campaign), [make_effect("running_in")]
        ).terms
        low, high = term.intervals["delta_r"]
        return high - low

    assert width(80) == pytest.approx(width(20) / 2.0, rel=0.35)


def test_no_effects_no_terms() -> None:
    campaign = running_in(0, 8)
    assert fit_terms(campaign, base_law(ConstantFriction(), campaign), []).terms == []


def test_what_the_data_tie_is_said() -> None:
    rng = np.random.default_rng(2)
    frames = []
    for k in range(20):  # the record ends before the curve bends: size and length act as one
        sd = np.linspace(0.1, 1.0, 30)
        mu = 0.08 + DELTA * np.exp(-sd / LENGTH) + rng.normal(0.0, 0.001) + rng.normal(0.0, 1e-4, 30)
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", "sd": sd, "v_rel": 50.0, "mu": mu}))
    campaign = prepare(pd.concat(frames, ignore_index=True))
    found = fit_terms(campaign, base_law(ConstantFriction(), campaign), [make_effect("running_in")])
    assert [p[:2] for p in found.correlations] == [("running_in.delta_r", "running_in.s_r")]
    low, high = found.terms[0].intervals["s_r"]
    assert high / low > 1.5


def test_a_size_that_is_not_known_is_said() -> None:
    campaign = running_in(0)
    fitted = fit_terms(campaign, base_law(ConstantFriction(), campaign, 0), [make_effect("running_in")])
    (term,) = fitted.terms
    rising = make_effect("wear_out")  # has a physical sign
    assert about_the_fit(campaign, fitted) == []
    large = replace(term, binned=5.0 * term.binned)
    blurred = replace(term, effect=rising, intervals={rising.amplitudes[0].name: (-0.1, 0.2)})
    for other, said in ((large, "only their sum is known"), (blurred, "unseen tests say")):
        warnings = about_the_fit(campaign, replace(fitted, terms=[other]))
        assert sum(w.endswith(said) for w in warnings) == 1, warnings


def test_a_fit_at_the_end_of_its_search_says_so() -> None:
    """Friction that falls in proportion to the distance to the last point: no length of an exponential law does that."""
    rng = np.random.default_rng(3)
    frames = []
    for k in range(20):
        sd = np.linspace(0.2, 50.0, 60)
        mu = 0.12 - 8e-4 * sd + rng.normal(0.0, 0.003) + rng.normal(0.0, 0.001, 60)
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", "sd": sd, "v_rel": 50.0, "mu": mu}))
    campaign = prepare(pd.concat(frames, ignore_index=True))
    fitted = fit_terms(campaign, base_law(ConstantFriction(), campaign), [make_effect("running_in")])
    (term,) = fitted.terms
    assert term.at_limits == ["s_r"]
    assert term.at_bounds == []
    low, high = term.sought["s_r"]
    assert low < high == pytest.approx(term.shape["s_r"], rel=1e-6)
    assert f"drives s_r to {high:.4g} mm, as far as it is sought" in about_the_fit(campaign, fitted)[0]
    assert (
        not fit_terms(running_in(0), base_law(ConstantFriction(), running_in(0)), [make_effect("running_in")])
        .terms[0]
        .at_limits
    )


def in_order(seed: int, moved: Callable[[np.ndarray], np.ndarray], tests: int = 30) -> list[str]:
    """Return what is said of a fitted drift where the level of each test has moved by a function of its place in the order."""
    rng = np.random.default_rng([seed, 18])
    data = measured(rng, tests=tests, points=8, between=0.004)
    order = pd.Series(rng.permutation(np.arange(1, tests + 1)), index=data["test_id"].unique(), name="order")
    data["mu"] += moved(data["test_id"].map(order).to_numpy(dtype=float))
    campaign = prepare(data, order.rename_axis("test_id").reset_index())
    law = base_law(LinearFriction(), campaign)
    fitted = fit_terms(campaign, law, [make_effect("sensor_drift")])
    said = about_jumps(jumps_in_order(campaign, fitted), {})
    names = {int(place): str(test) for test, place in order.items()}
    return [w for w in said if f"between {names[15]} and {names[16]}," in w] + ["elsewhere"] * bool(said)


@pytest.mark.nightly
def test_levels_that_jump_are_told_from_a_drift() -> None:
    changed = [in_order(seed, lambda order: 0.016 * (order > 15)) for seed in range(12)]
    assert sum(bool(found) for found in changed) >= 11
    assert sum(len(found) == 2 for found in changed) >= 9, "the place is known"
    drifted = [in_order(seed, lambda order: 0.016 * order / 15.0) for seed in range(12)]
    warmed_up = [in_order(seed, lambda order: 0.03 * np.exp(-order / 10.0)) for seed in range(12)]
    still = [in_order(seed, np.zeros_like) for seed in range(12)]
    assert sum(bool(found) for found in [*drifted, *warmed_up, *still]) <= 1
