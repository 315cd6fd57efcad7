"""Loads that multiply look like an effect of several loads beside a straight law."""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.judge.doubts import LIKELY


def powers(seed: int) -> pd.DataFrame:
    """Return averages of strip drawing: friction falls with the roots of pressure and speed, and nothing else does anything."""
    rng = np.random.default_rng([seed, 31])
    plan = np.array([*product((10.0, 25.0, 50.0, 80.0), (2.0, 10.0, 50.0, 100.0), (20.0, 60.0, 100.0))])
    p, v, T = rng.permutation(plan).T
    mu = 0.12 * (p / 25.0) ** -0.25 * (v / 10.0) ** -0.15 * np.exp(0.04 * rng.normal(size=len(p)))
    return pd.DataFrame(
        {"test_id": [f"t{k}" for k in range(len(p))], "sigma_n": p, "v_rel": v, "T": T, "mu": mu}
    )


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.nightly)])
def test_a_power_law_is_told_beside_an_effect_of_several_loads(seed: int) -> None:
    """It was flash temperature, up to 0.96 sure."""
    found = diagnose(powers(seed))
    assert found.effects == ["flash_temperature"] and found.confidence <= LIKELY, found.sentence
    assert any("try the model power_law" in w for w in found.warnings)
    assert diagnose(powers(seed), model="power_law").verdict == "nothing_missing"


def test_a_law_of_hot_tips_is_not_taken_for_a_power_law() -> None:
    """The rise of a sliding tip by its own half-space (square roots of pressure and speed), with a threshold that no power has."""
    data = powers(2)
    rise = 6.0 * np.sqrt(data["sigma_n"] * data["v_rel"])
    mu = 0.12 - 0.05 / (1.0 + np.exp((350.0 - data["T"] - rise) / 25.0))
    noise = np.random.default_rng(3).normal(0.0, 0.003, len(data))
    found = diagnose(data.assign(mu=mu + noise))
    assert not any("try the model power_law" in w for w in found.warnings), found.sentence
