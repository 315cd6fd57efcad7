"""Compression tests predicted in a closed loop: friction FMU, twin FMU, a source of force, speed and temperature."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fmus import pack
from fmus.runtime.fmu_files import describe
from fmus.runtime.friction_names import FrictionNames
from friction_models import ConstantFriction
from friction_models.common import InputError
from friction_models.loads import DataSet
from orchestrator.cli.commands import predicting_sct
from orchestrator.prediction.closed_loop import sct_system
from orchestrator.prediction.predict_sct import SctPrediction, SctPredictions, predict_sct
from orchestrator.prediction.schedule import SctSchedule, TestRow, held_out_schedules, planned_schedules
from orchestrator.report import write_report
from sct_twin.twin.process import SctProcess
from sct_twin.twin.process_uncertainty import process_uncertainties
from tests.fmus.memory_models import AGE_0, B, C, D, K, R, ageing_bytes
from tests.orchestrator.native_fmus import Real, native_fmu

RA, F_SET = 0.6, 200e3
PLAN: TestRow = {
    "test_id": "p1",
    "F_set": F_SET,
    "v_set": 100.0,
    "sd_set": 8.0,
    "T_tool": 60.0,
    "ramp": 0.03,
    "Ra": RA,
}


@pytest.fixture(scope="module")
def constant(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack(ConstantFriction(0.08), tmp_path_factory.mktemp("constant") / "constant.fmu")


@pytest.fixture(scope="module")
def ageing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("ageing")
    (folder / "model.onnx").write_bytes(ageing_bytes())
    return pack(folder / "model.onnx", folder / "ageing.fmu")


@pytest.fixture(scope="module")
def planned(constant: Path, tmp_path_factory: pytest.TempPathFactory) -> SctPrediction:
    out = tmp_path_factory.mktemp("planned")
    return predict_sct(constant, [SctSchedule.from_plan(PLAN)], out, jobs=1).tests[0]


def test_constant_friction_gives_what_the_process_gives_when_driven_alike(planned: SctPrediction) -> None:
    schedule, run = planned.schedule, planned.run
    assert planned.errors() is None
    assert (run["friction.mu"] == 0.08).all()
    html = write_report(run.folder).read_text(encoding="utf-8")
    assert "Loads and coefficient of friction of the contact." in html
    assert run["twin.sd"][-1] == pytest.approx(PLAN["sd_set"], rel=1e-9)
    assert run["inputs.v_slide"][1] < 5.0  # the plate starts from rest
    process = SctProcess(F_max=F_SET, T_tool=60.0, speed=float(schedule.v_slide.max()))
    step = float(run.time[1])
    for v in run["inputs.v_slide"][1:]:
        loads = process.advance(step, F_SET, v, 60.0, 0.08)
    assert run["twin.T"][-1] == pytest.approx(loads.T, rel=1e-9)
    assert run["twin.sigma_n"][-1] == pytest.approx(loads.sigma_n, rel=1e-9)
    # The table has the columns that the twin states with a measured test, for the same steps.
    n = len(run.time) - 1
    inputs = [np.full(n, value) for value in (step, F_SET, 60.0, 0.08)]
    known = process_uncertainties(process, *inputs[:2], run["inputs.v_slide"][1:], *inputs[2:])
    frame = planned.frame()
    for name, values in known.items():
        np.testing.assert_allclose(frame[name], values[:-1], rtol=1e-9, err_msg=name)


def test_memory_temperature_and_roughness_act_in_the_loop(ageing: Path, tmp_path: Path) -> None:
    found = predict_sct(ageing, [SctSchedule.from_plan(PLAN)], tmp_path, jobs=1)
    frame, run = found.frame(), found.tests[0].run
    v, T, dt = frame["v_rel"].to_numpy(), frame["T"].to_numpy(), run.time[1]
    age = np.empty(len(v))
    for k in range(len(v)):  # the state advances in the step whose mu the twin then uses
        before = AGE_0 if k == 0 else age[k - 1]
        age[k] = before + dt * (1.0 - v[k] * before / D)
    np.testing.assert_allclose(frame["mu_model"], B + K * age + R * RA + C * T, rtol=1e-9)
    assert T[-1] > 65.0
    assert (tmp_path / "predicted.csv").is_file() and (tmp_path / "runs" / "p1" / "manifest.json").is_file()
    assert "-" in found.table() and found.summary() is None
    html = write_report(tmp_path).read_text(encoding="utf-8")
    assert "ageing: one test predicted" in html and "Nobody has run them" in html
    (tmp_path / "prediction.json").write_text("{}")
    with pytest.raises(InputError, match="not a complete prediction"):
        write_report(tmp_path)


def test_a_measured_test_is_driven_as_it_was_and_compared(
    planned: SctPrediction, constant: Path, tmp_path: Path
) -> None:
    """Points of the first prediction, with more friction, stand for a measurement."""
    frame = planned.frame()
    sd = np.arange(0.1, 7.9, 0.1)
    points = pd.DataFrame(
        {name: np.interp(sd, frame["sd"], frame[name]) for name in ("t", "v_rel", "T", "sigma_n", "psi")}
    )
    points.insert(0, "test_id", "m1")
    t = planned.run.time
    points = points.assign(sd=sd, t=np.interp(sd, planned.run["twin.sd"], t), mu=0.08 + 0.004, F_n=200e3)
    tests = pd.DataFrame([{"test_id": "m1", "T_tool": 60.0, "role": "test"}])
    other = points.assign(test_id="m2")
    data = DataSet(
        pd.concat([points, other]),
        pd.concat([tests, tests.assign(test_id="m2", role="train")]),
        {"synthetic": True},
    )
    schedules = held_out_schedules(data)
    assert [s.test_id for s in schedules] == ["m1"]
    assert [s.test_id for s in held_out_schedules(data, ["m2"])] == ["m2"]
    assert schedules[0].distance == pytest.approx(sd[-1], rel=1e-12)
    found = predict_sct(constant, schedules, tmp_path, label="0.08", jobs=1)
    errors = found.tests[0].errors()
    assert errors is not None
    assert errors["mu_bias"] == pytest.approx(-0.004, rel=1e-6)
    assert errors["mu_rms"] == pytest.approx(0.004, rel=1e-6)
    assert errors["T_rms"] < 1.0  # the same friction, force and motion
    assert "synthetic" in found.table() and "over 1 tests: mu RMS 0.0040" in found.table()
    frame = found.frame()
    inside = frame["sd"].between(sd[0], sd[-1])
    assert (frame.loc[inside, "mu"] == 0.084).all() and frame.loc[~inside, "mu"].isna().all()
    html = write_report(tmp_path).read_text(encoding="utf-8")
    assert "0.08: one test predicted, mu within 0.0040 (RMS)" in html and "synthetic data" in html
    # A test of the data set whose force is not kept is driven by pressure and contact area.
    area = float(planned.run["inputs.F_n"][0] / planned.run["twin.sigma_n"][0])
    row = {"test_id": "m1", "T_tool": 60.0, "contact_area": area}
    again = SctSchedule.from_points(points.drop(columns="F_n"), row)
    assert again.F_n == pytest.approx(200e3, rel=1e-9)


def test_what_was_predicted_is_not_computed_again(constant: Path, tmp_path: Path) -> None:
    schedule = SctSchedule.from_plan({**PLAN, "sd_set": 3.0})
    predict_sct(constant, [schedule], tmp_path, jobs=1)
    before = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("results.nc")}
    assert len(before) == 1
    predict_sct(constant, [schedule], tmp_path, jobs=1)
    assert {p: p.stat().st_mtime_ns for p in tmp_path.rglob("results.nc")} == before
    predict_sct(constant, [schedule], tmp_path, twin={"upsetting_mu": 0.12}, jobs=1)
    assert {p: p.stat().st_mtime_ns for p in tmp_path.rglob("results.nc")} != before


def test_a_table_over_time(constant: Path, tmp_path: Path) -> None:
    table = tmp_path / "test.csv"
    table.write_text("t [s],F_n [N],v_slide [mm/s]\n2.0,100000,0\n2.1,100000,50\n2.3,120000,50\n")
    schedule = SctSchedule.from_file(table, {"test_id": "test", "T_tool": 80.0})
    assert schedule.distance == pytest.approx(12.5)
    assert schedule.duration == pytest.approx(0.3)
    system = sct_system(constant, schedule, tmp_path / "fmus", twin={"bore": 20.0, "tip": 9.0})
    start = system.components["twin"].start
    assert start["bore"] == 20.0 and start["F_max"] == pytest.approx(110e3) and start["T_tool"] == 80.0
    assert system.steps == 150  # 0.1 mm at the highest speed


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"F_set": None}, "'F_set'"),
        ({"v_set": 0.0}, "v_set = 0 mm/s"),
        ({"ramp": 1.0}, "ramp = 1 s"),
        ({"T_tool": "warm"}, "T_tool = 'warm', allowed: a finite number"),
        ({"F_set": -5.0}, r"F_n = -5\.0 N in row 0, allowed: 0 to 1e\+08 N"),
        ({"test_id": "../../away"}, "a name that can be a file name"),
        ({"sd_set": 0.2, "ramp": 0.0}, "slides 0.2 mm, allowed: at least 0.5 mm"),
    ],
)
def test_plans_that_cannot_be(change: TestRow, words: str, tmp_path: Path) -> None:
    pd.DataFrame([{**PLAN, **change}]).to_csv(tmp_path / "plan.csv", index=False)
    with pytest.raises(InputError, match=words):
        planned_schedules(tmp_path / "plan.csv")


def test_the_command(constant: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from typer.testing import CliRunner

    app = predicting_sct.app
    pd.DataFrame([{**PLAN, "sd_set": 3.0, "ramp": 0.01}]).to_csv(tmp_path / "plan.csv", index=False)
    said = CliRunner().invoke(
        app, [str(constant), "--plan", str(tmp_path / "plan.csv"), "-o", str(tmp_path / "out"), "-j", "1"]
    )
    assert said.exit_code == 0, said.output
    assert "p1" in said.output and "0.0800" in said.output
    both = CliRunner().invoke(app, [str(constant), "-o", str(tmp_path / "out2")])
    assert isinstance(both.exception, InputError)
    assert "0 of --data, --plan and --inputs given" in str(both.exception)
    assert not (tmp_path / "out2").exists()


def test_an_fmu_of_others_runs_in_the_loop(tmp_path: Path) -> None:
    fmu = native_fmu(
        tmp_path / "theirs.fmu",
        [Real("theta", "input", 300.0, "K"), Real("p", "input", 1e8, "Pa"), Real("cof", "output")],
        outputs="V(cof) = 0.05 + 1e-4 * (V(theta) - 273.15) + 1e-12 * V(p);",
    )
    names = FrictionNames.of(describe(fmu), {"T": "theta", "sigma_n": "p", "mu": "cof"})
    schedule = SctSchedule.from_plan(PLAN)
    found = predict_sct(fmu, [schedule], tmp_path / "out", names=names, jobs=1)
    frame = found.frame()
    expected = 0.05 + 1e-4 * frame["T"] + 1e-6 * frame["sigma_n"]
    np.testing.assert_allclose(frame["mu_model"], expected, rtol=1e-9)
    assert found.tests[0].outside_domain() is None
    assert "not known" in write_report(tmp_path / "out").read_text(encoding="utf-8")


def test_a_force_in_another_unit_is_named_with_its_file(tmp_path: Path) -> None:
    table = pd.DataFrame({"t": [0.0, 0.5, 1.0], "F_n": [90.0, 90.0, 90.0], "v_slide": [10.0, 10.0, 10.0]})
    table.to_csv(tmp_path / "kilo.csv", index=False)
    with pytest.raises(InputError, match=r"kilo\.csv: test k: F_n is 90 N at its highest, allowed: 1000 to"):
        SctSchedule.from_file(tmp_path / "kilo.csv", {"test_id": "k", "T_tool": 20.0})


@pytest.mark.parametrize(
    ("twin", "words"),
    [
        (
            {"tool_material": "1.2379"},
            r"unknown parameter of the twin 'tool_material'; allowed: .*did you mean 'material'",
        ),
        ({"mesh_size": "fine"}, r"parameter of the twin: mesh_size = 'fine'; allowed: a number"),
    ],
)
def test_parameters_that_the_twin_does_not_take(
    twin: dict[str, object], words: str, constant: Path, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        predict_sct(constant, [SctSchedule.from_plan(PLAN)], tmp_path / "out", twin=twin, jobs=1)


def test_a_contact_hotter_than_the_data_of_the_workpiece_is_said(planned: SctPrediction) -> None:
    hottest = float(planned.run["twin.T"].max())
    for known, said in ((hottest + 1.0, 0), (hottest - 1.0, 1), (None, 0)):
        found = SctPredictions("constant", [planned], known)
        assert len(found.remarks()) == said
        assert found.table().count("the data of the workpiece end at") == said
