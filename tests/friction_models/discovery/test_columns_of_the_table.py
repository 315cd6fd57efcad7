"""Levels of a column of the test table, in tests over one track and in few tests; made-up tests."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.repeats import repeats_of


def strokes(seed: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return 60 strokes to and fro over a track that goes on: mu differs by the direction, and swings over the track."""
    rng = np.random.default_rng(seed)
    names = [f"s{k:02d}" for k in range(60)]
    to = np.arange(60) % 2 == 0
    at = np.repeat(np.arange(60), 20)
    sd = 6.0 * at + np.tile(np.linspace(0.3, 6.0, 20), 60)
    mu = 0.3 + 0.04 * np.where(to, 1.0, -1.0)[at] + 0.045 * np.cos(sd / 40.0)
    mu += rng.normal(0.0, 0.004, 60)[at] + rng.normal(0.0, 0.004, len(sd))
    data = pd.DataFrame({"test_id": np.array(names)[at], "v_rel": 4.0, "sigma_n": 1.0, "sd": sd, "mu": mu})
    return data, pd.DataFrame({"test_id": names, "direction": np.where(to, "to", "fro")})


@pytest.mark.parametrize("seed", [1, 2])
def test_strokes_over_one_track_are_no_repeats_of_one_another(seed: int) -> None:
    """Every curve ran along the distance of each stroke, and every stroke repeated all others: "explained", with a floor of 0.03."""
    found = diagnose(*strokes(seed), model="linear")
    assert (found.verdict, found.effects) == ("partly_explained", ["factor:direction"]), found.sentence
    assert found.where[0]["variables"] == ["sd"] and found.error_budget["floor"] < 0.01
    assert found.error_budget["missing"] == pytest.approx(0.045 / np.sqrt(2.0), rel=0.15)


def oils(seed: int, tests: int, apart: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return one mean a test: four oils, each `apart` from the next, at two speeds and two pressures, scatter 0.004; some tests are lost."""
    rng = np.random.default_rng(seed)
    oil = np.repeat(np.arange(4), 4)
    kept = np.sort(rng.permutation(16)[:tests])
    data = pd.DataFrame(
        {
            "test_id": [f"t{k:02d}" for k in range(16)],
            "v_rel": np.tile([20.0, 20.0, 100.0, 100.0], 4),
            "sigma_n": np.tile([10.0, 20.0, 10.0, 20.0], 4),
            "mu": 0.15 - apart * oil + rng.normal(0.0, 0.004, 16),
        }
    )
    table = pd.DataFrame({"test_id": data["test_id"], "oil": [f"oil {'ABCD'[k]}" for k in oil]})
    return data.iloc[kept], table.iloc[kept]


def test_oils_at_one_setting_are_no_repeats_of_one_another() -> None:
    for seed in range(6):
        campaign = prepare(*oils(seed, tests=14, apart=0.01))
        level = campaign.average(campaign.mu)
        found = repeats_of(campaign, level - level.mean())
        assert found is not None and found.scatter < 0.008, found  # the oils scatter by 0.011


def test_oils_are_named_though_two_tests_are_lost() -> None:
    """Two of these six were named."""
    named = [diagnose(*oils(seed, tests=14, apart=0.006)).effects == ["factor:oil"] for seed in range(6)]
    assert sum(named) >= 5, named


def of_two_columns(seed: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return averages of 45 tests with three coatings beside none, of which one differs most, and an operator who reads 6 % more."""
    rng, n = np.random.default_rng([seed, 45]), 45
    loads = {
        "v_rel": rng.choice([2.0, 10.0, 50.0, 200.0], n),
        "T": rng.choice([25.0, 60.0, 120.0, 180.0], n),
        "sigma_n": rng.choice([5.0, 15.0, 40.0, 80.0], n),
    }
    coating, operator = rng.permutation(np.repeat([0, 1, 2, 3], [20, 12, 9, 4])), rng.integers(0, 3, n)
    mu = 0.11 - 2e-4 * (loads["sigma_n"] - 30.0) + np.array([0.0, -0.012, -0.025, 0.006])[coating]
    names = [f"t{k:02d}" for k in range(n)]
    points = {"test_id": names, **loads, "mu": mu + 0.006 * (operator == 1) + rng.normal(0.0, 0.003, n)}
    columns = {
        "coating": np.array(["bare", "TiN", "DLC", "CrN"])[coating],
        "operator": np.array(["x", "y", "z"])[operator],
    }
    return pd.DataFrame(points), pd.DataFrame({"test_id": names, **columns})


@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.nightly) for k in (2, 3, 6))])
def test_a_second_column_is_sought_beside_all_levels_of_the_first(seed: int) -> None:
    """Beside the one coating that differs most the others were scatter, and the operator was not named."""
    found = diagnose(*of_two_columns(seed))
    assert found.effects == ["factor:coating", "factor:operator"], found.sentence


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.nightly) for k in (1, 2, 5))])
def test_batches_are_named_before_a_drift_that_says_the_same(seed: int) -> None:
    """A drift of the sensor was named, and its share of mu was to be taken off the measurements."""
    rng, n = np.random.default_rng([seed, 36]), 40
    batch = np.minimum(4, (5.0 * (np.arange(n) / n * 0.8 + 0.2 * rng.random(n))).astype(int))
    v, T = rng.choice([2.0, 15.0, 60.0, 200.0], n), rng.choice([20.0, 80.0, 140.0], n)
    mu = (
        0.1
        + 1e-4 * (T - 80.0)
        + np.array([-0.007, -0.002, 0.0, 0.003, 0.009])[batch]
        + rng.normal(0.0, 0.003, n)
    )
    names = [f"t{k:02d}" for k in range(n)]
    table = pd.DataFrame({"test_id": names, "batch": np.array([*"ABCDE"])[batch], "order": np.arange(n) + 1})
    found = diagnose(pd.DataFrame({"test_id": names, "v_rel": v, "T": T, "mu": mu}), table)
    assert found.effects == ["batch"] and "sensor_drift" in found.confusion_set, found.sentence
