"""Fields of a forming FMU in a co-simulated run: kept in the run folder, shown in its report."""

from __future__ import annotations

import json
import os
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from fmus import pack_forming
from forming.results.field_recorder import FIELDS_FOLDER
from orchestrator.cli.app import app
from orchestrator.cosim.run_fields import asked_for_fields, fields_of
from orchestrator.cosim.run_folders import Run
from orchestrator.report import write_report


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    place = tmp_path_factory.mktemp("fields")
    pack_forming(place / "forming.fmu", n_points=30, mesh_size=0.8)
    (place / "fre.yaml").write_text(
        "name: fre\ncommunication_step: 0.04\nstop_time: 0.2\n"
        "components:\n  forming: {fmu: forming.fmu, start: {mu: 0.08}}\n"
    )
    return place / "fre.yaml"


@pytest.mark.parametrize("mode", ["gauss_seidel", "iterated"])
def test_run_with_fields_is_the_run_without_them(system, tmp_path, mode):
    for folder, more in (("plain", []), ("kept", ["--fields", "0.25"])):
        arguments = ["simulate", str(system), "-o", str(tmp_path / folder), "--mode", mode, *more]
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0, done.output
    plain, kept = Run.load(tmp_path / "plain"), Run.load(tmp_path / "kept")
    for name, values in plain.values.items():
        assert np.array_equal(values, kept[name]), name
    assert not (tmp_path / "plain" / "fields").exists()
    fields = fields_of(tmp_path / "kept")["fre"]
    assert np.allclose(fields.strokes, [0.0, 0.25, 0.5, 0.75, 1.0], atol=0.1)
    assert (tmp_path / "kept" / "fields" / "fre" / "fields.pvd").is_file()
    assert FIELDS_FOLDER not in os.environ


def test_report_of_the_run_shows_the_fields(system, tmp_path):
    done = CliRunner().invoke(app, ["simulate", str(system), "-o", str(tmp_path / "run"), "--fields", "0.5"])
    assert done.exit_code == 0 and "3 snapshots" in done.output
    text = write_report(tmp_path / "run").read_text()
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', text, re.S).group(1))
    assert len(data["frames"]) == 3 and len(data["force"]["stroke"]) == 6


def test_impossible_distance_is_refused(system, tmp_path):
    done = CliRunner().invoke(app, ["simulate", str(system), "-o", str(tmp_path / "run"), "--fields", "0"])
    assert done.exit_code != 0 and not (tmp_path / "run").exists()


def test_environment_is_left_as_it_was(monkeypatch):
    monkeypatch.setenv(FIELDS_FOLDER, "mine")
    with asked_for_fields(1.0) as place:
        assert os.environ[FIELDS_FOLDER] == str(place) and place.is_dir()
    assert os.environ[FIELDS_FOLDER] == "mine" and not place.exists()


def test_a_run_that_stops_keeps_the_fields_until_then(tmp_path):
    pack_forming(tmp_path / "forming.fmu", n_points=30, mesh_size=0.9, billet_length=12.0, speed=20.0)
    (tmp_path / "fre.yaml").write_text(
        "name: fre\ncommunication_step: 0.1\nstop_time: 0.6\n"  # 12 mm; the billet has 10.6 mm of stroke
        "components:\n  forming: {fmu: forming.fmu, start: {mu: 0.08}}\n"
    )
    done = CliRunner().invoke(
        app, ["simulate", str(tmp_path / "fre.yaml"), "-o", str(tmp_path / "run"), "--fields", "2"]
    )
    assert done.exit_code != 0
    run = Run.load(tmp_path / "run", stopped=True)
    assert not run.complete and run["forming.stroke"][-1] == pytest.approx(10.0)
    assert fields_of(tmp_path / "run")["fre"].strokes[-1] == pytest.approx(10.0, abs=0.2)
