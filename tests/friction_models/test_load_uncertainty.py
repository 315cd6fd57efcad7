"""Uncertain loads: their part of a model's error, against closed forms and against loads that are drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models import DataSet, LinearFriction, evaluate
from friction_models.common import InputError
from friction_models.models.measures import loads_sentence
from friction_models.training.evaluation import train
from friction_models.training.load_uncertainty import load_uncertainty


class Law:
    """mu with a slope of each uncertain load."""

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> np.ndarray:
        sigma, T, psi = (data[name].to_numpy() for name in ("sigma_n", "T", "psi"))
        return 0.1 - 2e-5 * sigma + 1e-4 * T + 0.05 * (psi - 1.0)


def points(tests: int = 40, each: int = 25, seed: int = 1) -> pd.DataFrame:
    rng = np.random.default_rng(seed)

    def per_test(low: float, high: float) -> np.ndarray:
        return np.repeat(rng.uniform(low, high, tests), each)

    sd = np.tile(np.linspace(1.0, 50.0, each), tests)
    frame = pd.DataFrame(
        {
            "test_id": np.repeat([f"t{k:02d}" for k in range(tests)], each),
            "t": sd / 100.0,
            "v_rel": per_test(5.0, 300.0),
            "T": per_test(30.0, 150.0) + sd,
            "sigma_n": per_test(500.0, 2000.0),
            "sd": sd,
            "psi": per_test(1.0, 1.6),
        }
    )
    return frame.assign(u_sigma_n=0.02 * frame["sigma_n"], u_psi=0.01, u_T=3.0, mu=Law().predict_frame(frame))


def test_of_a_linear_law_it_is_the_closed_form() -> None:
    frame = points()
    found = load_uncertainty(Law(), frame)
    assert found is not None
    parts = 2e-5 * frame["u_sigma_n"], 1e-4 * frame["u_T"], 0.05 * frame["u_psi"]
    expected = np.sqrt(sum(part.to_numpy() ** 2 for part in parts))
    np.testing.assert_allclose(found.points, expected, rtol=1e-6)
    assert list(found.by_load) == ["sigma_n", "psi", "T"]
    assert found.by_load["T"] == pytest.approx(3e-4)
    # Within a test the errors are common: the mean of a test is no better known than its points.
    first = expected[frame["test_id"] == "t00"]
    assert found.tests["t00"] == pytest.approx(first[0])


def test_it_is_the_error_that_wrong_loads_make() -> None:
    """Each test gets one error of each load, drawn; then the true law is wrong by that much."""
    frame = points(tests=400, each=4)
    rng = np.random.default_rng(2)
    drawn = frame.copy()
    for load, name in (("sigma_n", "u_sigma_n"), ("T", "u_T"), ("psi", "u_psi")):
        drawn[load] += np.repeat(rng.standard_normal(400), 4) * frame[name]
    evaluation = evaluate(Law(), drawn)
    assert evaluation.overall["rms_from_loads"] == pytest.approx(evaluation.overall["rmse"], rel=0.08)
    assert "Uncertain loads" in evaluation.report()
    found = load_uncertainty(Law(), drawn)
    assert found is not None
    bias = (Law().predict_frame(drawn) - drawn["mu"]).groupby(drawn["test_id"]).mean()
    assert np.sqrt(np.mean((bias / found.tests) ** 2)) == pytest.approx(1.0, abs=0.1)


def test_training_says_it_in_the_card(tmp_path: Path) -> None:
    frame = points()
    model = LinearFriction()
    names = frame["test_id"].unique()
    tests = pd.DataFrame({"test_id": names, "role": ["train"] * 30 + ["test"] * 10})
    evaluation = train(model, DataSet(frame, tests))
    assert evaluation.overall["rms_from_loads"] == pytest.approx(load_of(frame), rel=0.05)
    assert set(evaluation.roles) == {"train", "test"}
    text = (model.save(tmp_path / "model") / "card.md").read_text()
    assert (
        "Uncertain loads (u_sigma_n, u_psi, u_T) alone would give an RMSE of" in text
        and "- test: Uncertain" in text
    )


def load_of(frame: pd.DataFrame) -> float:
    found = load_uncertainty(Law(), frame)
    assert found is not None
    return found.rms


def test_data_without_uncertainties_are_judged_as_before() -> None:
    frame = points().drop(columns=["u_sigma_n", "u_psi", "u_T"])
    assert load_uncertainty(Law(), frame) is None
    evaluation = evaluate(Law(), frame)
    assert "rms_from_loads" not in evaluation.overall
    assert "Uncertain loads" not in evaluation.report()


def test_one_uncertainty_is_enough_and_a_wrong_one_is_named() -> None:
    frame = points().drop(columns=["u_psi", "u_T"])
    found = load_uncertainty(Law(), frame)
    assert found is not None and list(found.by_load) == ["sigma_n"]
    frame.loc[3, "u_sigma_n"] = -1.0
    with pytest.raises(InputError, match=r"column 'u_sigma_n', row 3: -1\.0; allowed: finite numbers from 0"):
        load_uncertainty(Law(), frame)


def test_more_than_all_is_all() -> None:
    assert "100% of the mean square error" in loads_sentence(0.002, 0.001)
