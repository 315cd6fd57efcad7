"""`train`, `evaluate`, `predict` and `pack` with prediction intervals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models import load_model
from friction_models.loads import DataSet
from orchestrator.cli.main import run
from tests.friction_models.made_up import campaign


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a data set of 24 + 6 tests and a model of it with an interval."""
    folder = tmp_path_factory.mktemp("interval")
    names = [f"t{k:02d}" for k in range(30)]
    roles = pd.DataFrame({"test_id": names, "role": ["train"] * 24 + ["test"] * 6})
    DataSet(campaign(30, 12), roles, {"synthetic": True}).save(folder / "data")
    assert run(["train", "linear", "--data", str(folder / "data"), "-o", str(folder / "model")]) == 0
    return folder


def test_train_tells_the_coverage_and_keeps_it(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["evaluate", str(place / "model"), "--data", str(place / "data"), "--level", "0.8"]) == 0
    shown = capsys.readouterr().out
    assert "Coverage" in shown and "80.0%" in shown
    card = json.loads((place / "model" / "card.json").read_text())
    assert card["interval"]["level"] == 0.95 and card["interval"]["coverage"]["test"]["tests"] == 6.0


def test_predict_adds_the_bounds(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    frames = {}
    for name, more in (("usual", []), ("narrow", ["--level", "0.7"])):
        out = tmp_path / f"{name}.csv"
        arguments = ["predict", str(place / "model"), "--data", str(place / "data"), "-o", str(out), *more]
        assert run(arguments) == 0
        frames[name] = pd.read_csv(out)
    usual, narrow = frames["usual"], frames["narrow"]
    assert list(usual.columns[-3:]) == ["mu_model", "mu_low", "mu_high"]
    data = DataSet.load(place / "data")
    low, high = load_model(place / "model").predict_interval_frame(data.points)
    np.testing.assert_allclose(
        usual[["mu_low", "mu_high"]].to_numpy(), np.column_stack([low, high]), rtol=1e-12
    )
    assert (narrow["mu_high"] < usual["mu_high"]).all()
    # the ONNX file of the model gives the same bounds, at its own level
    onnx = ["predict", str(place / "model" / "model.onnx"), "--data", str(place / "data"), "-o", str(out)]
    assert run(onnx) == 0
    pd.testing.assert_frame_equal(pd.read_csv(out), usual, rtol=1e-12)
    assert run([*onnx, "--level", "0.7"]) == 2
    capsys.readouterr()
    assert run(["evaluate", str(place / "model"), "--data", str(place / "data"), "--level", "2"]) == 2
    said = capsys.readouterr()
    assert "0.5 to 0.999" in said.err and not said.out  # before anything is shown


def test_evaluate_writes_the_coverage(place: Path, tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    assert run(["evaluate", str(place / "model"), "--data", str(place / "data"), "--json", str(file)]) == 0
    content = json.loads(file.read_text())
    assert set(content["coverage"]) == {"train", "test", "all"}
    assert 0.0 <= content["coverage"]["test"]["share_low"] <= content["coverage"]["test"]["share"] <= 1.0


def test_without_an_interval(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "plain"
    data = str(place / "data")
    assert run(["train", "linear", "--data", data, "-o", str(out), "--no-interval"]) == 0
    assert "interval" not in json.loads((out / "card.json").read_text())
    assert run(["predict", str(out), "--data", data, "-o", str(tmp_path / "p.csv")]) == 0
    assert "mu_low" not in pd.read_csv(tmp_path / "p.csv").columns
    capsys.readouterr()
    for arguments, said in (
        (
            ["predict", str(out), "--data", data, "-o", str(tmp_path / "q.csv"), "--level", "0.9"],
            "has no prediction interval",
        ),
        (["pack", str(out), "--interval", "-o", str(tmp_path / "q.fmu")], "has no prediction interval"),
        (["pack", "twin", "--interval", "-o", str(tmp_path / "q.fmu")], "allowed for friction models"),
        (["train", "linear", "--data", data, "-o", str(tmp_path / "q"), "--level", "2"], "0.5 to 0.999"),
        (
            ["train", "linear", "--data", data, "-o", str(tmp_path / "q"), "--level", "0.9", "--no-interval"],
            "without --no-interval",
        ),
    ):
        assert run(arguments) == 2
        assert said in capsys.readouterr().err
    assert not list(tmp_path.glob("q*"))


def test_too_few_tests_are_trained_without_one_and_say_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    DataSet(campaign(3, 12), None, {}).save(tmp_path / "data")
    assert run(["train", "linear", "--data", str(tmp_path / "data"), "-o", str(tmp_path / "model")]) == 0
    assert "no prediction interval: interval: 3 tests, allowed: at least 4" in capsys.readouterr().out
    assert load_model(tmp_path / "model").interval is None


def test_a_test_that_refine_leaves_out_does_not_set_the_interval(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One record of 24 reads eight times too high; the interval was ten times as wide as mu."""
    rng = np.random.default_rng(4)
    sd = np.linspace(0.5, 20.0, 15)
    parts = []
    for k in range(24):
        v, p = rng.uniform(5.0, 400.0), rng.uniform(400.0, 2000.0)
        mu = 0.08 + 0.03 * np.exp(-v / 40.0) + rng.normal(0.0, 0.001) + rng.normal(0.0, 0.0005, 15)
        loads = {"v_rel": v, "T": 80.0, "sigma_n": p, "sd": sd, "psi": 1.1}
        parts.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu * (8.0 if k == 5 else 1.0)}))
    pd.concat(parts, ignore_index=True).to_csv(tmp_path / "points.csv", index=False)
    arguments = ["--data", str(tmp_path / "points.csv"), "--model", "linear", "--add", "stribeck"]
    assert run(["refine", *arguments, "-o", str(tmp_path / "model")]) == 0
    said = capsys.readouterr().out
    assert "23 tests" in said and "(without t05, as the fit)" in said
    interval = load_model(tmp_path / "model").interval
    assert interval is not None and interval.factor() * np.exp(interval.constant) < 0.01
