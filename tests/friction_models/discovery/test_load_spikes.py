"""Single readings of loads that no machine can have had."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import Diagnosis, diagnose, refine
from friction_models.estimation.campaign.binning import prepare
from friction_models.loads import LOAD_NAMES


def falling_with_speed(seed: int = 5, tests: int = 20, points: int = 30) -> pd.DataFrame:
    """Return tests in which mu falls with the speed; each goes on at its speed, and the contact warms up."""
    rng = np.random.default_rng(seed)
    frames = []
    for k in range(tests):
        v, T, p = np.exp(rng.uniform(1.6, 6.0)), rng.uniform(20.0, 180.0), rng.uniform(200.0, 1200.0)
        t = np.linspace(0.0, 50.0 / v, points)
        mu = 0.08 + 0.05 * np.exp(-((v / 30.0) ** 0.8)) - 1e-4 * T + 0.003 * rng.standard_normal()
        frames.append(
            pd.DataFrame(
                {
                    "test_id": f"t{k:02d}", "t": t, "v_rel": v, "T": T + 0.4 * v * t, "sigma_n": p * (1.0 + 0.01 * rng.standard_normal(points)),
                    "sd": v * t, "psi": 1.0 + 0.02 * v * t, "mu": mu + 0.002 * rng.standard_normal(points),
                }
            )
        )  # fmt: skip
    return pd.concat(frames, ignore_index=True)


@pytest.fixture(scope="module")
def whole() -> Diagnosis:
    return diagnose(falling_with_speed())


@pytest.mark.parametrize(
    ("load", "wrong"),
    [
        ("v_rel", 100.0),
        *(
            pytest.param(*p, marks=pytest.mark.nightly)
            for p in (("v_rel", 0.0), ("T", 10.0), ("sigma_n", 30.0))
        ),
    ],
    ids=str,
)
def test_a_few_wrong_readings_change_no_answer_and_no_domain(
    load: str, wrong: float, whole: Diagnosis
) -> None:
    data = falling_with_speed()
    spoilt = data.copy()
    for k in (12, 100, 255):
        spoilt.loc[k, load] *= wrong
    found = diagnose(spoilt)
    assert (found.verdict, found.confusion_set) == (whole.verdict, whole.confusion_set)
    assert found.effects == whole.effects == ["stribeck"]
    told = [w for w in found.warnings if w.startswith("taken from their neighbours")]
    assert len(told) == 1 and f"{load} at 3 single points (test t00, t03, t08)" in told[0]
    assert found.noise_floor["total"] == pytest.approx(whole.noise_floor["total"], rel=0.02)
    model = refine(spoilt, add="stribeck")
    assert model.domain_.upper[LOAD_NAMES.index(load)] < 1.1 * data[load].max()  # type: ignore[union-attr]


def test_rests_steps_ramps_and_quantised_loads_stay() -> None:
    data = falling_with_speed()
    rests = data.copy()
    for k in range(10, len(rests), 60):  # nothing slides from the point before to the one after
        rests.loc[k, "v_rel"] = 0.0
        rests.loc[k : k + 1, ["sd", "psi"]] = rests.loc[k - 1, ["sd", "psi"]].to_numpy()
    steps = data.assign(v_rel=data["v_rel"] * np.where(data.groupby("test_id").cumcount() > 15, 10.0, 1.0))
    ramps = data.assign(sigma_n=data["sigma_n"] * (1.0 + data.groupby("test_id").cumcount()))
    coarse = data.assign(sigma_n=np.maximum(np.round(data["sigma_n"] / 400.0), 1.0) * 400.0)
    pulses = data.assign(T=data["T"] + 300.0 * (data.groupby("test_id").cumcount() % 7 < 2))
    for changed in (data, rests, steps, ramps, coarse, pulses):
        campaign = prepare(changed)
        assert campaign.spikes == 0.0
        assert not any("neighbours" in w for w in campaign.warnings)


def test_many_wrong_readings_are_a_problem_of_the_data() -> None:
    data = falling_with_speed()
    data.loc[5::10, "v_rel"] *= 50.0
    assert diagnose(data).verdict == "data_problem"
