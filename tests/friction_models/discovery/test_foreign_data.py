"""Data of others: loads that are absent, constant or set values, tables with gaps, copies; synthetic throughout."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.discovery_campaigns import campaign
from friction_models import LinearFriction
from friction_models.common import InputError
from friction_models.discovery import compare, diagnose, refine
from friction_models.discovery.causes.test_groups import unrecorded_factor
from friction_models.discovery.judge.doubts import LIKELY, MOSTLY
from friction_models.discovery.refinement_rounds import history_text
from friction_models.effects import make_effect
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.unseen_loads import WITHIN, constant, other_speed, within_share
from friction_models.loads import TriboLoads
from friction_models.loads.time_steps import rests, time_steps

from ..estimation_cases import measured

Table = tuple[pd.DataFrame, pd.DataFrame]


@pytest.fixture(scope="module")
def stribeck() -> Table:
    return campaign("stribeck", seed=300, strength=1.4, thin=30, extra=0)[:2]


def test_a_fault_that_was_found_is_refined_and_stays_out_of_the_model() -> None:
    points, tests, _ = campaign("sensor_drift", seed=70, strength=1.2, thin=30, extra=0)
    tests = tests.drop(columns="role")
    answer = diagnose(points, tests)
    assert answer.effects == ["sensor_drift"]
    model = refine(points, tests, add=answer.effects)
    entry = model.error_history_[-1]
    assert entry["after"]["rmse"] < 0.8 * entry["before"]["rmse"]
    assert entry["corrects_data"] == ["sensor_drift"] and not model.exported
    assert "not in exported files" in history_text(model.error_history_)
    told = compare(
        {"mended": model, "plain": LinearFriction().fit_frame(points, tests)}, points, tests
    ).remarks()
    assert any(
        t.startswith("mended: the measurements hold sensor_drift, which its predictions leave out")
        for t in told
    )
    late = points[points["test_id"] == points["test_id"].iloc[0]].assign(test_id="t")
    alike = [model.predict_frame(late, pd.DataFrame({"test_id": ["t"], "order": [k]})) for k in (1, 80)]
    assert np.array_equal(*alike)  # the drift is no friction


def test_a_fault_that_is_none_is_still_refused() -> None:
    points, tests, _ = campaign(None, seed=22, thin=60, extra=0)
    rng = np.random.default_rng(0)
    held = rng.permutation(len(tests)) < 60
    order = tests["order"].to_numpy(float)
    points = points.merge(tests[["test_id"]].assign(odd=np.where(held, -order, order)), on="test_id")
    points["mu"] = np.maximum(points["mu"] + 4e-4 * points.pop("odd"), 1e-3)
    roles = tests.assign(role=np.where(held, "test", "train"))
    with pytest.raises(InputError, match="raises the error on 60 held-out tests"):
        refine(points, roles, add=["sensor_drift"])


@pytest.mark.parametrize("lacking", [["sigma_n"], ["T", "sigma_n", "sd", "psi", "t"]])
def test_effects_of_absent_loads_are_no_rivals(lacking: list[str], stribeck: Table) -> None:
    answer = diagnose(stribeck[0].drop(columns=lacking), stribeck[1])
    assert answer.effects == ["stribeck"] and answer.confusion_set == ["stribeck"]
    # the load that nobody recorded may be the cause, if it went with the speed
    assert LIKELY < answer.confidence <= MOSTLY
    (untested,) = (w for w in answer.warnings if "flash_temperature" in w)
    assert untested.endswith("were not tested: the data lack sigma_n")
    assert any("may as well be an effect of a load that the data lack" in w for w in answer.warnings)


@pytest.mark.nightly
def test_an_effect_with_a_constant_load_does_not_lead() -> None:
    points, tests, _ = campaign("flash_temperature", seed=3, strength=2.0, thin=30, extra=0)
    assert diagnose(points, tests).ranking[0]["effect"] == "flash_temperature"
    flat = diagnose(points.assign(sigma_n=1000.0), tests)
    first = make_effect(flat.ranking[0]["effect"])
    assert not constant(first, prepare(points.assign(sigma_n=1000.0), tests))
    assert first.name != "flash_temperature"


@pytest.mark.parametrize("mu", [0.0, pytest.param(5.0, marks=pytest.mark.nightly)])
def test_a_friction_that_is_everywhere_the_same_lacks_nothing(mu: float, stribeck: Table) -> None:
    """A channel of another quantity, or of nothing: the base leaves no error to take shares of."""
    points, tests = stribeck
    found = diagnose(points.assign(mu=mu), tests)
    assert found.verdict == "nothing_missing"
    # Nobody is told for sure what is as likely as not.
    assert ("nothing can be seen to be missing" in found.sentence) == (found.confidence <= LIKELY)


def test_structure_may_come_from_a_load_that_is_not_there(stribeck: Table) -> None:
    answer = diagnose(stribeck[0][["test_id", "sigma_n", "mu"]])
    assert answer.verdict != "nothing_missing" and answer.confidence <= LIKELY
    assert any("data lack (v_rel, T, sd)" in w for w in answer.warnings)


def ramp(v_rel: float | None, hold: float = 0.0) -> TriboLoads:
    """Return a test from 1 to 4 mm/s; with the actual speed, or a set value in its place."""
    sd = np.linspace(0.5, 30.0, 60)
    actual = np.linspace(1.0, 4.0, 60)
    t = np.cumsum(0.5 / actual) + hold * (sd > 15.0)
    speed = actual if v_rel is None else np.full(60, v_rel)
    return TriboLoads(speed, np.full(60, 20.0), np.full(60, 800.0), sd, np.ones(60), t=t)


def test_the_instant_of_a_start_ends_a_rest() -> None:
    """A logger that writes it has the speed of what follows at the place of the rest; it slid 8 mm there that nobody saw."""
    table = {
        "t": [0.0, 0.1, 0.2, 20.0, 20.4, 20.5, 20.6],
        "v_rel": [20.0, 20.0, 0.0, 0.0, 20.0, 20.0, 20.0],
        "sd": [0.0, 2.0, 2.0, 2.0, 2.0, 4.0, 6.0],
    }
    frame = pd.DataFrame({"test_id": "a", **table, "T": 20.0, "sigma_n": 500.0, "psi": 1.0})
    loads = TriboLoads.from_frame(frame)
    assert rests(loads, time_steps(loads, [0])) == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.4, 0.0, 0.0])
    # a distance that is rounded stands still at points that slide
    rounded = TriboLoads.from_frame(frame.assign(v_rel=20.0, sd=[0.0, 2.0, 2.0, 398.0, 406.0, 408.0, 408.0]))
    assert not rests(rounded, time_steps(rounded, [0])).any()


def test_slow_points_are_no_rests() -> None:
    slow = ramp(200.0)
    assert not rests(slow, time_steps(slow, [0])).any()
    held = ramp(None, hold=30.0)
    assert rests(held, time_steps(held, [0])).sum() == pytest.approx(30.0, rel=0.01)


def test_a_set_value_in_place_of_the_speed_is_noticed(stribeck: Table) -> None:
    points, tests = stribeck
    assert not other_speed(prepare(points, tests))
    wrong = points.assign(
        v_rel=100.0, mu=points["mu"] + 1e-4 * (points["T"] - points["T"].mean()).clip(0.0) ** 1.3
    )
    found = prepare(wrong, tests)
    assert other_speed(found) and constant(make_effect("rate_state"), found) == ["v_rel"]
    answer = diagnose(wrong, tests)
    assert answer.ranking[0]["effect"] != "rate_state"
    assert answer.verdict == "nothing_missing" or answer.confidence <= 0.5
    assert any("another speed than v_rel" in w for w in answer.warnings)


@pytest.mark.nightly
def test_empty_cells_of_the_test_table_do_not_switch_an_effect_off() -> None:
    points, tests, _ = campaign("tool_roughness", seed=40, strength=1.5, thin=30, extra=0)
    tests = tests.drop(columns="role")
    gaps = tests.assign(Ra=tests["Ra"].where(tests.index % 9 != 4))
    answer = diagnose(points, gaps)
    assert answer.effects == ["tool_roughness"]
    assert any(
        "Ra is not recorded for 9 of 81 tests: they count with the median" in w for w in answer.warnings
    )
    model = refine(points, gaps, add=answer.effects)
    assert model.error_history_[-1]["after"]["rmse"] < model.error_history_[-1]["before"]["rmse"]
    few = diagnose(points, tests.assign(Ra=tests["Ra"].where(tests.index % 9 == 4)))
    assert any("tool_roughness was not tested: Ra is recorded for 9 of 81 tests" in w for w in few.warnings)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t.rename(columns={"test_id": "name"}), "has no column test_id"),
        (lambda t: t.assign(test_id="x" + t["test_id"]), "no test of the table of tests is in the data"),
    ],
)
def test_a_table_of_other_tests_is_said(change: Any, said: str, stribeck: Table) -> None:
    assert any(said in w for w in prepare(stribeck[0], change(stribeck[1])).warnings)


def test_near_copies_are_left_out_and_repeats_are_not(stribeck: Table) -> None:
    points = stribeck[0]
    near = points.assign(test_id="n" + points["test_id"], mu=points["mu"] + 1e-6)
    found = prepare(pd.concat([points, near], ignore_index=True))
    assert found.tests == prepare(points).tests
    assert any("81 tests are copies of others" in w for w in found.warnings)
    noise = np.random.default_rng(0).normal(0.0, 0.001, len(points))
    repeats = points.assign(test_id="r" + points["test_id"], mu=points["mu"] + noise)
    assert len(prepare(pd.concat([points, repeats], ignore_index=True)).tests) == 162


def test_a_table_that_holds_every_average_twice_is_a_copy_and_equal_repeats_are_not() -> None:
    speed = np.repeat([1.0, 10.0, 50.0, 100.0], 4)
    mu = 0.1 - 0.01 * np.log10(speed) + np.random.default_rng(0).normal(0.0, 0.003, 16).round(4)
    once = pd.DataFrame({"test_id": [f"a{k:02d}" for k in range(16)], "v_rel": speed, "T": 40.0, "mu": mu})
    twice = pd.concat([once, once.assign(test_id="z" + once["test_id"])], ignore_index=True)
    assert prepare(twice).tests == list(once["test_id"])
    assert any("16 tests are copies of others (exact)" in w for w in prepare(twice).warnings)
    coarse = once.assign(
        mu=once["mu"].round(2)
    )  # many agree by rounding, but not all the same number of times
    assert len(prepare(coarse).tests) == 16


def test_repeats_of_a_plan_that_agree_by_rounding_are_no_copies() -> None:
    rng = np.random.default_rng(1)
    plan = [(p, v, T) for p in (100.0, 200.0) for v in (10.0, 50.0) for T in (20.0, 80.0)] * 4
    table = pd.DataFrame(plan, columns=["sigma_n", "v_rel", "T"])
    table = table.assign(test_id=[f"r{k}" for k in range(32)], mu=rng.normal(0.1, 0.003, 32).round(3))
    assert table.drop(columns="test_id").duplicated().sum() > 3
    assert len(prepare(table).tests) == 32
    once = table.drop_duplicates(["sigma_n", "v_rel", "T"])
    some = pd.concat([once, once.iloc[:3].assign(test_id=["a", "b", "c"])], ignore_index=True)
    assert any("3 tests are copies of others" in w for w in prepare(some).warnings)


def test_points_with_gaps_are_left_out_and_counted(stribeck: Table) -> None:
    points = stribeck[0].copy()
    points.loc[points.index[5:25], "T"] = np.nan
    points.loc[points.index[40], "mu"] = np.nan
    found = prepare(points)
    assert len(found.mu) == len(points) - 21
    assert any(f"21 of {len(points)} points have no number in T, mu" in w for w in found.warnings)
    with pytest.raises(InputError, match="T"):
        prepare(points.assign(T=np.nan))


def test_points_without_a_test_or_out_of_order_are_said(stribeck: Table) -> None:
    points = stribeck[0]
    for blank in (None, "", np.nan):
        gap = points.assign(test_id=points["test_id"].where(points.index != 7, blank))
        with pytest.raises(InputError, match="column 'test_id', row 7: no value"):
            prepare(gap)
    shuffled = points.drop(columns="t").sample(frac=1.0, random_state=1)
    assert any("sd falls within 81 tests" in w for w in prepare(shuffled).warnings)
    for wrong in (points.to_numpy(), [1.0]):
        with pytest.raises(InputError, match=r"allowed: a pandas\.DataFrame"):
            diagnose(wrong)  # type: ignore[arg-type]


def test_a_model_with_an_effect_of_another_package_says_so() -> None:
    points, tests, _ = campaign(None, seed=22, thin=60, extra=0)
    model = (LinearFriction() + "wear_out").fit_frame(points, tests)
    content, arrays = model.parts()
    content["params"]["effects"][0]["name"] = "squeal"
    with pytest.raises(
        InputError, match=r"effect 'squeal' is not in the catalogue.*entry point tribofmu\.effects"
    ):
        type(model).from_parts(content, arrays)


def test_two_groups_of_tests_are_in_the_sentence() -> None:
    points, tests, _ = campaign(None, seed=22, thin=30, extra=0)
    high = points["test_id"].isin(tests["test_id"].sample(30, random_state=0))
    answer = diagnose(points.assign(mu=points["mu"] + 0.04 * high))
    assert answer.unrecorded_factor is not None and answer.verdict == "nothing_missing"
    assert answer.confidence <= LIKELY
    assert "two groups 0.04" in answer.sentence and "(30 and 51 tests; the higher one: t0" in answer.sentence


def test_averages_that_an_evaluation_wrote_are_no_metadata() -> None:
    """The mean of mu of a test would predict what is to be explained."""
    rng = np.random.default_rng(2)
    frames = []
    for k in range(16):
        level = 0.08 + 0.01 * rng.normal()
        mu = level + 0.001 * rng.normal(size=20)
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", "v_rel": 10.0 * (1 + k % 4), "mu": mu}))
    data = pd.concat(frames, ignore_index=True)
    means = data.groupby("test_id")["mu"].mean().rename("mu_mean").reset_index()
    found = diagnose(data, means)
    assert found.verdict == "nothing_missing" and found.effects == []
    named = diagnose(data, means.rename(columns={"mu_mean": "lot_value"}))
    assert named.effects == ["factor:lot_value"]  # the same numbers as a column of the laboratory


def test_offsets_of_which_most_are_the_same_give_no_warning() -> None:
    campaign = prepare(measured(np.random.default_rng(0), tests=27, points=4))
    residual = np.where(campaign.test < 3, -0.01, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = unrecorded_factor(campaign, residual)
    assert found is None


def test_the_noise_of_its_sensor_does_not_vary_a_speed() -> None:
    rng = np.random.default_rng(0)
    rows = []
    for k, v in enumerate((1.0, 3.0, 10.0, 30.0)):
        t = np.arange(200) * 0.1
        speed = v * (1.0 + 0.05 * rng.normal(size=200))
        rows.append(pd.DataFrame({"test_id": f"t{k}", "t": t, "v_rel": speed, "T": 20.0, "sigma_n": 5.0 + k, "sd": v * t, "psi": 1.0, "mu": 0.1}))  # fmt: skip
    data = pd.concat(rows, ignore_index=True)
    assert within_share(prepare(data), "v_rel") < WITHIN
    stepped = data.assign(v_rel=data["v_rel"] * np.where(data["t"] > 10.0, 1.3, 1.0))
    assert within_share(prepare(stepped), "v_rel") > 5.0 * WITHIN


def test_three_groups_of_tests_are_in_the_sentence() -> None:
    """Three batches that nobody recorded: each hides the others from a search for two."""
    points, tests, _ = campaign(None, seed=22, thin=30, extra=0)
    level = dict(zip(tests["test_id"], np.random.default_rng(1).permutation(81) % 3, strict=True))
    found = diagnose(points.assign(mu=points["mu"] + 0.025 * points["test_id"].map(level)))
    assert found.unrecorded_factor is not None and found.unrecorded_factor["groups"] == 3
    assert found.confidence <= LIKELY and "the tests fall into several groups up to 0.02" in found.sentence


@pytest.mark.parametrize("draw", [pytest.param("normal", marks=pytest.mark.nightly), "skewed"])
def test_hardly_any_scatter_falls_into_groups(draw: str) -> None:
    rng = np.random.default_rng(5)
    campaign = prepare(measured(rng, tests=40, points=4))
    told = 0
    for _ in range(60):
        offsets = rng.normal(size=40) if draw == "normal" else rng.gumbel(size=40)
        told += unrecorded_factor(campaign, 0.003 * offsets[campaign.test]) is not None
    assert told <= 2
