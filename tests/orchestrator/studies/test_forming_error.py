"""The forming-error study: its measures against plain arithmetic, and the command on a small folder of one's own."""

from __future__ import annotations

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from forming.press import PressCurves, PressLevel
from friction_models.common import InputError
from friction_models.loads import DataSet
from orchestrator.cli.main import run
from orchestrator.comparison.level_runs import FormingLevel
from orchestrator.jobs.graph import JobResult
from orchestrator.report.study_pages.forming_error import forming_error_page
from orchestrator.studies.forming_error.result import FormingErrors, propagated
from orchestrator.studies.forming_error.study import FormingErrorStudy, Plan, run_name
from orchestrator.studies.forming_error.words import text_table as table
from orchestrator.studies.press_levels import chosen_press, press_level

REPEATS = 5
SCATTER = np.array([-0.02, -0.01, 0.0, 0.01, 0.02])


#: How fast the force rises [kN/mm], by tool temperature [degC].
RISES = {20.0: 100.0, 100.0: 80.0}


def press_folder(
    folder: Path,
    lubricants: tuple[str, ...],
    processes: tuple[str, ...] = ("fre", "bce"),
    T_tools: tuple[float, ...] = tuple(RISES),
    synthetic: bool = False,
) -> Path:
    """Press curves that rise in proportion to the stroke, five repeats each."""
    stroke = np.linspace(0.0, 0.45, 46)
    levels = []
    for lubricant in lubricants:
        for process in processes:
            for T_tool in T_tools:
                rise = RISES[T_tool]
                curves = pd.concat(
                    [
                        pd.DataFrame({"stroke": stroke, "force": rise * (1.0 + shift) * stroke, "repeat": k})
                        for k, shift in enumerate(SCATTER)
                    ]
                )
                file = f"{process}_{lubricant}_{T_tool:g}.csv"
                levels.append(PressLevel(process, T_tool, 5.0, lubricant, file, curves, synthetic))
    PressCurves(tuple(levels), {"process": {"mesh_size": 0.9}, "T_billet_degC": 20.0}).save(folder)
    return folder


def data_folder(folder: Path) -> Path:
    rng = np.random.default_rng(1)
    n, tests = 40, 9
    names = np.repeat([f"t{k}" for k in range(tests)], n)
    points = pd.DataFrame(
        {
            "test_id": names,
            "t": np.tile(np.arange(n) * 0.01, tests),
            "v_rel": rng.uniform(5.0, 200.0, n * tests),
            "T": rng.uniform(20.0, 200.0, n * tests),
            "sigma_n": rng.uniform(100.0, 2000.0, n * tests),
            "sd": np.tile(np.linspace(0.0, 60.0, n), tests),
            "psi": rng.uniform(1.0, 5.0, n * tests),
        }
    )
    points["mu"] = 0.09 - 1e-5 * points["sigma_n"] + rng.normal(0.0, 0.001, n * tests)
    DataSet(points, pd.DataFrame({"test_id": [f"t{k}" for k in range(tests)]}), {}).save(folder)
    return folder


def made_up_results(study: FormingErrorStudy) -> dict[str, JobResult]:
    """Runs whose force rises by 100 kN/mm, times a factor for each friction law."""
    factors = {"constant 0.04": 0.8, "constant 0.08": 1.2, "linear": 1.1, "polynomial": 0.95}
    stroke = np.linspace(0.0, 0.4, 41)
    timing = {"friction": 0.001, "forming": 0.9, "master": 0.1}
    found = {}
    for item in study.levels:
        assert item.file is not None
        found[item.job] = JobResult(item.job, {"file": item.file.name}, item.file.parent, 0.1)
        for friction in study.frictions:
            values = {
                "stroke": stroke.tolist(),
                "force": (100.0 * factors[friction.label] * stroke).tolist(),
                "tau_over_k": [0.1, 0.65 if friction.label == "constant 0.08" else 0.4],
                "outside": {"share": 0.25, "median_distance": 0.1},
                "timing": timing,
            }
            name = run_name(item, friction)
            found[name] = JobResult(name, values, Path(), 1.0)
    return found


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> FormingErrorStudy:
    folder = tmp_path_factory.mktemp("forming-error")
    data = data_folder(folder / "data")
    press = press_folder(folder / "press", ("oil", "wax"))
    return FormingErrorStudy.of(Plan.quick(), {"oil": data, "wax": data}, [("", press)])


