"""Memory of the contact is named only where something shows that a speed law and running-in together do not show."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.literature import cases, make
from friction_models.discovery import diagnose

CATALOGUE = ("rate_state", "running_in", "rising_speed", "stribeck", "thermal_softening")
BREAKDOWNS = (
    "thermal_breakdown",
    "hot_pressure_breakdown",
    "thermal_softening",
    "flash_temperature",
    "hersey",
)
#: Friction after a change of speed settles over this distance, mm.
SLIP = 1.5


def _tests(rng: np.random.Generator, steps_of_speed: bool) -> pd.DataFrame:
    """Return loads of 30 tests of 20 mm; the speed of each is constant, or changes three times."""
    frames = []
    sd = np.arange(0.1, 20.0, 0.1)
    for k in range(30):
        levels = np.exp(rng.uniform(np.log(2.0), np.log(300.0), 4))
        v = levels[np.minimum((sd / 5.0).astype(int), 3)] if steps_of_speed else np.full(len(sd), levels[0])
        t = np.cumsum(0.1 / v)
        T = 30.0 + rng.uniform(0.0, 80.0) + 2.0 * np.sqrt(sd)
        sigma_n = rng.uniform(300.0, 1200.0) * (1.0 - 0.005 * sd)
        frames.append(
            pd.DataFrame(
                {"test_id": f"t{k}", "t": t, "v_rel": v, "T": T, "sigma_n": sigma_n, "sd": sd, "psi": 1.0}
            )
        )
    return pd.concat(frames, ignore_index=True)


def _noise(rng: np.random.Generator, data: pd.DataFrame) -> np.ndarray:
    level = dict(zip(data["test_id"].unique(), rng.normal(0.0, 0.0015, 30), strict=True))
    return data["test_id"].map(level).to_numpy() + rng.normal(0.0, 0.001, len(data))


@pytest.mark.parametrize("along", [pytest.param("decaying", marks=pytest.mark.nightly), "step"])
def test_a_speed_law_and_a_change_along_the_distance_are_not_taken_for_memory(along: str) -> None:
    rng = np.random.default_rng([2, 31])
    data = _tests(rng, steps_of_speed=False)
    # hyperbolas and a step: no formula of the catalogue
    speed = 0.1 * data["v_rel"] / (data["v_rel"] + 20.0)
    distance = (
        0.01 / (1.0 + data["sd"] / 1.2)
        if along == "decaying"
        else 0.01 / (1.0 + np.exp(-2.0 * (data["sd"] - 9.0)))
    )
    answer = diagnose(data.assign(mu=0.08 + speed + distance + _noise(rng, data)), catalogue=CATALOGUE)
    assert answer.effects[0] != "rate_state", answer.sentence
    assert "rising_speed" in {*answer.effects, *answer.confusion_set}, answer.sentence


def test_memory_that_shows_after_changes_of_speed_is_named() -> None:
    # slip law of Ruina, marched here: friction lags behind ln v by a distance, whatever the time
    rng = np.random.default_rng(31)
    data = _tests(rng, steps_of_speed=True)
    log_v = np.log(data["v_rel"].to_numpy() / 20.0)
    lagging = np.empty(len(data))
    for start in np.flatnonzero(data["test_id"].ne(data["test_id"].shift())):
        lagging[start] = log_v[start]
        for k in range(start + 1, start + 199):
            lagging[k] = log_v[k] + (lagging[k - 1] - log_v[k]) * np.exp(-0.1 / SLIP)
    mu = 0.1 + 0.008 * log_v - 0.006 * lagging + _noise(rng, data)
    answer = diagnose(data.assign(mu=mu), catalogue=CATALOGUE)
    assert answer.effects == ["rate_state"], answer.sentence


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("law", "recipe", "first"),
    [
        ("breakdown_weibull", "random_walk", "thermal_breakdown"),
        ("breakdown_desorption", "heteroscedastic", "thermal_breakdown"),
        ("breakdown_index", "heteroscedastic", "hot_pressure_breakdown"),
    ],
)
def test_a_pressure_on_which_nothing_depends_is_not_named(law: str, recipe: str, first: str) -> None:
    # laws of the literature in campaigns of another author: the first two rise with temperature alone, not as the catalogue does
    case = next(c for c in cases(60) if c.laws == (law,) and c.recipe == recipe)
    made = make(case)
    assert diagnose(made.data, made.tests, catalogue=BREAKDOWNS).effects[:1] == [first]
