"""Studies of coupling: lag on a process whose answer to lag can be written down, exceedances on recorded loads."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from fmus.runtime.errors import SimulationError
from forming import BackwardCupExtrusion
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, DataSet, FloatArray
from friction_models.models.domain import Domain
from orchestrator import Master, Run, System
from orchestrator.cli.main import run as command
from orchestrator.comparison.level_runs import FormingLevel
from orchestrator.jobs.graph import JobResult
from orchestrator.jobs.job import Inputs
from orchestrator.report.study_pages.extrapolation import extrapolation_page
from orchestrator.report.study_pages.lag import lag_page
from orchestrator.studies import forming_jobs as coupled
from orchestrator.studies import models
from orchestrator.studies.contact import Contact, reference_areas
from orchestrator.studies.extrapolation import result as extrapolation
from orchestrator.studies.extrapolation import words
from orchestrator.studies.extrapolation.jobs import reduce
from orchestrator.studies.extrapolation.study import ExtrapolationPlan, ExtrapolationStudy
from orchestrator.studies.lag.result import evaluate
from orchestrator.studies.lag.study import LagPlan, LagStudy
from orchestrator.studies.lag.words import text_table
from tests.friction_models.made_up import campaign
from tests.orchestrator.native_fmus import Real, native_fmu

#: mu grows by this much a millimetre of stroke, the force is FORCE * mu.
SLOPE, FORCE = 0.01, 1000.0
STEPS, STROKE = (0.1, 0.2, 0.4), 2.0


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pair")
    loads = [Real(f"x[{k}]", "output", 0.0) for k in (1, 2)]
    press = [Real("active[1]", "output", 1.0), Real("active[2]", "output", 1.0), Real("stroke", "output"), Real("force", "output"),
             Real("work", "output"), Real("max_tau_over_k", "output")]  # fmt: skip
    return {
        "forming": native_fmu(
            folder / "forming.fmu",
            [*loads, *(Real(f"mu[{k}]", "input", 0.05) for k in (1, 2)), *press],
            outputs=f"V(x_1) = V(x_2) = V(stroke) = t; V(force) = {FORCE} * V(mu_1);",
            step="V(work) += h * 1000.0 * V(mu_1);",
        ),
        "friction": native_fmu(
            folder / "friction.fmu",
            [
                *(Real(f"x[{k}]", "input") for k in (1, 2)),
                *(Real(f"mu[{k}]", "output", 0.05) for k in (1, 2)),
            ],
            outputs=f"V(mu_1) = V(mu_2) = 0.05 + {SLOPE} * V(x_1);",
        ),
    }


@pytest.fixture(scope="module")
def lag_results(pair: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, JobResult]:
    """Return what the jobs of a small study give, with the pair in place of solver and model."""
    place = tmp_path_factory.mktemp("lag")

    def simulate(inputs: Inputs, friction: Path, folder: Path) -> Run:
        step = inputs["step"]
        content = {
            "communication_step": step,
            "stop_time": inputs["level"]["stroke"],
            "components": {n: {"fmu": str(pair[n])} for n in ("friction", "forming")},
            "connections": ["forming.x -> friction.x", "friction.mu -> forming.mu"],
        }
        if inputs["mode"] == "jacobi" and step == 0.2:
            raise SimulationError("component 'forming' failed: stopped at stroke 0.3 mm: no equilibrium")
        return Master(System.from_dict(content), inputs["mode"], inputs["tolerance"]).run(folder)

    patch = pytest.MonkeyPatch()
    patch.setattr(coupled, "simulate_level", simulate)
    model = JobResult("model", {"fmu": "friction.fmu", "synthetic": True}, place, 1.0)
    results = {}
    try:
        for job in study().jobs:
            if job.function.endswith("run_coupled"):
                folder = place / job.name
                folder.mkdir()
                values = coupled.run_coupled(job.inputs, {}, {"model": model}, folder)
                results[job.name] = JobResult(job.name, json.loads(json.dumps(values)), folder, 1.0)
    finally:
        patch.undo()
    return results


def study() -> LagStudy:
    return LagStudy.of(LagPlan(("polynomial",), ("fre",), STROKE, steps=STEPS))


def test_lag_is_one_step_and_two_steps(lag_results: dict[str, JobResult]) -> None:
    values = evaluate(study(), lag_results)
    rows = {(r["mode"], r["step_mm"]): r for r in values["rows"]}
    work = FORCE * (0.05 * STROKE + SLOPE * STROKE**2 / 2)
    for step in STEPS:
        one = rows["gauss_seidel", step]
        # mu of the loads a step earlier: the force is lower by FORCE * SLOPE * step all the way.
        assert one["lag"]["rms_kN"] == pytest.approx(FORCE * SLOPE * step, rel=0.12)
        assert one["lag"]["mu_mean"] == pytest.approx(SLOPE * step, rel=1e-6)
        assert one["lag"]["work_pct"] == pytest.approx(-100 * FORCE * SLOPE * step * STROKE / work, rel=0.1)
        assert (
            rows["iterated", step]["lag"]["rms_kN"] == 0.0
            and rows["iterated", step]["repetitions_mean"] > 1.0
        )
    two = rows["jacobi", 0.4]["lag"]
    assert two["mu_mean"] == pytest.approx(1.8 * SLOPE * 0.4, rel=0.02), "two steps, but one in the first"
    assert rows["iterated", 0.1]["to_finest"]["rms_kN"] == 0.0
    assert "no equilibrium" in rows["jacobi", 0.2]["failed"] and "lag" not in rows["jacobi", 0.2]
    summary = {e["mode"]: e for e in values["summary"]}
    assert (summary["jacobi"]["runs"], summary["jacobi"]["failed"]) == (2, 1)
    assert summary["gauss_seidel"]["mu_mean_per_mm"] == pytest.approx(SLOPE, rel=1e-6)
    assert "gauss_seidel" in text_table(values)


def test_lag_page_names_what_failed(lag_results: dict[str, JobResult]) -> None:
    page = lag_page(evaluate(study(), lag_results))
    assert "One-step lag changes the forming work" in page and "Runs that broke off" in page
    assert "FRE (2 mm of stroke)" in page and 'id="chart-curves"' in page
    # Without the finest iterated run the lag at the other steps is still there.
    rest = {k: v for k, v in lag_results.items() if not k.endswith("iterated-0.1mm")}
    page = lag_page(evaluate(study(), rest))
    assert 'id="chart-cost"' in page and 'id="chart-finest"' not in page
    empty = lag_page(evaluate(study(), {}))
    assert "no pair of runs to compare" in empty and "not run" in empty


@pytest.mark.parametrize(
    "cause", ["MemoryError: ", "OSError: No space left on device", "the solver process is gone"]
)
def test_a_fault_of_the_machine_is_no_result(
    cause: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def simulate(inputs: Inputs, friction: Path, folder: Path) -> Run:
        folder.mkdir()
        (folder / "manifest.json").write_text("{}", encoding="utf-8")  # the steps until then are there
        raise SimulationError(f"component 'forming' failed at t = 1 s in DoStep: {cause}")

    monkeypatch.setattr(coupled, "simulate_level", simulate)
    (job,) = (j for j in study().jobs if j.name.endswith("jacobi-0.1mm"))
    model = JobResult("model", {"fmu": "friction.fmu"}, tmp_path, 1.0)
    with pytest.raises(SimulationError, match=cause):
        coupled.run_coupled(job.inputs, {}, {"model": model}, tmp_path)


def test_steps_of_the_lag_study_divide_the_longest() -> None:
    with pytest.raises(InputError, match=r"0\.3 mm does not divide the longest, 0\.8 mm"):
        LagPlan(steps=(0.3, 0.8))
    with pytest.raises(InputError, match="did you mean 'polynomial'"):
        LagPlan(models=("polynomal",))
    assert evaluate(LagStudy(LagPlan(lubricant="oil"), ()), {})["settings"]["lubricant"] == "oil"
    names = [job.name for job in LagStudy.of(LagPlan()).jobs]
    assert len(names) == len(set(names)) and sum("-iterated-" in n for n in names) == 2 * 2 * 5


# --- extrapolation ------------------------------------------------------------------------------------


def recorded(sigma: float, mu: float) -> Run:
    """Return a run of two steps and three markers, of which the last touches nothing; one presses with `sigma`."""
    loads = {"v_rel": 100.0, "T": 50.0, "sigma_n": 1000.0, "sd": 1.0, "psi": 1.2}
    values: dict[str, FloatArray] = {f"forming.{n}": np.full((3, 3), x) for n, x in loads.items()}
    values["forming.sigma_n"][:, 1] = sigma
    values["forming.active"] = np.tile([1.0, 1.0, 0.0], (3, 1))
    values["friction.mu"] = np.full((3, 3), mu)
    values |= {"forming.stroke": np.array([0.0, 0.1, 0.2]), "forming.force": np.array([0.0, 5.0, 100.0 * mu])}
    values |= {"forming.work": np.array([0.0, 1.0, 1000.0 * mu]), "forming.max_tau_over_k": np.full(3, 0.3)}
    return Run(Path("run"), {"status": "ok"}, np.arange(3.0), values, {})


def test_what_is_outside_by_load_and_by_work(monkeypatch: pytest.MonkeyPatch) -> None:
    box = Domain((0.0, 0.0, 500.0, 0.0, 1.0), (500.0, 300.0, 1500.0, 60.0, 3.0))
    runs = {"clamp": recorded(2000.0, 0.1), "extrapolate": recorded(2000.0, 0.12)}
    monkeypatch.setattr(extrapolation, "run_of", lambda result: runs.get(result.name.rpartition("-")[2]))
    monkeypatch.setattr(extrapolation, "reference_areas", lambda level: np.array([1.0, 3.0, 90.0]))
    small = ExtrapolationStudy.of(ExtrapolationPlan(("linear",), ("fre",), 0.2, conditions=((20.0, 5.0),)))
    facts = {
        "domain": box.to_dict(),
        "points": 10,
        "tests": 2,
        "mae_test": 0.01,
        "rmse_test": 0.02,
        "synthetic": True,
    }
    results = {}
    for job in small.jobs:
        if job.function.endswith("train_model"):
            results[job.name] = JobResult(job.name, facts, Path(), 1.0)
        elif job.function.endswith("run_coupled"):
            broke = "-reduced-extrapolate" in job.name
            said = "the solver gave up" if broke else ""
            made = JobResult(job.name, {"failed": said, "steps": 2, "timing": {}}, Path(), 1.0)
            results[job.name] = made
    values = json.loads(json.dumps(extrapolation.evaluate(small, results)))
    run = next(r for r in values["runs"] if (r["data"], r["rule"]) == ("all", "clamp"))
    # The marker outside stands for three times the area of the other one and presses twice as hard.
    assert run["states"] == 4 and run["outside"] == 0.75
    assert run["outside_work"] == pytest.approx(6 / 7)
    assert run["friction_work_J"] == pytest.approx(2 * 1e-3 * 0.1 * 100.0 * 1.2 * (1000.0 + 3 * 2000.0))
    sigma = next(i for i in run["loads"] if i["load"] == "sigma_n")
    assert sigma["above"]["share"] == 0.75 and sigma["above"]["median"] == 500.0
    assert (
        sigma["above"]["median_ranges"] == run["distance"]["median"] == 0.5 and sigma["below"]["share"] == 0.0
    )
    assert all(
        i[side]["share"] == 0.0 for i in run["loads"] if i["load"] != "sigma_n" for side in ("below", "above")
    )
    pairs = {p["data"]: p for p in values["pairs"]}
    assert pairs["all"]["work_J_pct"] == pytest.approx(20.0) and pairs["reduced"]["failed"] == ["extrapolate"]
    page = extrapolation_page(values)
    assert "the solver gave up" in page and "synthetic data" in page
    assert "86 to 86 % of the friction work with all tests" in page
    assert "broke off" in words.text_table(values)
    for run in runs.values():
        run.values["forming.active"][:] = 0.0
    oil = ExtrapolationStudy(replace(small.plan, lubricant="oil"), ())
    untouched = extrapolation.evaluate(oil, results)
    assert untouched["settings"]["lubricant"] == "oil" and not untouched["runs"]
    untouched = extrapolation.evaluate(small, results)
    assert [p["data"] for p in untouched["pairs"]] == ["reduced"], "no contact, nothing to compare"
    assert "no contact" in words.text_table(untouched)


def test_area_of_a_marker_gives_the_friction_work_of_the_solver() -> None:
    level = FormingLevel("bce", 50.0, 50.0, 0.0)
    areas = reference_areas(level)
    process = BackwardCupExtrusion(**level.numbers)
    mu, steps, step = np.full(process.n_points, 0.08), 20, 0.05
    process.start(0.08)
    # Bottom, side and face of the billet, all around.
    radius, length = process.marker_position[:, 0].max(), np.ptp(process.marker_position[:, 1])
    assert areas.sum() == pytest.approx(2.0 * np.pi * radius * (radius + length), rel=1e-9)
    assert areas.max() > 100.0 * areas.min(), "equal areas would not do"
    rows: dict[str, list[Any]] = {name: [] for name in (*LOAD_NAMES, "active")}
    for _ in range(steps + 1):
        for name, column in zip(LOAD_NAMES, process.loads().T):
            rows[name].append(column)
        rows["active"].append(process.active.astype(float))
        done = process.simulation.state.energy.friction
        process.set_mu(mu)
        process.advance(step)
    values: dict[str, FloatArray] = {f"forming.{name}": np.array(found) for name, found in rows.items()}
    values["friction.mu"] = np.tile(mu, (steps + 1, 1))
    run = Run(Path("run"), {"status": "ok"}, np.linspace(0.0, steps * step / 50.0, steps + 1), values, {})
    work = Contact.of(run, areas).work
    # Contact loads of the start of each step, while the contact still grows.
    assert work.sum() == pytest.approx(1e-3 * done, rel=0.12)
    assert work.sum() < 1e-3 * done


def test_reduced_training_data_keep_the_held_out_tests(tmp_path: Path) -> None:
    points = campaign(tests=40, points=6)
    names = points["test_id"].unique()
    tests = pd.DataFrame(
        {"test_id": names, "role": ["test" if k % 4 == 0 else "train" for k in range(len(names))]}
    )
    DataSet(points, tests, {"synthetic": True}).save(tmp_path / "dataset")
    whole = JobResult("data-x", {"dataset": "dataset"}, tmp_path, 1.0)
    (tmp_path / "out").mkdir()
    made = reduce({}, {}, {"data-x": whole}, tmp_path / "out")
    kept = DataSet.load(tmp_path / "out" / "dataset")
    assert kept.select("test").points["test_id"].nunique() == 10
    train = kept.select("train").points
    assert 4 <= made["train"] == train["test_id"].nunique() < 30
    assert (
        train.groupby("test_id")["sigma_n"].median().max()
        <= made["limits"]["sigma_n"]
        < points["sigma_n"].max()
    )


def test_a_model_is_trained_on_some_tests_and_packed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    packed: list[str] = []
    monkeypatch.setattr(
        "fmus.pack",
        lambda model, path, fmi, arrays: packed.append(
            f"{model.family} {Path(path).name} {fmi}{' arrays' * arrays}"
        ),
    )
    campaign(tests=8, points=6).to_csv(tmp_path / "points.csv", index=False)
    ids = pd.read_csv(tmp_path / "points.csv", dtype={"test_id": str})["test_id"].unique()[:3].tolist()
    job = models.model_job("linear", tmp_path, tests=ids)
    made = models.train_model(job.inputs, job.files, {}, tmp_path)
    assert (made["tests"], made["points"], made["mae_test"]) == (3, 18, None)
    assert packed == ["linear friction.fmu 3.0 arrays"] and (tmp_path / "model" / "model.onnx").is_file()
    assert set(made["domain"]) == set(LOAD_NAMES)
    with pytest.raises(InputError, match="none of the tests"):
        models.train_model({**job.inputs, "tests": ["nowhere"]}, job.files, {}, tmp_path)


def test_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("lag", "extrapolation"):
        assert command(["study", name, "--help"]) == 0
        said = capsys.readouterr().out
        assert all(family in said for family in models.ADVANCED)
        assert command(["study", name, "--quick", "--dry-run", "-o", str(tmp_path / name)]) == 0
        assert "jobs" in capsys.readouterr().out
    assert command(["study", "lag", "--dry-run", "--process", "fra", "-o", str(tmp_path / "x")]) == 2
    assert "'fre'" in capsys.readouterr().err


@pytest.mark.parametrize("twice", ["--model linear", "--process fre", "--step 0.2"])
def test_a_value_given_twice_names_the_option(
    tmp_path: Path, twice: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["study", "lag", *twice.split(), *twice.split(), "--dry-run", "-o", str(tmp_path / "lag")]
    assert command(words) == 2
    assert f"{twice}: given twice; allowed: each value once" in capsys.readouterr().err