def test_errors_are_those_of_plain_arithmetic(study: FormingErrorStudy) -> None:
    errors = FormingErrors.of(study, made_up_results(study))
    assert len(errors.runs) == 4 * 8 and errors.missing == 0
    # Force rises by 100 f against 100 or 80: |f - 1| and |1.25 f - 1| at half of the levels each.
    summary = errors.summary("linear", "oil", "fre")
    assert summary is not None
    are = np.array([0.1, 0.375])
    std = float(np.std(SCATTER, ddof=1))
    assert summary.max_force.mare == pytest.approx(are.mean(), rel=1e-3)
    assert summary.max_force.spread == pytest.approx(are.std(ddof=1), rel=1e-3)
    assert summary.max_force.mare_std == pytest.approx(np.hypot(1.1, 1.375) * std / 2, rel=1e-3)
    assert summary.work.mare == pytest.approx(are.mean(), rel=1e-3)
    assert summary.friction_share == pytest.approx(0.001)
    assert [round(c.mare, 3) for c in errors.changes() if c.friction == "linear"] == [
        round(are.mean() / 0.1 - 1, 3),  # against 0.8 and 1.0
        round(are.mean() / 0.35 - 1, 3),  # against 1.2 and 1.5
        round(are.mean() / 0.225 - 1, 3),  # against their mean
    ]
    text = table(errors)
    assert "forward rod extrusion, oil (2 levels)" in text and "synthetic" not in text


def test_data_of_ones_own_that_are_synthetic_are_called_so(study: FormingErrorStudy, tmp_path: Path) -> None:
    results = made_up_results(study)
    assert not FormingErrors.of(study, results).synthetic and not study.settings(results)["synthetic"]
    measured = {"data-oil": JobResult("data-oil", {"synthetic": True}, Path(), 1.0)}
    errors = FormingErrors.of(study, results | measured)
    assert errors.synthetic and study.settings(results | measured)["synthetic"]
    assert table(errors).startswith("synthetic measurements")
    press = press_folder(tmp_path / "press", ("oil",), ("bce",), (20.0,), synthetic=True)
    single = FormingErrorStudy.of(Plan.quick(), {"oil": data_folder(tmp_path / "data")}, [("", press)])
    errors = FormingErrors.of(single, made_up_results(single))
    assert errors.synthetic and not single.virtual
    # One level has no standard deviation, so none that changes.
    assert {c.spread for c in errors.changes()} == {None} and all(c.mare != -1.0 for c in errors.changes())
    manifest = {
        "versions": {"tribofmu": "0", "python": "3"},
        "jobs": {},
        "failed": [],
        "sources": {"sha256": ""},
    }
    page = forming_error_page(single, errors, manifest, {})
    assert "synthetic data" in page and "the user's tests and press curves" in page.replace("&#x27;", "'")
    assert "virtual laboratory" not in page


def test_uncertainty_of_a_change_is_that_of_repeated_experiments() -> None:
    rng = np.random.default_rng(3)
    press, std = np.array([100.0, 200.0, 300.0]), np.array([2.0, 3.0, 4.0])
    mine, constant = np.array([110.0, 230.0, 320.0]), np.array([140.0, 260.0, 390.0])

    def ratio(measured: np.ndarray) -> float:
        return float(np.abs(mine / measured - 1).mean() / np.abs(constant / measured - 1).mean())

    drawn = [ratio(press + std * rng.standard_normal(3)) for _ in range(4000)]
    assert propagated(ratio, press, std) == pytest.approx(np.std(drawn), rel=0.05)


