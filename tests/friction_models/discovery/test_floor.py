"""What identifies the noise floor: repeats where there are some; and answers where there is hardly any noise."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from sklearn.ensemble import RandomForestRegressor

from friction_models.discovery import diagnose
from friction_models.discovery.judge.doubts import EVEN, LIKELY, MOSTLY
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.repeats import Repeats, metadata_of_tests, repeats_of, same_settings
from friction_models.loads import LOAD_NAMES

POINTS = 24


def repeated(seed: int, settings: int = 8, each: int = 3) -> pd.DataFrame:
    """Return synthetic loads of tests that repeat settings, as closely as a rig meets them."""
    rng = np.random.default_rng(seed)
    tests = []
    for k in range(settings):
        speed, warm, pressure = rng.choice([2, 20, 200]), rng.uniform(20, 240), rng.uniform(300, 2000)
        for j in range(each):
            sd = np.linspace(0.1, 20.0, POINTS)
            loads = {
                "v_rel": speed * np.ones(POINTS), "T": warm + rng.normal(0.0, 0.3) + 0.4 * sd,
                "sigma_n": pressure * rng.normal(1.0, 0.003), "sd": sd, "psi": 1.1 + 0.02 * k + 0.001 * sd,
            }  # fmt: skip
            tests.append(pd.DataFrame({"test_id": f"s{k:02d}{'abcdef'[j]}", **loads}))
    return pd.concat(tests, ignore_index=True)


def measured(
    loads: pd.DataFrame, law: object, seed: int, test: float = 0.003, sensor: float = 0.002
) -> pd.DataFrame:
    """Return the loads with mu of a law, offsets of tests, and noise."""
    rng = np.random.default_rng(seed)
    offset = dict(zip(names := loads["test_id"].unique(), rng.normal(0.0, test, len(names))))
    mu = law + loads["test_id"].map(offset) + rng.normal(0.0, sensor, len(loads))
    return loads.assign(mu=mu)


def scatter_of(data: pd.DataFrame) -> Repeats:
    campaign = prepare(data)
    found = repeats_of(campaign, campaign.average(campaign.mu))
    assert found is not None
    return found


def test_repeats_show_the_scatter_that_was_made() -> None:
    true = np.hypot(0.003, 0.002)  # one point a bin
    inside = 0
    for seed in range(40):
        loads = repeated(seed)
        found = scatter_of(measured(loads, 0.1 + 0.05 * np.sin(loads["sigma_n"] / 300.0), seed))
        assert (found.settings, found.tests) == (8, 24)
        inside += found.interval[0] <= true <= found.interval[1]
    assert inside >= 35


def test_lack_of_fit_is_as_rare_as_its_p_value_says_and_is_seen_where_it_is() -> None:
    without = [scatter_of(measured(repeated(s), 0.1, s)).p_value for s in range(60)]
    assert np.mean(np.array(without) < 0.1) < 0.22
    for seed in range(6):
        loads = repeated(seed)
        own = dict(
            zip(
                kinds := loads["psi"].round(2).unique(),
                np.random.default_rng(seed).normal(0.0, 0.01, len(kinds)),
            )
        )
        assert scatter_of(measured(loads, 0.1 + loads["psi"].round(2).map(own), seed)).p_value < 0.02


def test_tests_of_other_batches_are_no_repeats() -> None:
    data = measured(repeated(1), 0.1, 1)
    names = data["test_id"].unique()
    batches = pd.DataFrame({"test_id": names, "batch": [f"lot {n[-1]}" for n in names]})
    campaign = prepare(data, batches)
    assert len(same_settings(campaign)) == 8
    assert len(same_settings(campaign, metadata_of_tests(campaign))) == 0


def test_repeats_of_other_levels_scatter_about_what_the_levels_make_of_them() -> None:
    """Four oils at each of eight settings, once each: none repeats another, and what the oils do is no scatter."""
    data = measured(repeated(2, each=4), 0.1, 2)
    names = data["test_id"].unique()
    oils = pd.DataFrame({"test_id": names, "oil": [f"oil {n[-1]}" for n in names]})
    own = data["test_id"].str[-1].map({"a": 0.03, "b": -0.02, "c": 0.0, "d": -0.01})
    campaign = prepare(data.assign(mu=data["mu"] + own), oils)
    found = repeats_of(campaign, campaign.average(campaign.mu))
    assert found is not None and found.tests == 32
    assert found.interval[0] < np.hypot(0.003, 0.002) < found.interval[1]


def test_a_set_value_that_repeats_share_is_no_level_to_take_out() -> None:
    """Each setting has a tool temperature of its own, and its repeats are of several oils: what the temperature does is lack of fit."""
    data = measured(repeated(2, each=4), 0.1, 2)
    names = data["test_id"].unique()
    tests = pd.DataFrame({"test_id": names, "oil": [f"oil {n[-1]}" for n in names]})
    tests["T_tool"] = [20.0 + 40.0 * (int(n[1:3]) // 2) for n in names]
    bent = data["test_id"].str[1:3].astype(int).map(lambda k: 0.02 * (k // 2 - 1.5) ** 2)
    campaign = prepare(data.assign(mu=data["mu"] + bent), tests)
    found = repeats_of(campaign, campaign.average(campaign.mu))
    assert found is not None and found.tests == 32 and found.lacks_fit, found


def test_a_number_that_counts_the_repeats_parts_no_repeats() -> None:
    """Eight rings, each with a slope of its own over four pressures, three strokes each: strokes are repeats, rings are not."""
    rng = np.random.default_rng(4)
    rings = rng.normal(0.0, 0.03, 8)
    frame = pd.DataFrame(
        [(r, p, k) for r in range(8) for p in range(4) for k in range(3)], columns=["ring", "p", "stroke"]
    )
    frame["test_id"] = [f"t{k:02d}" for k in range(96)]
    mu = 0.3 + rings[frame["ring"]] * (frame["p"] - 1.5) + 0.002 * rng.standard_normal(96)
    data = pd.DataFrame(
        {"test_id": frame["test_id"], "sigma_n": 100.0 * (1 + frame["p"]), "v_rel": 10.0, "mu": mu}
    )
    tests = pd.DataFrame({"test_id": frame["test_id"], "batch": "ring " + frame["ring"].astype(str)})
    for numbered in (
        tests,
        tests.assign(stroke=frame["stroke"]),
        tests.assign(humidity=40 + 1.3 * frame["stroke"]),
    ):
        campaign = prepare(data, numbered)
        found = repeats_of(campaign, campaign.average(campaign.mu))
        assert found is not None and found.settings == 32 and 0.0015 < found.scatter < 0.0025


def test_averages_at_other_distances_are_no_repeats() -> None:
    """One average a stroke of one long test, all at the same loads: friction bends along the distance."""
    rng = np.random.default_rng(0)
    sd = 8.5 * np.arange(1, 99)
    mu = 0.7 - 5e-5 * sd + 0.008 * np.sin(sd / 130.0) + 0.003 * rng.standard_normal(98)
    names = [f"s{k:02d}" for k in range(98)]
    strokes = pd.DataFrame({"test_id": names, "t": 0.0, "sigma_n": 2.0, "sd": sd, "mu": mu})
    assert not [g for g in same_settings(prepare(strokes)) if np.ptp(sd[g]) > 30.0]
    found = diagnose(strokes)
    assert found.verdict == "unknown_structure" and "along sd" in found.sentence, found.sentence


def test_the_answer_says_what_identifies_its_floor() -> None:
    loads = repeated(3, settings=9)
    found = diagnose(measured(loads, 0.12 - 1e-4 * loads["T"], 3))
    assert found.verdict == "nothing_missing" and found.noise_floor["source"] == "repeats"
    low, high = found.noise_floor["interval"]
    assert low < np.hypot(0.003, 0.002) < high
    assert "27 tests at 9 repeated settings" in found.report()
    alone = loads[loads["test_id"].str.endswith("a")]
    assert diagnose(measured(alone, 0.1, 3)).noise_floor["source"] in {"model", "reference"}


@pytest.mark.nightly
def test_what_repeats_rule_out_is_not_called_noise() -> None:
    # each setting has a level of its own that no load tells
    loads = repeated(5, settings=12)
    settings = loads["test_id"].str[:3]
    own = dict(zip(settings.unique(), np.random.default_rng(5).normal(0.0, 0.012, 12)))
    found = diagnose(measured(loads, 0.1 + settings.map(own), 5, test=0.001), model="linear")
    assert found.verdict != "nothing_missing" or found.confidence <= LIKELY
    assert any("repeated settings: their mu agrees" in w for w in found.warnings)
    assert found.noise_floor["total"] < 0.005


def test_data_without_noise_that_the_model_describes_lack_nothing() -> None:
    loads = repeated(7, settings=14, each=1)
    found = diagnose(loads.assign(mu=0.12 - 1e-4 * loads["T"] + 1e-5 * loads["sigma_n"]))
    assert found.verdict == "nothing_missing" and found.confidence > 0.9
    assert "closer than friction can be measured" in found.sentence


def test_a_model_that_learnt_these_points_is_no_proof() -> None:
    loads = repeated(8, settings=14, each=1)
    data = measured(loads, 0.12 - 1e-4 * loads["T"], 8)
    forest = RandomForestRegressor(40, random_state=0).fit(data[list(LOAD_NAMES)].to_numpy(), data["mu"])
    found = diagnose(data, model=forest)
    assert found.confidence <= EVEN and any("fitted to them" in w for w in found.warnings)


@pytest.mark.nightly
def test_a_model_that_learnt_other_points_is_not_said_to_have_learnt_these() -> None:
    loads = repeated(8, settings=14, each=1)
    data, other = (measured(loads, 0.12 - 1e-4 * loads["T"], seed) for seed in (8, 9))
    honest = RandomForestRegressor(40, random_state=0, min_samples_leaf=40)
    honest.fit(other[list(LOAD_NAMES)].to_numpy(), other["mu"])
    assert not any("fitted to them" in w for w in diagnose(data, model=honest).warnings)


def test_scatter_may_be_an_effect_of_a_load_that_was_not_recorded() -> None:
    loads = repeated(9, settings=16, each=1)
    found = diagnose(measured(loads, 0.1, 9).drop(columns="v_rel"))
    assert found.verdict == "nothing_missing" and found.confidence <= MOSTLY
    assert any("scatter between tests may be an effect" in w for w in found.warnings)


@pytest.mark.parametrize("offset", [-0.02, 0.02])
def test_the_budget_of_a_model_with_a_wrong_level_adds_up(offset: float) -> None:
    class Constant:
        def predict(self, loads: np.ndarray) -> np.ndarray:
            return np.full(len(loads), 0.1 + offset)

    found = diagnose(measured(repeated(10, settings=14, each=1), 0.1, 10), model=Constant())
    table, budget = found.averages, found.error_budget
    whole = np.average(table["before"] ** 2, weights=table["points"])
    assert sum(v**2 for v in budget.values()) == pytest.approx(whole, rel=1e-6)
    assert budget["missing"] == pytest.approx(0.02, abs=0.002) and budget["floor"] < 0.005
    side = "above" if offset > 0 else "below"
    assert any(f"{side} the measurements everywhere" in w for w in found.warnings)


@pytest.mark.nightly
def test_a_law_that_differs_from_batch_to_batch_is_no_noise() -> None:
    loads = repeated(11, settings=48, each=1)
    names = loads["test_id"].unique()
    lots = np.where(np.arange(len(names)) % 2, "lot A", "lot B")
    tests = pd.DataFrame({"test_id": names, "lot": lots, "heat": np.repeat([f"h{k}" for k in range(8)], 6)})
    sign = loads["test_id"].map(dict(zip(names, np.where(lots == "lot A", 1.0, -1.0), strict=True)))
    found = diagnose(measured(loads, 0.1 + 0.008 * sign * (loads["T"] - 130.0) / 60.0, 11), tests)
    assert found.verdict == "unknown_structure" and set(found.where[0]["variables"]) == {"T", "lot"}
    assert found.noise_floor["total"] < 0.005 and "T" in found.report() and "lot" in found.sentence
    assert diagnose(measured(loads, 0.1, 11), tests).verdict == "nothing_missing"


def test_an_effect_beside_a_wrong_level_does_not_explain_the_level() -> None:
    loads = repeated(12, settings=20, each=1)
    law = 0.1 - 0.03 / (1.0 + np.exp(-(loads["T"] - 140.0) / 20.0))

    class TooLow:
        def predict(self, loads: np.ndarray) -> np.ndarray:
            return np.full(len(loads), 0.045)

    found = diagnose(measured(loads, law, 12), model=TooLow())
    assert found.verdict == "partly_explained" and found.effects == ["thermal_softening"]
    assert found.where[-1]["shape"].startswith("constant offset +0.0")
    left = np.average(found.averages["after"], weights=found.averages["points"])
    assert left == pytest.approx(found.error_budget["missing"], abs=0.003) and left > 0.015


@pytest.mark.nightly
def test_repeats_do_not_speak_against_a_law_that_fits() -> None:
    """Two close tests at each of 12 temperatures: shapes on the grid of the scan leave more than the repeats, fitted ones do not."""
    sd = np.linspace(1.0, 30.0, 20)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        tests = []
        for k, T in enumerate(np.repeat(np.linspace(40.0, 260.0, 12), 2)):
            mu = 0.11 + 0.03 * np.tanh((T - 163.0) / 25.0) + rng.normal(0.0, 3e-4) + rng.normal(0.0, 5e-4, 20)
            loads = {"t": sd / 50.0, "v_rel": 50.0, "T": T, "sigma_n": 500.0, "sd": sd, "psi": 1.0}
            tests.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu}))
        found = diagnose(pd.concat(tests, ignore_index=True), model="constant")
        assert (found.verdict, found.effects) == ("explained", ["thermal_breakdown"])
        assert found.noise_floor["repeats"]["p_value"] > 0.05
        assert not any("in a way that is not named" in w for w in found.warnings)
