"""Loads that contradict each other or the test table are told; campaigns as they should be are not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from friction_models.discovery import diagnose
from friction_models.estimation.campaign.binning import prepare


def campaign(heat: float = 60.0) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return twelve tests of varied speed, and the table of what was set; the contact warms up by up to `heat` [K]."""
    rng = np.random.default_rng(3)
    points, tests = [], []
    for k in range(12):
        v, p, T = 10.0 * 2.0 ** (k % 5), 300.0 * (1 + k % 3), (20.0, 120.0, 220.0)[k % 3 if k < 6 else k // 4]
        t = np.linspace(0.0, 40.0 / v, 25)
        warm = T + heat * (k + 1) / 12 * np.sqrt(t / t[-1])
        held = v * (1 + 0.1 * np.sin(7.0 * t))
        sd = np.r_[0.0, np.cumsum(0.5 * (held[1:] + held[:-1]) * np.diff(t))]
        loads = {
            "t": t,
            "v_rel": held,
            "T": warm,
            "sigma_n": p * rng.uniform(0.95, 1.05),
            "sd": sd,
            "psi": 1.3,
        }
        points.append(
            pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": 0.1 + 0.002 * rng.standard_normal(25)})
        )
        tests.append({"test_id": f"t{k:02d}", "T_tool": T, "sigma_set": p, "v_set": v})
    return pd.concat(points, ignore_index=True), pd.DataFrame(tests)


def told(points: pd.DataFrame, tests: pd.DataFrame) -> list[str]:
    """Return the warnings that a sound campaign does not have."""
    usual = set(prepare(*campaign()).warnings)
    return [w for w in prepare(points, tests).warnings if w not in usual]


@pytest.mark.parametrize("heat", [60.0, 250.0, 330.0])
def test_a_sound_campaign_has_no_conflict_however_hot_it_gets(heat: float) -> None:
    assert told(*campaign(heat)) == []


def metres_a_second(points: pd.DataFrame, tests: pd.DataFrame) -> None:
    points.loc[points["test_id"] == "t03", "v_rel"] /= 1000.0


def milliseconds(points: pd.DataFrame, tests: pd.DataFrame) -> None:
    points["t"] *= 1000.0


def kelvin(points: pd.DataFrame, tests: pd.DataFrame) -> None:
    points.loc[points["test_id"].isin(["t01", "t02"]), "T"] += 273.15


def tool_in_kelvin(points: pd.DataFrame, tests: pd.DataFrame) -> None:
    tests["T_tool"] += 273.15


def exchanged(points: pd.DataFrame, tests: pd.DataFrame) -> None:
    points[["T", "sigma_n"]] = points[["sigma_n", "T"]].to_numpy()


def shrunk(points: pd.DataFrame, tests: pd.DataFrame) -> None:
    points.loc[points["test_id"] == "t05", "psi"] = 0.5


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (metres_a_second, "sd of 1 test (t03) grows 1000 times as far as v_rel gives over t"),
        (milliseconds, "sd of all tests grows 0.001 times as far as v_rel gives over t"),
        (kelvin, "T of 2 tests (t01, t02) starts 273 above T_tool: is it in K?"),
        (tool_in_kelvin, "T_tool of all tests starts 273 above T: is it in K?"),
        (exchanged, "T is what sigma_set says, and sigma_n is not: are they exchanged?"),
        (shrunk, "psi of 1 test (t05) falls to 0.5: below 1 the surface shrinks"),
    ],
)
def test_what_cannot_be_right_is_told(fault: Callable[[pd.DataFrame, pd.DataFrame], None], said: str) -> None:
    points, tests = campaign()
    fault(points, tests)
    assert any(w.startswith(said) for w in told(points, tests)), told(points, tests)


def counter(points: pd.DataFrame, tests: pd.DataFrame) -> None:
    points["t"] = points.groupby("test_id").cumcount().astype(float)


def test_a_counter_is_no_time() -> None:
    points, tests = campaign()
    counter(points, tests)
    assert any("one of them is not what its name says" in w for w in told(points, tests)), told(points, tests)


def test_a_rest_under_load_is_no_wrong_unit() -> None:
    """Without rows of no speed the step over it has the speed of both sides, and an hour."""
    points, tests = campaign()
    late = points.groupby("test_id").cumcount() >= 12
    assert told(points.assign(t=points["t"] + 3600.0 * late), tests) == []


@pytest.mark.parametrize("wrong", [293.15 + 120.0, 2000.0])
def test_one_wrong_temperature_of_the_tool_does_not_end_a_diagnosis(wrong: float) -> None:
    points, tests = campaign()
    tests.loc[tests["test_id"] == "t07", "T_tool"] = wrong
    assert diagnose(points, tests).verdict


def test_without_time_nothing_is_said_of_the_distance() -> None:
    points, tests = campaign()
    metres_a_second(points, tests)
    assert not any("over t" in w for w in prepare(points.drop(columns="t"), tests).warnings)


def test_a_speed_that_was_not_recorded_and_exchanged_columns_are_told() -> None:
    points, tests = campaign()
    assert any("was the speed recorded?" in w for w in told(points.assign(v_rel=0.0), tests))
    swapped = points.rename(columns={"sigma_n": "psi", "psi": "sigma_n"})
    assert any("are columns exchanged?" in w for w in told(swapped, tests.drop(columns="sigma_set")))


def test_a_table_of_tests_with_a_column_twice_is_refused_and_an_empty_one_counts_as_none() -> None:
    points, tests = campaign()
    with pytest.raises(InputError, match="'T_tool' stands twice"):
        prepare(points, pd.concat([tests, tests[["T_tool"]]], axis=1))
    assert not prepare(points, tests[:0]).system
