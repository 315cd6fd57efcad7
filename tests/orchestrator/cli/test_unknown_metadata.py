"""`predict`, `evaluate` and `compare` say which metadata of the tests a model was not trained with."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from fmus import pack
from friction_models import LinearFriction, load_model
from friction_models.loads import DataSet
from friction_models.models.unknown_metadata import metadata_remarks
from friction_models.models.variables import SystemVariable
from orchestrator.cli.main import run
from tests.friction_models.made_up import campaign

BATCH = SystemVariable("batch", "1", 0.0, 0.0, 1.0, ("lot A", "lot B"))
ROUGHNESS = SystemVariable("Ra", "um", 0.4, 0.1, 0.8)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with tests of three batches, a model of them, and its FMU."""
    folder = tmp_path_factory.mktemp("labels")
    points = campaign(9, 8)
    names = points["test_id"].unique()
    tests = pd.DataFrame({"test_id": names, "batch": [f"lot {'ABC'[k % 3]}" for k in range(len(names))]})
    DataSet(points, tests).save(folder / "known")
    DataSet(points, tests.replace("lot C", "Lot-C")).save(folder / "new")
    DataSet(points, tests[["test_id"]]).save(folder / "without")
    (LinearFriction() + "batch").fit_frame(points, tests).save(folder / "model")
    pack(load_model(folder / "model"), folder / "model.fmu", target="python")
    return folder


@pytest.mark.parametrize("model", ["model", "model/model.onnx", "model.fmu"])
def test_a_command_names_what_a_model_does_not_know(
    place: Path, tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = {
        "known": "",
        "new": "3 of 9 tests have a batch that was not in the training: 'Lot-C' (nearest: 'lot C'); it adds nothing to mu",
        "without": "the table of tests has no column 'batch': 'lot A' is taken for all tests",
    }
    for data, said in words.items():
        commands = [
            ["predict", str(place / model), "-o", str(tmp_path / f"{data}.csv")],
            ["evaluate", str(place / model)],
            ["compare", "--models", str(place / model), str(place / "model"), "0.08"],
        ]
        for command in commands[: 3 if model == "model.fmu" else 2]:
            assert run([*command, "--data", str(place / data)]) == 0
            notes = [line for line in capsys.readouterr().err.splitlines() if line.startswith("note: ")]
            assert notes == ([f"note: {place / data}: {said}"] if said else []), command


@pytest.mark.parametrize(
    ("variable", "cells", "said"),
    [
        (BATCH, {"batch": ["lot A", "lot B"]}, []),
        (
            BATCH,
            {"batch": ["lot A", None]},
            ["1 of 2 tests has a batch that was not in the training: an empty cell"],
        ),
        (BATCH, {"batch": ["lot A", "lot B "]}, ["'lot B ' (nearest: 'lot B')"]),
        (
            BATCH,
            {"Batch": ["lot A", "lot B"]},
            ["no column 'batch' (is it 'Batch'?): 'lot A' is taken for all tests"],
        ),
        (ROUGHNESS, {"Ra": [0.4, 0.2]}, []),
        (ROUGHNESS, {"Ra": ["rough", 0.2]}, ["1 of 2 tests has no number as Ra: 0.4 um is taken"]),
        (ROUGHNESS, {}, ["no column 'Ra': 0.4 um is taken for all tests"]),
    ],
)
def test_remarks(variable: SystemVariable, cells: dict[str, list[object]], said: list[str]) -> None:
    tests = pd.DataFrame({"test_id": ["t1", "t2"], **cells})
    found = metadata_remarks([variable], tests, ["t1", "t1", "t2"])
    assert len(found) == len(said) and all(part in text for part, text in zip(said, found, strict=True)), (
        found
    )


def test_many_labels_are_counted() -> None:
    tests = pd.DataFrame({"test_id": range(40), "batch": [f"x{k:02d}" for k in range(40)]})
    (found,) = metadata_remarks([BATCH], tests, range(40))
    assert "'x04', and 35 more; " in found
