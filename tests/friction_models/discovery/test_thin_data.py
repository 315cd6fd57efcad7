"""Thin and bad data: a verdict or a refusal that says what is needed; never a confident wrong answer."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pytest

from benchmarks.discovery_campaigns import campaign
from friction_models.common import InputError
from friction_models.discovery import diagnose, refine
from friction_models.discovery.answer.findings import RankedEffect
from friction_models.estimation.campaign.binning import prepare
from orchestrator.cli.main import run

from ..estimation_cases import measured
from .test_next_tests import made

LOADS = ["v_rel", "T", "sigma_n", "sd", "psi"]


class Answer(NamedTuple):
    """Exit code of the command, what it said, and what it wrote; nothing where it refused."""

    code: int
    said: str
    verdict: str
    effects: list[str]
    confidence: float
    confusion_set: list[str]
    warnings: list[str]
    ranking: list[RankedEffect]


Ask = Callable[..., Answer]


@pytest.fixture(scope="module")
def null() -> tuple[pd.DataFrame, pd.DataFrame]:
    return campaign(None, seed=22, thin=40, extra=0)[:2]


@pytest.fixture(scope="module")
def worn() -> tuple[pd.DataFrame, pd.DataFrame]:
    return campaign("wear_out", seed=21, strength=1.2, thin=40, extra=0)[:2]


@pytest.fixture
def answer(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Ask:
    """Diagnose through the command line; what it writes, with the exit code and what it said."""
    monkeypatch.delenv("TRIBOFMU_TRACEBACK", raising=False)

    def ask(points: pd.DataFrame, tests: pd.DataFrame | None = None, model: str = "linear") -> Answer:
        points.to_csv(tmp_path / "points.csv", index=False)
        words = [
            "diagnose",
            "--data",
            str(tmp_path / "points.csv"),
            "--model",
            model,
            "--json",
            str(tmp_path / "d.json"),
        ]
        if tests is not None:
            tests.drop(columns="role").to_csv(tmp_path / "tests.csv", index=False)
            words += ["--tests", str(tmp_path / "tests.csv")]
        code = run(words)
        said = capsys.readouterr()
        assert "Traceback" not in said.err and code in {0, 2}, said.err
        if code:
            # tests of the table that were left out are told before
            assert len([line for line in said.err.splitlines() if not line.startswith("note: ")]) == 1
            return Answer(code, said.err, "", [], 0.0, [], [], [])
        content = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))
        return Answer(code, said.out, *(content[name] for name in Answer._fields[2:]))

    return ask


def some(points: pd.DataFrame, count: int) -> pd.DataFrame:
    names = list(dict.fromkeys(points["test_id"]))[10 : 10 + count]
    return points[points["test_id"].isin(names)]


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_few_tests_never_give_a_confident_answer(count: int, answer: Ask, worn: Any, null: Any) -> None:
    for points in (worn[0], null[0]):
        found = answer(some(points, count))
        assert found.verdict in {"nothing_missing", "ambiguous", "explained", "unknown_structure"}
        right = "wear_out" in found.confusion_set and points is worn[0]
        assert found.confidence <= 0.5 or found.verdict == "nothing_missing" or right
        if count < 3:
            assert found.verdict == "nothing_missing" and "at least 3 are needed" in found.said
        assert any("test" in w for w in found.warnings)


def eight(seed: int, fall: float) -> pd.DataFrame:
    """Return eight tests with scatter among them along which mu falls as 1/(1 + sd), another form than the catalogue's."""
    data = measured(np.random.default_rng(seed), tests=8, points=24, between=0.006, sensor=0.002)
    return data.assign(mu=data["mu"] + fall / (1.0 + data["sd"]))


@pytest.mark.parametrize(
    ("seeds", "least"), [(range(2, 3), 1), pytest.param(range(6), 4, marks=pytest.mark.nightly)]
)
def test_what_every_test_shows_along_its_path_is_named_however_much_they_scatter(
    seeds: range, least: int
) -> None:
    named = [diagnose(eight(seed, 0.02), seed=0).effects[:1] for seed in seeds]
    assert sum(names == ["running_in"] for names in named) >= least
    assert not any(diagnose(eight(seed, 0.0), seed=0).effects for seed in seeds)