def test_missing_runs_and_the_page(study: FormingErrorStudy) -> None:
    results = made_up_results(study)
    lost = next(name for name in results if name.endswith("-linear"))
    del results[lost]
    errors = FormingErrors.of(study, results)
    assert errors.missing == 1
    text = table(errors)
    assert (
        "1 runs are missing" in text
        and "(1 of 2 levels)" in text
        and "all lubricants (7 of 8 levels)" in text
    )
    # No law looks better because the level of another is missing: all are judged over the same ones.
    whole = FormingErrors.of(study, made_up_results(study))
    assert {s.max_force.levels for s in whole.summaries()} == {2, 8}
    assert {s.max_force.levels for s in errors.summaries()} == {1, 2, 7}
    assert len({s.levels for s in errors.summaries() if (s.lubricant, s.process) == ("oil", "fre")}) == 1
    manifest = {
        "versions": {"tribofmu": "0", "python": "3"},
        "jobs": {},
        "failed": [lost],
        "sources": {"sha256": "0" * 64},
    }
    page = forming_error_page(study, errors, manifest, {})
    for text in (
        "13 ± 4 %",
        "-52 %",
        "+18 %",
        "8 of 31 runs reach 60 % or more somewhere (constant 0.08)",
        "1 pairs have no result",
        "levels that any of them lacks are left out",
        "25 % in forward rod extrusion (median distance 0.10 trained ranges) and 25 % in backward cup",
        "polynomial (11.9 %) are no better than constant 0.04 (10.0 %)",
        "every run is below 1 %",
    ):
        assert text in page
    assert "synthetic data" not in page
    assert page.count("<figure>") == 6 + 2 * 4 + 2 + 2


def test_the_plan_of_the_paper() -> None:
    study = FormingErrorStudy.of(Plan.full(seed=3))
    runs = [job for job in study.jobs if job.name.startswith("run-")]
    assert len(runs) == 252 and study.virtual and study.synthetic({})
    assert len([job for job in study.jobs if job.name.startswith("press-")]) == 36
    assert {(item.level.T_tool, item.level.speed) for item in study.levels} >= {(20.0, 5.0), (100.0, 100.0)}
    # Constant friction knows no lubricant: half of its runs are the others'.
    distinct = {(json.dumps(job.inputs, sort_keys=True), job.needs) for job in runs}
    assert len(distinct) == 252 - 2 * 18


def test_one_virtual_level_depends_on_seed_and_level_only(tmp_path: Path) -> None:
    inputs = {
        "lubricant": "mos2",
        "process": "bce",
        "T_tool": 50.0,
        "speed": 50.0,
        "stroke": 0.2,
        "repeats": 2,
        "seed": 4,
    }
    values = press_level(inputs, {}, {}, tmp_path)
    curves = PressCurves.read(tmp_path / "press")
    (level,) = curves.levels
    assert (tmp_path / values["file"]).is_file() and curves.synthetic
    assert (level.lubricant, level.process, level.speed) == ("mos2", "bce", 50.0)
    first, second = level.repeats
    assert abs(first["force"].iloc[-1] / second["force"].iloc[-1] - 1.0) < 0.1
    assert first["force"].iloc[-1] != second["force"].iloc[-1]


def test_refused(tmp_path: Path) -> None:
    data, press = {"oil": tmp_path}, press_folder(tmp_path / "press", ("oil",))
    mine = [("", press)]
    with pytest.raises(InputError, match="--data without --press"):
        FormingErrorStudy.of(Plan.quick(), data, None)
    with pytest.raises(InputError, match="--press without --data"):
        FormingErrorStudy.of(Plan.quick(), None, mine)
    with pytest.raises(InputError, match="did you mean 'oils'"):
        FormingErrorStudy.of(Plan.quick(), {"oils": tmp_path}, mine)
    with pytest.raises(InputError, match="no curves of wax"):
        FormingErrorStudy.of(Plan.quick(), {"oil": tmp_path, "wax": tmp_path}, mine)
    with pytest.raises(InputError, match="stands twice"):
        FormingErrorStudy.of(Plan.quick(), data, [*mine, ("oil", press)])
    both = press_folder(tmp_path / "both", ("oil", "wax"))
    with pytest.raises(InputError, match="allowed: a single lubricant, or no name"):
        FormingErrorStudy.of(Plan.quick(), data, [("oil", both)])
    with pytest.raises(InputError, match="LUBRICANT=FOLDER"):
        chosen_press(["oil=nowhere"])
    assert chosen_press([f"lab={press}", str(press)]) == [("lab", press), ("", press)]


