"""Every command takes data without some of the five loads, says which, and refuses what needs them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models.loads import DataSet
from orchestrator.cli.main import run
from tests.friction_models.made_up import campaign


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the data sets `full` and `less`, the latter without T and psi, with tests held out."""
    folder = tmp_path_factory.mktemp("place")
    points = campaign(12, 20)
    tests = pd.DataFrame({"test_id": points["test_id"].unique(), "role": ["train"] * 8 + ["test"] * 4})
    DataSet(points, tests).save(folder / "full")
    DataSet(points.drop(columns=["T", "psi"]), tests).save(folder / "less")
    assert run(["train", "linear", "--data", str(folder / "less"), "-o", str(folder / "model")]) == 0
    assert run(["train", "linear", "--data", str(folder / "full"), "-o", str(folder / "whole")]) == 0
    return folder


def test_commands_take_what_there_is(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    less, model, out = str(place / "less"), str(place / "model"), tmp_path
    for words in (
        ["evaluate", model, "--json", str(out / "e.json")],
        ["predict", model, "-o", str(out / "p.csv")],
        ["compare", "--models", model, "0.08", "--report", str(out / "c.html"), "--json", str(out / "c.json")],
        ["diagnose", "--model", model, "--report", str(out / "d.html"), "--json", str(out / "d.json")],
        ["refine", "--model", model, "--add", "stribeck", "-o", str(out / "r"), "--report", str(out / "r.html")],
    ):  # fmt: skip
        assert run([*words, "--data", less]) == 0, words
        assert "T, psi not measured" in capsys.readouterr().err, words
    assert json.loads((out / "e.json").read_text())["overall"]["outside_domain"] == 0.0
    assert json.loads((out / "c.json").read_text())["models"]["model"]["outside_domain"] == 0.0
    assert json.loads((out / "d.json").read_text())["verdict"] != "out_of_domain"
    predicted = pd.read_csv(out / "p.csv")
    assert "T" not in predicted and np.isfinite(predicted["mu_model"]).all()
    card = json.loads((out / "r" / "card.json").read_text())
    assert card["domain"]["T"] is None is card["domain"]["psi"] and card["domain"]["sd"] == [0.5, 60.0]
    assert run(["pack", str(out / "r"), "-o", str(out / "f.fmu")]) == 0
    assert run(["evaluate", str(out / "f.fmu"), "--data", less]) == 0


def test_what_needs_a_load_that_is_not_there_is_refused(
    place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    less, history = str(place / "less"), str(tmp_path / "h.csv")
    for words, said in (
        (["evaluate", str(place / "whole")], "was given T and psi in training, which these data lack"),
        (
            ["diagnose", "--model", str(place / "whole")],
            "was given T and psi in training, which these data lack",
        ),
        (["diagnose", "--model", "linear", "--data", str(place / "full")], "column 'T' [degC] is missing"),
        (["refine", "--model", "linear", "--add", "viscous", "thermal_softening", "-o", history], "needs T"),
        (["study", "learning-curve", "--quick", "-o", history, "--data", f"oil={less}"], "'T'"),
    ):
        given = [] if words[0] == "study" else ["--data", less]
        assert run([*words, *given]) == 2, words
        error = capsys.readouterr().err
        assert said in error and "Traceback" not in error, error