@pytest.mark.parametrize("seed", range(4))
def test_eight_tests_say_what_they_could_not_show(seed: int) -> None:
    """Eight tests of one point each, over which friction drops by half at 150 degC: a line and a scatter that nobody knows hold that."""
    rng, T = np.random.default_rng(seed), np.linspace(20.0, 250.0, 8)
    p, v = rng.uniform(200.0, 1500.0, 8), np.exp(rng.uniform(1.0, 5.0, 8))
    mu = 0.1 - 0.04 / (1.0 + np.exp(-(T - 150.0) / 10.0)) + 0.0005 * rng.standard_normal(8)
    table = {"v_rel": v, "T": T, "sigma_n": p, "sd": 10.0, "psi": 2.0, "mu": mu}
    found = diagnose(pd.DataFrame({"test_id": [f"t{i}" for i in range(8)], **table}))
    # the noise around a mean that went through all eight was nothing, and any effect as clear as that
    assert found.ranking[0]["evidence"] < 1e3
    told = [
        w
        for w in found.warnings
        if "stands out" in w or ("would not show in tests like these" in w and "T" in w)
    ]
    assert bool(found.effects) != bool(told), found.warnings
    # not "nothing is missing" beside that
    assert not told or found.sentence.startswith("nothing can be seen to be missing")