def test_the_command_on_data_of_ones_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    small = replace(Plan.quick(), models=("linear",), constants=(0.04,))
    monkeypatch.setattr(Plan, "quick", lambda seed=0: small)  # every friction law costs a compiler
    data, out = data_folder(tmp_path / "data"), tmp_path / "out"
    press = press_folder(tmp_path / "press", ("Oil 7",), ("bce",), (20.0,))
    words = [
        "study",
        "forming-error",
        "--quick",
        "--data",
        f"oil={data}",
        "--press",
        f"oil={press}",
        "-j",
        "1",
        "-o",
        str(out),
    ]
    assert run([*words, "--dry-run"]) == 0
    assert "6 jobs: 0 kept, 6 to do" in capsys.readouterr().out
    assert run(words) == 0
    assert "backward cup extrusion, oil (1 level)" in capsys.readouterr().out
    content = json.loads((out / "forming-error.json").read_text(encoding="utf-8"))
    rows = list(csv.DictReader((out / "runs.csv").open(encoding="utf-8")))
    assert len(rows) == len(content["runs"]) == 2
    assert not content["synthetic"] and {row["synthetic"] for row in rows} == {"False"}
    # More friction, more force; the trained law lies between 0.06 and 0.1.
    force = {row["friction"]: float(row["max_force_kN"]) for row in rows}
    assert force["constant 0.04"] < force["linear"]
    assert all(0.0 < float(row["friction_time_share"]) < 1.0 for row in rows)
    manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
    assert len(manifest["jobs"]) == 6 and manifest["settings"]["levels"][0]["press_sha256"]
    assert "Friction stress" in (out / "report.html").read_text(encoding="utf-8")
    assert run([*words, "--dry-run"]) == 0
    assert "6 kept, 0 to do" in capsys.readouterr().out
    # The folder is whole: without data and press curves it still gives the same page, wherever it lies.
    shutil.rmtree(data)
    shutil.rmtree(press)
    page = (out / "report.html").read_text(encoding="utf-8")
    copy = tmp_path / "copy"
    out.rename(copy)
    assert run(["report", str(copy)]) == 0
    assert (copy / "report.html").read_text(encoding="utf-8") == page


def test_a_level_goes_as_far_as_record_and_process_allow() -> None:
    stroke = np.linspace(0.0, 0.74, 75)
    record = PressLevel(
        "bce", 20.0, 5.0, "oil", "x.csv", pd.DataFrame({"stroke": stroke, "force": stroke, "repeat": 1})
    )
    assert FormingLevel.of(record, {}, 20.0, 0.1).stroke == pytest.approx(0.7)
    assert FormingLevel.of(record, {}, 0.3, 0.1).stroke == pytest.approx(0.3)
    long = PressLevel(
        "bce", 20.0, 5.0, "oil", "x.csv", pd.DataFrame({"stroke": 100 * stroke, "force": stroke, "repeat": 1})
    )
    assert 10.0 < FormingLevel.of(long, {}, 99.0, 0.1).stroke < 30.0
    for info, words in (
        ({"process": {"mesh_sise": 0.5}}, "did you mean 'mesh_size'"),
        ({"process": ["mesh_size"]}, "allowed: parameters by name"),
        ({"process": {"mesh_size": "fine"}}, "mesh_size"),
        ({"T_billet_degC": "cold"}, "T_billet"),
    ):
        with pytest.raises(InputError, match=words) as refused:
            FormingLevel.of(record, info, 20.0, 0.1)
        assert isinstance(info.get("process"), list) or str(refused.value).startswith("press level x.csv: ")
