"""Uncertain loads in a diagnosis: their part of the floor against closed forms, and effects that rest on them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from friction_models.discovery import Diagnosis, diagnose
from orchestrator.report.sections.evidence import budget_html


def campaign(u_T: float, tests: int = 16, each: int = 10, seed: int = 0) -> pd.DataFrame:
    """Return tests of mu = 0.11 - 1e-4 T, whose temperature is off by an error of each test."""
    rng = np.random.default_rng(seed)
    T = np.repeat(rng.uniform(40.0, 200.0, tests), each) + np.tile(np.linspace(0.0, 30.0, each), tests)
    v = np.repeat(rng.uniform(5.0, 300.0, tests), each)
    frame = pd.DataFrame(
        {
            "test_id": np.repeat([f"t{k:02d}" for k in range(tests)], each),
            "sd": np.tile(np.linspace(1.0, 40.0, each), tests),
            "v_rel": v,
            "T": T + u_T * np.repeat(rng.standard_normal(tests), each),
            "sigma_n": np.repeat(rng.uniform(500.0, 2000.0, tests), each),
            "mu": 0.11 - 1e-4 * T + 3e-4 * rng.standard_normal(len(T)),
        }
    )
    return frame.assign(u_T=u_T, u_sigma_n=0.0)


def answer_of(frame: pd.DataFrame, model: str = "linear") -> Diagnosis:
    return diagnose(frame, model=model, catalogue=["stribeck", "thermal_softening"])


def test_the_part_of_the_floor_is_the_slope_times_the_uncertainty() -> None:
    frame = campaign(15.0)
    answer = answer_of(frame)
    found = answer.noise_floor["from_loads"]
    design = np.column_stack([np.ones(len(frame)), frame[["sd", "v_rel", "T", "sigma_n"]]])
    slope = np.linalg.lstsq(design, frame["mu"], rcond=None)[0][3]
    assert list(found["by_load"]) == ["T"]
    assert found["total"] == pytest.approx(abs(slope) * 15.0, rel=1e-3)
    # the floor is hardly more than that here: the temperatures are the one thing that is wrong
    assert found["total"] == pytest.approx(answer.noise_floor["total"], rel=0.5)
    assert answer.to_dict()["noise_floor"]["from_loads"] == found  # type: ignore[index]
    said = f"{found['total']:.4f}"
    assert (
        said in answer.report()
        and "uncertain loads (mostly T) make of the model's own slopes" in answer.report()
    )
    assert "uncertain loads (mostly T)" in budget_html(answer.to_dict())  # type: ignore[arg-type]


def test_an_effect_that_is_named_counts_with_its_own_slope() -> None:
    frame = campaign(3.0)
    answer = answer_of(frame, model="constant")
    assert answer.effects == ["thermal_softening"]
    assert answer.noise_floor["from_loads"]["total"] == pytest.approx(1e-4 * 3.0, rel=0.1)
    assert not any("rests on T" in text for text in answer.warnings)


def test_an_effect_of_a_load_as_uncertain_as_it_is_spread_is_named_with_a_warning() -> None:
    frame = campaign(3.0).assign(u_T=70.0)
    answer = answer_of(frame, model="constant")
    assert answer.effects == ["thermal_softening"]
    spread = frame.groupby("test_id")["T"].mean().std()
    assert spread < 70.0
    said = [text for text in answer.warnings if text.startswith("thermal_softening rests on T")]
    assert len(said) == 1 and f"(70) is as large as its spread between tests ({spread:.3g})" in said[0]
    assert "the uncertainties are stated too large" in answer.report()


def test_without_stated_uncertainty_the_answer_is_that_of_before() -> None:
    frame = campaign(5.0)
    plain = answer_of(frame.drop(columns=["u_T", "u_sigma_n"]))
    assert "from_loads" not in plain.noise_floor and "uncertain loads" not in plain.report()
    stated = answer_of(frame).to_dict()
    floor = dict(stated["noise_floor"])  # type: ignore[call-overload]
    del floor["from_loads"]
    assert {**stated, "noise_floor": floor} == plain.to_dict()


def test_a_bad_uncertainty_is_refused() -> None:
    with pytest.raises(InputError, match=r"column 'u_T', row 0: nan; allowed: finite numbers from 0"):
        answer_of(campaign(5.0).assign(u_T=np.nan))
