"""Curves that no effect has: a saw along the distance, and a hump that two effects draw only by cancelling each other."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest

from benchmarks.discovery.generator import campaign as made_campaign
from benchmarks.discovery_campaigns import campaign
from friction_models.discovery import diagnose, refine


def at_random_loads(seed: int, points: int = 120) -> pd.DataFrame:
    """Return 30 tests whose contact warms up a little; the machine speeds up, so many points lie at short distances."""
    rng = np.random.default_rng([seed, 17])
    frames = []
    for k in range(30):
        v, T, p, length = (
            np.exp(rng.uniform(1.0, 6.0)),
            rng.uniform(30.0, 250.0),
            rng.uniform(150.0, 1800.0),
            rng.uniform(40.0, 60.0),
        )
        sd = length * np.linspace(0.02, 1.0, points) ** 2
        frames.append(
            pd.DataFrame(
                {
                    "test_id": f"t{k:02d}", "t": sd / v, "v_rel": v, "T": T + 0.01 * p * np.sqrt(sd / 60.0), "sigma_n": p, "sd": sd,
                    "psi": rng.uniform(1.1, 3.0), "level": 0.09 + 0.002 * rng.normal(),
                }
            )
        )  # fmt: skip
    data = pd.concat(frames, ignore_index=True)
    return data.assign(mu=data.pop("level") + 0.0035 * rng.standard_normal(len(data)))


@pytest.mark.nightly
def test_a_saw_along_the_distance_is_neither_running_in_nor_noise() -> None:
    data = at_random_loads(1)
    data["mu"] += 0.0106 * (
        2.0 * ((data["sd"] / 13.0) % 1.0) - 1.0
    )  # stick and slip of the machine, the same in each test
    found = diagnose(data)
    assert found.verdict == "unknown_structure" and "along sd" in found.sentence, found.sentence
    assert found.noise_floor["total"] < 0.0053  # 0.0061 where the saw passes for drift


@pytest.mark.nightly
def test_two_names_that_only_cancel_each_other_are_no_answer() -> None:
    """A hump over pressure: a breakdown that rises and a saturation that falls, each of any size, draw it."""
    data = at_random_loads(7, points=30)
    data["mu"] += 0.022 * np.exp(-(((data["sigma_n"] - 900.0) / 260.0) ** 2))
    found = diagnose(data, model="constant")
    assert found.verdict == "unknown_structure" and any("bump(sigma_n)" in o.name for o in found.formulas)


@pytest.mark.nightly
@pytest.mark.parametrize("steep", [0.0, -2e-5])
def test_a_valley_along_pressure_is_no_saturation_beside_a_steep_line(steep: float) -> None:
    data = at_random_loads(11, points=40)
    p = data["sigma_n"]
    data["mu"] += steep * (p - 900.0) + 0.035 * ((p - 850.0) / 850.0) ** 2
    found = diagnose(data)
    assert found.verdict == "unknown_structure", found.sentence
    assert found.where[0]["variables"] == ["sigma_n"]
    if steep == 0.0:
        told = next(w for w in found.warnings if "comes closest" in w)
        name = found.ranking[0]["effect"]
        assert told.startswith(f"{name} comes closest: refine --add {name} lowers the rms error")
        before, after = map(float, re.findall(r"from (\S+) to (\S+) ", told)[0])
        done = refine(data, model="linear", add=name).error_history_[-1]
        assert (before, after) == pytest.approx((done["before"]["rmse"], done["after"]["rmse"]), rel=0.05)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.nightly)])
def test_a_valley_at_three_pressures_is_not_sure_of_a_law_of_pressure(seed: int) -> None:
    """Which of several laws that fall would be open: that none of them rises is not. It was 0.95 sure of them."""
    data = at_random_loads(20 + seed, points=20)
    level = data.groupby("test_id").ngroup().mod(3).map({0: 400.0, 1: 1000.0, 2: 2600.0})
    wide = np.log(level / 1050.0)
    data = data.assign(
        sigma_n=level * (1.0 + 0.01 * np.sin(data["sd"])), mu=data["mu"] + 0.03 * wide**2 / (0.3 + wide**2)
    )
    found = diagnose(data)
    assert not found.effects or found.confidence <= 0.5, found.sentence


@pytest.mark.nightly
def test_a_flat_start_and_a_rise_with_speed_is_no_stribeck_effect() -> None:
    """Beside a steep line a fall with speed draws a curve that falls nowhere."""
    data = at_random_loads(3, points=40)
    data["mu"] += 0.1 * (np.maximum(data["v_rel"] - 150.0, 0.0) / 250.0) ** 1.3
    found = diagnose(data)
    assert found.verdict == "unknown_structure" and "along v_rel" in found.sentence, found.sentence


@pytest.mark.parametrize("width", [35.0, pytest.param(25.0, marks=pytest.mark.nightly)])
def test_a_hump_in_temperature_is_no_sure_breakdown_beside_a_falling_line(width: float) -> None:
    """A failure beside a falling line does nearly as well: a name is 0.5 sure at most, and says where mu turns."""
    data = at_random_loads(2, points=30)
    data["mu"] += 0.03 * np.exp(-(((data["T"] - 130.0) / width) ** 2))
    found = diagnose(data)
    assert not found.effects or found.confidence <= 0.5, found.sentence
    assert "along T" in found.sentence or any("together mu is highest" in w for w in found.warnings)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [17, 11])
def test_a_sharp_rise_beside_a_falling_line_keeps_its_name(seed: int) -> None:
    """Friction falls with temperature, then the film fails: mu turns, but no plain bend does what the failure does (unknown, 0.94)."""
    data, tests, _ = campaign("thermal_breakdown", seed=seed, strength=1.5, extra=0, thin=8)
    found = diagnose(data, tests)
    assert (found.verdict, found.effects) == ("explained", ["thermal_breakdown"]), found.sentence
    assert any("and the model beside it falls: together mu is" in warning for warning in found.warnings)


@pytest.mark.nightly
def test_a_fall_beside_a_rising_line_is_not_nothing() -> None:
    """A plain bend does as well, and nothing else predicts anything: it was "nothing missing", 0.85, at p = 0.004."""
    made = made_campaign(51100, ("stribeck",), "plain", 0.6, "second")
    trained = made.points["test_id"].isin(made.tests.loc[made.tests["role"] == "train", "test_id"])
    found = diagnose(made.points[trained], made.tests, seed=51100)
    assert found.effects == ["stribeck"] and found.confidence <= 0.5, found.sentence
