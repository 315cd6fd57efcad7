"""A change between two tests that nobody wrote down is no sensor that drifts."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest
from scipy.stats import qmc

from friction_models.discovery import Diagnosis, diagnose
from orchestrator.report.pages.diagnosis import diagnosis_page


def campaign(seed: int, course: str, scatter: float = 0.003) -> Diagnosis:
    """Diagnose 30 averages of which the level changes in their order: by 0.02 at the 16th, or by 0.04 steadily."""
    rng = np.random.default_rng(seed)
    u = qmc.LatinHypercube(3, seed=rng).random(30)
    order = np.arange(30)
    off = 0.02 * (order >= 15) if course == "step" else 0.04 * order / 29.0
    names = [f"t{k:02d}" for k in order]
    data = pd.DataFrame(
        {
            "test_id": names,
            "v_rel": 5.0 * 40.0 ** u[:, 0],
            "T": 20.0 + 180.0 * u[:, 1],
            "sigma_n": 200.0 + 1500.0 * u[:, 2],
            "mu": 0.09 - 5e-5 * (20.0 + 180.0 * u[:, 1]) + off + rng.normal(0.0, scatter, 30),
        }
    )
    return diagnose(data, pd.DataFrame({"test_id": names, "order": order}))


SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.nightly) for seed in (1, 2))]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_jump_is_told_with_its_place(seed: int) -> None:
    found = campaign(seed, "step")
    assert found.verdict == "data_problem" and found.effects == ["sensor_drift"], found.sentence
    told = re.match(r"the levels of the tests jump by \+([0-9.]+) between t14 and t15", found.sentence)
    assert told is not None, found.sentence
    assert float(told[1]) == pytest.approx(0.02, abs=0.004)
    assert "are at fault" not in diagnosis_page(found, "it")


@pytest.mark.parametrize("seed", SEEDS)
def test_a_drift_is_a_drift(seed: int) -> None:
    found = campaign(seed, "drift")
    assert found.effects == ["sensor_drift"], found.sentence
    assert not any("jump" in text for text in (found.sentence, *found.warnings))


@pytest.mark.parametrize("seed", [pytest.param(3, marks=pytest.mark.nightly), 8])
def test_a_jump_that_hardly_beats_a_drift_is_told_beside_it(seed: int) -> None:
    found = campaign(seed, "step", scatter=0.006)
    assert found.effects == ["sensor_drift"] and found.confidence <= 0.5, found.sentence
    assert any("jump" in w for w in found.warnings), found.warnings
    assert not any("jump" in w for w in campaign(seed, "drift", scatter=0.006).warnings)


def blocks(seed: int, jump: float, breakdown: float, shuffled: bool) -> Diagnosis:
    """Diagnose 27 tests whose pressure rises in their order, or not, with a jump at the 15th, or a breakdown where it is hot and pressed."""
    rng = np.random.default_rng([seed, 5])
    names, frames = [f"t{k:02d}" for k in range(27)], []
    for k, name in enumerate(names):
        v, T, p = (5.0, 50.0, 400.0)[k % 3], (20.0, 150.0, 280.0)[k // 3 % 3], (150.0, 480.0, 1150.0)[k // 9]
        hot = 1.0 / (1.0 + np.exp(-(p * np.exp(0.006 * (T - 20.0)) / 1500.0 - 1.0) / 0.1))
        mu = 0.09 - 5e-5 * T + jump * (k >= 14) + breakdown * hot + 0.0015 * rng.standard_normal()
        sd = np.linspace(0.0, 30.0, 20)
        loads = {
            "t": sd / v,
            "v_rel": v,
            "T": T + 0.1 * sd,
            "sigma_n": p * rng.uniform(0.97, 1.03),
            "sd": sd,
            "psi": 1.2,
        }
        frames.append(pd.DataFrame({"test_id": name, **loads, "mu": mu + 0.001 * rng.standard_normal(20)}))
    order = rng.permutation(27) if shuffled else np.arange(27)
    return diagnose(pd.concat(frames, ignore_index=True), pd.DataFrame({"test_id": names, "order": order}))


@pytest.mark.parametrize("seed", [1, pytest.param(4, marks=pytest.mark.nightly)])
def test_a_jump_that_follows_a_load_is_told_beside_the_name(seed: int) -> None:
    found = blocks(seed, 0.012, 0.0, shuffled=False)
    assert found.effects == ["hot_pressure_breakdown"] and found.confidence <= 0.5, found.sentence
    assert any("a jump between t13 and t14" in w for w in found.warnings), found.warnings


@pytest.mark.parametrize("shuffled", [pytest.param(False, marks=pytest.mark.nightly), True])
def test_no_jump_stands_for_an_effect_that_is_there(shuffled: bool) -> None:
    found = blocks(3, 0.0, 0.03, shuffled)
    assert found.effects == ["hot_pressure_breakdown"], found.sentence
    assert not any("jump" in w for w in found.warnings), found.warnings
