"""A change between two tests that nobody wrote down is no sensor that drifts."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest
from scipy.stats import qmc

from friction_models.discovery import Diagnosis, diagnose
from orchestrator.report.pages.diagnosis import diagnosis_page


def campaign(seed: int, course: str) -> Diagnosis:
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
            "mu": 0.09 - 5e-5 * (20.0 + 180.0 * u[:, 1]) + off + rng.normal(0.0, 0.003, 30),
        }
    )
    return diagnose(data, pd.DataFrame({"test_id": names, "order": order}))


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_jump_is_told_with_its_place(seed: int) -> None:
    found = campaign(seed, "step")
    assert found.verdict == "data_problem" and found.effects == ["sensor_drift"], found.sentence
    told = re.match(r"the levels of the tests jump by \+([0-9.]+) between t14 and t15", found.sentence)
    assert told is not None, found.sentence
    assert float(told[1]) == pytest.approx(0.02, abs=0.004)
    assert "are at fault" not in diagnosis_page(found, "it")


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_drift_is_a_drift(seed: int) -> None:
    found = campaign(seed, "drift")
    assert found.effects == ["sensor_drift"], found.sentence
    assert not any("jump" in text for text in (found.sentence, *found.warnings))