def test_loads_that_never_vary_are_refused_and_one_level_is_said(answer: Ask, worn: Any) -> None:
    points, tests = worn
    flat = points.assign(v_rel=50.0, T=50.0, sigma_n=900.0, sd=10.0, psi=1.2)
    assert "none of the loads" in answer(flat, tests).said
    assert "nor about" not in answer(flat, None).said  # no table, no word of it
    said = answer(
        flat, tests.assign(leg=["left", "right"] * (len(tests) // 2) + ["left"] * (len(tests) % 2))
    ).said
    assert "leg" in said.split("nor about columns of the test table (")[1].split(") alone; allowed:")[0]
    level = points.assign(v_rel=50.0, T=50.0, sigma_n=900.0, psi=1.2)  # the distance alone
    found = answer(level, None)
    assert found.code == 0 and sum("does not vary" in w for w in found.warnings) == 4
    named = set(found.confusion_set)
    assert "wear_out" in named


def test_averaged_points_cannot_show_effects_along_a_test(answer: Ask, worn: Any) -> None:
    points, tests = worn
    mean = points.groupby("test_id", as_index=False).mean(numeric_only=True)
    found = answer(mean, tests)
    assert not {"running_in", "static_peak", "wear_out"} & {r["effect"] for r in found.ranking}
    assert any("averaged data" in w for w in found.warnings)
    few = answer(mean.iloc[:6], tests)
    assert few.code == 2 and "more tests or by time series" in few.said


@pytest.mark.nightly
def test_without_metadata_physics_is_still_found(answer: Ask, worn: Any) -> None:
    points, tests = worn
    bare = answer(points, tests[["test_id", "role"]])
    assert bare.effects == ["wear_out"]
    assert sum("the test table has no" in w for w in bare.warnings) >= 3
    assert answer(points).effects == ["wear_out"]


@pytest.mark.parametrize(("share", "verdict"), [(0.02, "nothing_missing"), (0.12, "data_problem")])
def test_outliers_are_left_out_or_called_a_fault(share: float, verdict: str, answer: Ask) -> None:
    points, tests, _ = campaign(None, seed=22, thin=8, extra=0)
    rng = np.random.default_rng(0)
    rows = rng.choice(len(points), int(share * len(points)), replace=False)
    points.loc[rows, "mu"] += rng.exponential(0.2, len(rows))
    found = answer(points, tests)
    assert found.verdict == verdict and not found.effects
    assert any("far off" in w for w in found.warnings)


def test_copies_of_tests_confirm_nothing(answer: Ask, null: Any) -> None:
    points, tests = null
    copies = [points.assign(test_id=f"{k}" + points["test_id"]) for k in range(4)]
    found = answer(pd.concat(copies, ignore_index=True))
    single = answer(points.assign(test_id="0" + points["test_id"]))
    assert found.verdict == single.verdict == "nothing_missing"
    assert any(f"{3 * len(tests)} tests are copies of others (exact)" in w for w in found.warnings)


@pytest.mark.parametrize(
    "kept",
    [
        ["sd"],
        *(pytest.param(k, marks=pytest.mark.nightly) for k in (["v_rel", "sd"], ["T", "sigma_n", "sd"])),
    ],
)
def test_any_subset_of_the_loads_is_judged(kept: list[str], answer: Ask, worn: Any) -> None:
    points, tests = worn
    found = answer(points[["test_id", *kept, "mu"]], tests)
    assert found.code == 0
    assert any("the data lack" in w and all(n in w for n in LOADS if n not in kept) for w in found.warnings)
    assert found.ranking[0]["effect"] == "wear_out"


def test_what_cannot_be_judged_is_refused_with_what_is_needed(answer: Ask, worn: Any) -> None:
    points, tests = worn
    cases = {
        "nan": points.assign(mu=np.where(np.arange(len(points)) % 9 == 7, np.nan, points["mu"])),
        "is the sign of the force wrong?": points.assign(mu=-points["mu"]),
        "the columns of all loads are missing": points[["test_id", "mu"]],
        "time must not run backwards": pd.concat([points, points.assign(mu=1.01 * points["mu"])]).sort_values(
            "test_id", kind="stable"
        ),
        "at least": points.iloc[:2],
    }
    for text, bad in cases.items():
        found = answer(bad, tests)
        assert found.code == 2 and text in found.said, (text, found.said)
    with pytest.raises(InputError, match="no points"):
        diagnose(points.iloc[:0])


def test_points_without_tests_are_taken_as_averages(null: Any) -> None:
    points = null[0].iloc[::8]
    found = diagnose(points.assign(test_id=[f"p{k}" for k in range(len(points))]))
    assert any("averaged data" in w for w in found.warnings)
    with pytest.raises(InputError, match="averages of mu from 1 tests"):
        diagnose(points.drop(columns=["test_id", "t"]))  # 81 tests strung together are no single one


@pytest.mark.nightly
def test_two_thousand_tests_are_judged() -> None:
    parts, rng = [], np.random.default_rng(4)
    points, _, _ = campaign("stribeck", seed=300, strength=1.0, thin=90)
    for k in range(18):
        own = rng.normal(0.0, 0.005, points["test_id"].nunique())[pd.factorize(points["test_id"])[0]]
        mu = points["mu"] + own + rng.normal(0.0, 0.002, len(points))
        parts.append(points.assign(test_id=f"{k}-" + points["test_id"], mu=np.maximum(mu, 1e-3)))
    many = pd.concat(parts, ignore_index=True)
    assert many["test_id"].nunique() == 1998
    found = diagnose(many)
    # the 18 repeats of a set point share the offset of one test: more than the effect can be predicted
    assert found.effects[:1] == ["stribeck"] and found.verdict in {
        "explained",
        "ambiguous",
        "partly_explained",
    }


def test_what_no_effect_explains_is_placed_somewhere() -> None:
    """Speed steps in four stages: the best effect leaves much along its own loads, and no block of structure stands out."""
    rng = np.random.default_rng(0)
    sd = np.linspace(0.0, 4.8, 300)
    steps = np.array([0.01, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 0.01])
    stages = []
    for k in range(4):
        v = steps[np.minimum((sd / 0.6).astype(int), 7)] * np.exp(rng.normal(0.0, 0.1, 300))
        bump = 0.0071 * np.exp(-((np.log10(v / 0.03) / 0.4) ** 2)) + 0.0042 * np.log10(v / 0.001)
        along = 0.0016 * k * sd / 3.0 - 0.0114 * (k == 0) * np.exp(-sd / 0.5) + 0.004 * k
        mu = 0.58 + bump + along + rng.normal(0.0, 0.0007, 300)
        t = np.cumsum(np.gradient(sd) / v)
        loads = {"v_rel": v, "T": 25.0, "sigma_n": 5.0 * (k + 1), "sd": sd, "psi": 1.0}
        stages.append(pd.DataFrame({"test_id": f"t{k}", "t": t, **loads, "mu": mu}))
    answer = diagnose(pd.concat(stages, ignore_index=True), model="constant")
    assert answer.verdict == "unknown_structure"
    place = answer.where[0]
    assert 0.0 < place["share"] <= 1.0 and place["variables"]
    assert place["variables"][0] in answer.sentence
    assert place["shape"] in answer.report()


def test_what_two_loads_that_move_together_do_is_not_said_of_one_of_them_for_sure() -> None:
    rng = np.random.default_rng(4)
    data = measured(rng, tests=30, points=10, between=0.001, sensor=0.0005)
    law = 0.03 / (1.0 + (data["T"] / 60.0) ** 2)
    free = diagnose(data.assign(mu=data["mu"] + law))
    # speed and temperature set by the same handle
    tied = data.assign(v_rel=data["T"] * (1.0 + 0.01 * rng.normal(size=30))[data["test_id"].factorize()[0]])
    answer = diagnose(tied.assign(mu=data["mu"] + law))
    assert free.verdict == "explained" and free.confidence > 0.5, free.sentence
    of_speed = {"rising_speed", "stribeck", "viscous", "hersey", "flash_temperature", "rate_state"}
    assert answer.confidence <= 0.5 or of_speed & {*answer.confusion_set}, answer.sentence
    assert any("moves with v_rel" in w or "v_rel and T move together" in w for w in answer.warnings)


def test_tests_that_do_not_rule_an_effect_out_say_which_would(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [(300.0, 5.0, 20.0), (1200.0, 5.0, 300.0), (2000.0, 25.0, 150.0), (600.0, 25.0, 20.0)]
    rows += [(300.0, 100.0, 300.0), (1200.0, 100.0, 150.0), (2000.0, 400.0, 20.0), (600.0, 400.0, 300.0)]
    points, tests = made(rows, "T", 2)
    scatter = np.random.default_rng(11).normal(0.0, 0.0015, len(rows))
    points["mu"] += points["test_id"].map(dict(zip(tests["test_id"], scatter, strict=True)))
    points["mu"] += 0.01 / (1.0 + (points["v_rel"] / 30.0) ** 2)
    points.to_csv(tmp_path / "points.csv", index=False)
    tests.to_csv(tmp_path / "tests.csv", index=False)
    assert (
        run(["diagnose", "--data", str(tmp_path), "--model", "linear", "--plan", str(tmp_path / "p.csv")])
        == 0
    )
    said = capsys.readouterr().out
    assert "these tests do not rule it out" in said and "what friction does between the levels" in said
    assert "more would tell, at other levels of v_rel, T, sigma_n" in said


def test_where_no_test_is_proposed_no_plan_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    places = np.random.default_rng(3).permuted(np.tile(np.arange(30) / 29.0, (3, 1)), axis=1).T
    rows = [(300.0 + 1700.0 * a, 5.0 * 80.0**b, 20.0 + 280.0 * c) for a, b, c in places]
    points, tests = made(rows, "T", 2)
    points["mu"] -= 0.02 * np.exp(-(points["T"] - 20.0) / 60.0)
    points.to_csv(tmp_path / "points.csv", index=False)
    tests.to_csv(tmp_path / "tests.csv", index=False)
    plan = tmp_path / "p.csv"
    assert run(["diagnose", "--data", str(tmp_path), "--model", "linear", "--plan", str(plan)]) == 0
    assert "no plan written: no test within the tested range" in capsys.readouterr().out and not plan.exists()


def held(seed: int, spread: float, levels: tuple[float, ...] = (0.165,)) -> pd.DataFrame:
    """Return 48 averages over speeds at pressures that a machine holds within a `spread`; mu is bent in the speed."""
    rng = np.random.default_rng(seed)
    v = np.repeat(np.geomspace(0.5, 160.0, 8), 6)
    sigma = np.resize(np.array(levels), len(v)) * (1.0 + spread * rng.normal(size=len(v)))
    mu = 0.06 + 0.05 * np.exp(-v / 4.0) + 0.02 * v / 160.0 + 0.004 * rng.normal(size=len(v))
    names = [f"t{k:02d}" for k in range(len(v))]
    return pd.DataFrame({"test_id": names, "v_rel": v, "sigma_n": sigma, "mu": mu})


def test_a_pressure_that_a_machine_holds_does_not_vary() -> None:
    campaign = prepare(held(0, 0.007))
    assert campaign.varied == ["v_rel"]
    assert any(
        w.startswith("sigma_n varies only as it is held (0.16") and " MPa)" in w for w in campaign.warnings
    )
    found = diagnose(held(0, 0.007), model="constant")
    assert not {"pressure_power", "force_zero", "pressure_saturation"} & {r["effect"] for r in found.ranking}
    assert not any("sigma_n" in place["variables"] for place in found.where)
    assert not [row for row in found.bias if row["load"] == "sigma_n"]
    assert "over v_rel and sigma_n" not in found.report()


def test_levels_of_a_pressure_and_small_changes_of_other_loads_vary() -> None:
    assert prepare(held(0, 0.007, (0.16, 0.17))).varied == ["v_rel", "sigma_n"]
    data = held(0, 0.0)
    few = np.linspace(0.0, 1.0, len(data))
    assert prepare(data.assign(T=200.0 + 8.0 * few, psi=1.0 + 0.01 * few)).varied == ["v_rel", "T", "psi"]
    room = prepare(data.assign(T=200.0 + 2.0 * few, psi=1.0 + 0.01 * few))
    assert room.varied == ["v_rel", "psi"]
    assert "T varies only as it is held (200 to 202 degC): effects of T cannot be seen" in room.warnings


def test_a_dozen_means_of_noise_are_no_effect() -> None:
    """A law with six numbers leaves six of them: a flexible mean around it would leave none, and a noise of nothing."""
    named = 0
    for seed in range(6):
        rng = np.random.default_rng([seed, 12])
        loads = {
            "v_rel": rng.uniform(2.0, 100.0, 12),
            "T": rng.uniform(20.0, 200.0, 12),
            "sigma_n": rng.uniform(100.0, 900.0, 12),
            "sd": rng.uniform(5.0, 50.0, 12),
            "psi": rng.uniform(1.0, 5.0, 12),
        }
        names = [f"t{k:02d}" for k in range(12)]
        answer = diagnose(pd.DataFrame({"test_id": names, **loads, "mu": 0.1 + rng.normal(0.0, 0.01, 12)}))
        assert answer.ranking[0]["evidence"] < 1e3, answer.ranking[0]
        named += answer.verdict != "nothing_missing"
    assert named <= 1


@pytest.mark.parametrize("tests", [10, 11, 37])
def test_averages_with_a_distance_that_says_nothing(tests: int) -> None:
    """The distances of averages lie near one another: a curve along them has no column, and its products have none."""
    rng = np.random.default_rng(tests)
    v, sd = np.exp(rng.uniform(0.0, 4.0, tests)), rng.uniform(100.0, 900.0, tests)
    loads = {
        "v_rel": v,
        "T": rng.uniform(20.0, 120.0, tests),
        "sigma_n": np.exp(rng.uniform(4.0, 6.7, tests)),
    }
    points = pd.DataFrame({"test_id": [f"t{k}" for k in range(tests)], "t": sd / v, **loads, "sd": sd})
    found = diagnose(points.assign(psi=1.0, mu=0.1 + 0.01 * rng.normal(size=tests)))
    assert found.verdict in {"nothing_missing", "unknown_structure", "ambiguous", "explained"}


@pytest.mark.nightly
def test_a_table_of_a_thousand_columns_is_a_dump() -> None:
    rng = np.random.default_rng(0)
    points, tests, _ = campaign("stribeck", seed=3, strength=2.0, thin=54)
    noise = pd.DataFrame(rng.normal(size=(len(tests), 1000)), columns=[f"c{k:03d}" for k in range(1000)])
    found = diagnose(points, pd.concat([tests.reset_index(drop=True), noise], axis=1))
    assert found.effects == ["stribeck"], found.sentence
    assert any("columns: of those that no effect needs only the first 100" in w for w in found.warnings)


@pytest.mark.nightly
def test_points_that_stand_twice_are_taken_once() -> None:
    points, tests, _ = campaign("stribeck", seed=3, strength=2.0, thin=54)
    once, twice = diagnose(points, tests), diagnose(pd.concat([points, points]), tests)
    assert any("points stand twice in their test" in w for w in twice.warnings)
    assert once.parameters == twice.parameters and once.confidence == twice.confidence


@pytest.mark.parametrize("seed", [-1, "a"])
def test_what_is_no_seed_is_refused(seed: Any) -> None:
    data = pd.DataFrame({"test_id": list("abcdefghij"), "v_rel": range(1, 11), "mu": 0.1})
    for ask in (diagnose, partial(refine, add="stribeck")):
        with pytest.raises(InputError, match=f"seed is {seed!r}, allowed: a whole number from 0"):
            ask(data, seed=seed)
    assert any("mu is 0.1 at all 10 points" in w for w in diagnose(data).warnings)
