"""Few tests at one level that all lie far off the others: "nothing missing" is not sure there."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.discovery import diagnose
from friction_models.discovery.causes.lone_levels import about_lone_levels
from friction_models.discovery.judge.doubts import LIKELY
from friction_models.estimation.campaign.binning import prepare


def at_levels(seed: int, tests: int = 30) -> pd.DataFrame:
    """Return averages of tests at levels of the loads; at 12 mm/s two of them were run. Friction depends on nothing."""
    rng = np.random.default_rng([seed, 41])
    v = rng.choice([2.0, 5.0, 30.0, 80.0], tests)
    v[[3, tests - 4]] = 12.0
    return pd.DataFrame(
        {
            "test_id": [f"t{k:02d}" for k in range(tests)],
            "v_rel": v,
            "T": rng.choice([20.0, 60.0, 100.0, 140.0], tests),
            "sigma_n": rng.choice([300.0, 450.0, 600.0, 750.0], tests),
            "mu": 0.085 + rng.normal(0.0, 0.003, tests),
        }
    )


def test_a_peak_at_one_speed_is_told() -> None:
    """The residual table said +0.023 +- 0.008 at that speed, the sentence that nothing can be seen to be missing, 0.88 sure."""
    data = at_levels(1)
    data.loc[data["v_rel"] == 12.0, "mu"] += 0.024
    found = diagnose(data)
    assert found.verdict != "nothing_missing" or found.confidence <= LIKELY, found.sentence
    assert any("all tests at v_rel 12 mm/s (t03, t26) lie off by +0.02" in w for w in found.warnings)


def test_chance_is_hardly_ever_told() -> None:
    told = 0
    for seed in range(60):
        campaign = prepare(at_levels(seed))
        told += bool(about_lone_levels(campaign, campaign.average(campaign.mu - campaign.mu.mean())))
    assert told <= 2  # about one of a hundred campaigns


def test_where_nothing_scatters_no_level_lies_off() -> None:
    data = at_levels(1)
    campaign = prepare(data.assign(mu=0.085 + 1e-6 * (data["v_rel"] == 12.0)))
    assert not about_lone_levels(campaign, campaign.average(campaign.mu - campaign.mu.mean()))
