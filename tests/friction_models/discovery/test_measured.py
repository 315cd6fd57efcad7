"""Measured friction data of third parties: the finder on contacts that nobody made up. Skipped without the data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models import ConstantFriction
from friction_models.discovery import diagnose, refine

DATA = Path(__file__).parents[3].parent / "shared" / "data"
PRESSURE = {"pressure_power", "pressure_saturation", "force_zero"}
MEMORYLESS_SPEED = {"stribeck", "viscous"}


def _file(name: str) -> Path:
    path = DATA / name
    if not path.is_file():
        pytest.skip(f"measured data {name} is not beside the repository")
    return path


def motor_oil() -> pd.DataFrame:
    """One averaged point a test, load at least 3 N."""
    table = pd.read_csv(_file("stribeck_motor_oil_glass/summary.csv"))
    table = table[table["load_N"] >= 3.0]
    return pd.DataFrame(
        {
            "test_id": table["test"],
            "v_rel": table["v_mm_s"],
            "sigma_n": table["sigma_n_MPa"],
            "mu": table["mu"],
        }
    )


def test_motor_oil_pressure_first_then_speed() -> None:
    answer = diagnose(motor_oil(), model="constant")
    assert answer.ranking[0]["effect"] in PRESSURE
    assert answer.verdict in {"ambiguous", "explained"}
    assert answer.effects[0] in PRESSURE and answer.effects[1:] == ["viscous"]
    assert any("averaged data" in w for w in answer.warnings)
    row = answer.next_tests[0]["plan"][0]
    assert (
        "T_tool" not in row and 0.0 < row["sigma_set"] < 1.0
    )  # a contact of tenths of a MPa; no temperature in the data


def test_motor_oil_error_left_out_falls() -> None:
    data = motor_oil().assign(T=20.0, sd=0.0, psi=1.0)

    def left_out(effects: list[str]) -> float:
        errors = []
        for test in data["test_id"]:
            rest, one = data[data["test_id"] != test], data[data["test_id"] == test]
            model = ConstantFriction().fit_frame(rest) if not effects else None
            if model is None:
                composed = ConstantFriction() + effects[0]
                for name in effects[1:]:
                    composed = composed + name
                model = composed.fit_frame(rest)
            errors.append(abs(float(model.predict_frame(one).iloc[0] - one["mu"].iloc[0])))
        return float(np.mean(errors))

    constant, load, both = left_out([]), left_out(["pressure_power"]), left_out(["pressure_power", "viscous"])
    assert constant == pytest.approx(0.0198, abs=0.001)
    assert load < 0.6 * constant and both < 0.4 * constant


def test_sepiolite_shows_memory_and_admits_what_one_test_cannot_show() -> None:
    table = pd.read_csv(_file("rate_state_sepiolite/sepiolite.csv"))
    data = pd.DataFrame(
        {
            "test_id": "sepiolite",
            "t": table["t_s"] - table["t_s"].iloc[0],
            "v_rel": np.maximum(table["v_um_s"], 0.0) * 1e-3,
            "sigma_n": table["sigma_n_MPa"],
            "sd": table["sliding_distance_um"] * 1e-3,
            "mu": table["mu"],
        }
    )
    answer = diagnose(data, model="constant")
    place = {r["effect"]: k for k, r in enumerate(answer.ranking)}
    assert place["rate_state"] < min(place[n] for n in MEMORYLESS_SPEED)
    assert answer.confidence <= 0.5
    assert "cannot show the scatter" in answer.sentence
    assert any("one test" in w for w in answer.warnings)
    some = data.iloc[::3].assign(T=20.0, psi=1.0)
    refined = refine(some, model=ConstantFriction(), add=["rate_state"])
    plain = ConstantFriction().fit_frame(some)
    assert refined.errors_["train"]["rmse"] < 0.2 * plain.errors_["train"]["rmse"]
