"""A logger that rounds mu to a coarse step is no fault, and a spike in its records still is one."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.discovery import diagnose
from friction_models.estimation.campaign.binning import prepare


def rounded(step: float, spikes: int = 0) -> pd.DataFrame:
    """Return tests in which friction falls with speed, rounded, with a few spikes."""
    rng = np.random.default_rng(8)
    frames = []
    for k in range(24):
        v = float(np.exp(rng.uniform(np.log(5.0), np.log(300.0))))
        sd = np.linspace(0.0, 60.0, 60)
        mu = 0.12 - 0.02 * np.tanh(np.log(v / 40.0)) + 0.002 * rng.normal() + 0.002 * rng.normal(size=60)
        frames.append(
            pd.DataFrame(
                {"test_id": f"t{k:02d}", "t": sd / v, "v_rel": v, "T": 20.0, "sigma_n": 500.0, "sd": sd, "mu": mu}
            )
        )  # fmt: skip
    data = pd.concat(frames, ignore_index=True)
    data["mu"] = (data["mu"] / step).round() * step if step else data["mu"]
    data.loc[rng.choice(len(data), spikes, replace=False), "mu"] += 0.08
    return data


def test_rounding_is_no_spike_and_spikes_are_seen() -> None:
    assert prepare(rounded(0.01)).spikes == 0.0
    assert prepare(rounded(0.0)).spikes == 0.0
    for step in (0.0, 0.01):
        assert 0.008 < prepare(rounded(step, spikes=20)).spikes < 0.016


def test_the_tests_that_hold_most_spikes_are_named() -> None:
    data = rounded(0.0)
    data.loc[[610, 630, 650, 905], "mu"] += 0.08
    told = [w for w in prepare(data).warnings if "far off their neighbours" in w]
    assert told == ["left out, far off their neighbours: 4 single points (test t10, t15)"]


def test_rounded_records_are_diagnosed() -> None:
    found = diagnose(rounded(0.01))
    assert found.verdict not in {"data_problem", "nothing_missing"}
    low, high = found.noise_floor["interval"]
    assert low <= found.noise_floor["total"] <= high


def test_a_force_in_steps_under_a_falling_pressure_is_no_fault() -> None:
    """The step of the force is known, that of mu grows as the specimen spreads: no value of mu comes twice."""
    rng = np.random.default_rng(3)
    frames = []
    for k in range(20):
        pressure = (300.0 + 11.0 * k) * np.linspace(1.0, 0.8, 120)
        force = pressure * (0.11 + 0.002 * rng.normal() + 0.0012 * rng.normal(size=120))
        frames.append(
            pd.DataFrame({"test_id": f"t{k}", "v_rel": 10.0 + 8.0 * k, "sigma_n": pressure, "sd": np.arange(120.0)}).assign(
                mu=(force / 6.0).round() * 6.0 / pressure
            )
        )  # fmt: skip
    data = pd.concat(frames, ignore_index=True)
    assert data["mu"].nunique() > 0.1 * len(data)
    assert prepare(data).spikes < 0.01
    hit = rng.choice(len(data), len(data) // 12, replace=False)
    data.loc[hit, "mu"] += rng.exponential(0.2, len(hit))
    assert prepare(data).spikes > 0.05
