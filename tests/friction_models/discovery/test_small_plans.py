"""Plans of a few averages, as orthogonal arrays and factorials give them: their noise hides what unseen tests still show."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.judge.doubts import EVEN, MOSTLY
from friction_models.loads import FloatArray

#: The first three columns of the orthogonal array of nine tests, and a factorial at two levels, run twice; levels from 0 to 1.
NINE = np.array([(a, b, (a + b) % 3) for a in range(3) for b in range(3)]) / 2.0
TWO_LEVELS = np.array([*product((0.0, 1.0), repeat=3)] * 2)

Law = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


def table(plan: FloatArray, law: Law, seed: int) -> pd.DataFrame:
    """Return one average a test, with 3 % of scatter; the law takes pressure, speed and temperature."""
    rng = np.random.default_rng(seed)
    u = rng.permutation(plan)
    p, v, T = 20.0 + 80.0 * u[:, 0], 200.0 + 1300.0 * u[:, 1], 25.0 + 125.0 * u[:, 2]
    mu = law(p, v, T) * np.exp(rng.normal(0.0, 0.03, len(u)))
    names = [f"r{k}" for k in range(len(u))]
    return pd.DataFrame({"test_id": names, "sigma_n": p, "v_rel": v, "T": T, "mu": mu})


LAWS: dict[str, Law] = {
    "thermal_softening": lambda p, v, T: 0.07 + 0.06 / (1.0 + ((T - 25.0) / 40.0) ** 1.3),
    "thermal_breakdown": lambda p, v, T: 0.09 + 0.03 * (1.0 + np.tanh((T - 115.0) / 12.0)),
    "pressure_power": lambda p, v, T: 0.05 + 2.4 / (p + 6.0),
}


@pytest.mark.parametrize(
    ("seeds", "least"), [(range(2), 2), pytest.param(range(8), 7, marks=pytest.mark.nightly)]
)
@pytest.mark.parametrize("name", LAWS)
def test_nine_tests_of_three_loads_show_a_law_that_their_noise_hides(
    name: str, seeds: range, least: int
) -> None:
    """All were "no effect of the catalogue", 0.8 to 0.9 sure."""
    answers = [diagnose(table(NINE, LAWS[name], seed)) for seed in seeds]
    assert all(a.confidence <= MOSTLY for a in answers)
    assert sum(a.verdict in {"explained", "ambiguous"} and name in a.confusion_set for a in answers) >= least


@pytest.mark.nightly
def test_nine_tests_of_a_straight_law_hardly_ever_lack_anything() -> None:
    laws = (
        diagnose(table(NINE, lambda p, v, T: 0.11 - 2e-4 * p - 1e-5 * v + 1e-4 * T, k)) for k in range(40)
    )
    named = [a for a in laws if a.effects]
    assert len(named) <= 8 and all(a.confidence <= MOSTLY for a in named)


def test_two_levels_show_no_form_but_a_product() -> None:
    """Friction that rises where it is hot and pressed, by the plain product; it was a breakdown, 0.95 sure."""
    found = diagnose(table(TWO_LEVELS, lambda p, v, T: 0.09 + 5e-6 * (p - 20.0) * (T - 25.0), 0))
    assert found.effects == ["hot_pressure_breakdown"] and found.confidence <= EVEN, found.sentence
    assert any("the plain product of" in w for w in found.warnings), found.warnings


def test_numbers_that_are_names_are_told_to_be_written_as_text() -> None:
    """Four coatings, 1 to 4, whose friction does not rise with their number: it was "no effect of the catalogue", 0.9 sure."""
    rng = np.random.default_rng(2)
    points = table(np.array([*product((0.0, 0.5, 1.0), repeat=3)] * 2), lambda p, v, T: 0.09 - 1e-4 * p, 2)
    coating = rng.integers(1, 5, len(points))
    points["mu"] += np.array([0.0, 0.03, 0.004, 0.024])[coating - 1]
    found = diagnose(points, pd.DataFrame({"test_id": points["test_id"], "coating": coating}))
    assert found.confidence <= MOSTLY and found.where[0]["variables"] == ["coating"], found.sentence
    assert any(w.startswith("coating is taken as a quantity of 1, 2, 3 and 4") for w in found.warnings)
    named = diagnose(
        points, pd.DataFrame({"test_id": points["test_id"], "coating": [f"c{k}" for k in coating]})
    )
    assert named.effects == ["factor:coating"] and named.confidence > 0.9, named.sentence


def of_a_factorial(seed: int) -> pd.DataFrame:
    """Return averages of 14 settings of a factorial of three levels, met to 1 %, whose friction only scatters, by 4.5 %."""
    rng = np.random.default_rng([seed, 14])
    levels = np.array([*product((5.0, 20.0, 80.0), (20.0, 80.0, 140.0), (150.0, 350.0, 700.0))])
    chosen = levels[rng.choice(27, 14, replace=False)]
    v, T, p = (chosen * (1.0 + rng.normal(0.0, 0.01, chosen.shape))).T
    loads = {"v_rel": v, "T": T, "sigma_n": p, "psi": 1.0 + 0.4 * (0.8 + 0.4 * rng.random(14))}
    names = [f"r{k}" for k in range(14)]
    return pd.DataFrame({"test_id": names, **loads, "mu": 0.1 * (1.0 + rng.normal(0.0, 0.045, 14))})


@pytest.mark.parametrize("seed", [1, 4, 5, *(pytest.param(k, marks=pytest.mark.nightly) for k in (2, 6))])
def test_beside_a_power_law_a_flexible_mean_leaves_what_tests_scatter(seed: int) -> None:
    """It followed every test, and the noise was nothing: an effect was missing in six of eight campaigns, up to 0.97 sure."""
    found = diagnose(of_a_factorial(seed), model="power_law")
    assert found.verdict == "nothing_missing", found.sentence
    assert found.noise_floor["total"] > 0.002
