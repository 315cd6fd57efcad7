"""The whole loop as a new user meets it: every command of the chain, and the demo, on one campaign with a hidden effect.

By day the demo does it all, and tutorials run the commands on data that are there. The tests of the night build on each other, in
this order: each works with what the ones before wrote.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models import load_model
from friction_models.common import grown
from friction_models.common.folders import DEMO
from friction_models.loads import LOAD_NAMES, DataSet
from orchestrator import Run
from orchestrator.demo import Demo, Level, Scenario, printed_summary
from orchestrator.report import write_report
from sct_twin.virtual_lab.plans import complete_plan
from tests.acceptance.conftest import short_plan

pytestmark = pytest.mark.slow

Tribofmu = Callable[..., str]
HIDDEN, SEED = "stribeck", 13
#: Tests that train, and tests that are held out.
TRAIN, HELD = 14, 3
SYSTEM = """
name: short extrusion
communication_step: 0.04
stop_time: 1.2
components:
  friction: {fmu: linear.fmu, start: {clamp_to_domain: true}}
  forming: {fmu: forming.fmu}
connections:
  - forming.v_rel -> friction.v_rel
  - forming.T -> friction.T
  - forming.sigma_n -> friction.sigma_n
  - forming.sd -> friction.sd
  - forming.psi -> friction.psi
  - friction.mu -> forming.mu
"""


def read(path: Path) -> dict[str, object]:
    content: dict[str, object] = json.loads(path.read_text(encoding="utf-8"))
    return content


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("new-user")
    short_plan(folder / "plan.csv", "reduced-27+10", SEED, HELD, sliding=30.0)
    return folder


@pytest.mark.nightly
def test_lab_ingest_twin(home: Path, tribofmu: Tribofmu) -> None:
    options = ["--plan", home / "plan.csv", "--hidden", HIDDEN, "--seed", SEED, "--jobs", 1]
    assert "synthetic" in tribofmu("lab", *options, "-o", home / "lab")
    assert f"{TRAIN + HELD} tests" in tribofmu("ingest", home / "lab", "-o", home / "campaign")
    assert not (home / "campaign" / "truth.json").exists()
    assert "synthetic data set" in tribofmu("twin", home / "campaign", "-o", home / "data", "--jobs", 1)
    data = DataSet.load(home / "data")
    assert data.synthetic
    assert {k: len(v.tests) for k in ("train", "test") if (v := data.select(k)).tests is not None} == {
        "train": TRAIN,
        "test": HELD,
    }
    assert len(list((home / "data" / "twin").glob("*.nc"))) == TRAIN + HELD


@pytest.mark.nightly
def test_train_evaluate_predict(home: Path, tribofmu: Tribofmu) -> None:
    data = home / "data"
    for family in ("linear", "polynomial"):
        assert "synthetic" in tribofmu("train", family, "--data", data, "-o", home / family)
    tribofmu("evaluate", home / "linear", "--data", data, "--json", home / "linear.json")
    tribofmu("predict", home / "linear", "--data", data, "-o", home / "predicted.csv")
    table = pd.read_csv(home / "predicted.csv")
    rmse = float(np.sqrt(np.mean((table["mu_model"] - table["mu"]) ** 2)))
    assert rmse == pytest.approx(read(home / "linear.json")["overall"]["rmse"], rel=1e-6)  # type: ignore[index]


@pytest.mark.nightly
def test_diagnose_names_the_hidden_effect(home: Path, tribofmu: Tribofmu) -> None:
    out = [
        "--json",
        home / "diagnosis.json",
        "--report",
        home / "diagnosis.html",
        "--plan",
        home / "next.csv",
    ]
    said = tribofmu("diagnose", "--data", home / "data", "--model", home / "linear", *out)
    assert "synthetic" in said
    found = read(home / "diagnosis.json")
    assert found["synthetic"] is True
    assert found["verdict"] in {"explained", "ambiguous"}
    assert found["effects"] == [HIDDEN]
    assert HIDDEN in found["confusion_set"]  # type: ignore[operator]
    html = (home / "diagnosis.html").read_text(encoding="utf-8")
    assert HIDDEN in html and "synthetic data" in html
    proposed = complete_plan(
        pd.read_csv(home / "next.csv"), SEED, "next.csv"
    )  # what `lab --plan` does with it
    assert 1 <= len(proposed) == len(set(proposed["test_id"]))


@pytest.mark.nightly
def test_refine_lets_the_error_fall_on_unseen_tests(home: Path, tribofmu: Tribofmu) -> None:
    data = home / "data"
    tribofmu("refine", "--data", data, "--model", home / "linear", "--add", HIDDEN, "-o", home / "better")
    tribofmu("evaluate", home / "better", "--data", data, "--json", home / "better.json")
    assert read(home / "better" / "card.json")["data"]["synthetic"] is True  # type: ignore[index]
    errors = {m: read(home / f"{m}.json")["roles"]["test"] for m in ("linear", "better")}  # type: ignore[index]
    assert errors["better"]["rmse"] < errors["linear"]["rmse"]
    assert errors["better"]["mae"] < errors["linear"]["mae"]


@pytest.mark.nightly
def test_compare_models_on_held_out_tests(home: Path, tribofmu: Tribofmu) -> None:
    tribofmu("pack", home / "linear", "-o", home / "scalar.fmu")
    models = [home / "linear", home / "better", home / "scalar.fmu", "0.08"]
    shown = tribofmu("compare", "--models", *models, "--data", home / "data", "--json", home / "compare.json")
    assert "synthetic" in shown
    result = read(home / "compare.json")
    assert result["tests"] == HELD
    assert result["ranking"][0] == "better" and result["ranking"][-1] == "0.08"  # type: ignore[index]
    # The FMU is the model, held-out points outside the trained domain moved to its edge.
    held, linear = DataSet.load(home / "data").select("test"), load_model(home / "linear")
    loads = held.points[list(LOAD_NAMES)].to_numpy()
    error = linear.predict(linear.domain.clamp(loads)) - held.points["mu"].to_numpy()
    rmse = {name: m["rmse"] for name, m in result["models"].items()}  # type: ignore[attr-defined]
    assert rmse["scalar"] == pytest.approx(float(np.sqrt(np.mean(error**2))), rel=1e-6)


@pytest.mark.nightly
def test_pack_check_simulate(home: Path, tribofmu: Tribofmu) -> None:
    tribofmu("pack", "forming", "--set", "n_points=40", "--set", "mesh_size=0.8", "-o", home / "forming.fmu")
    for name in ("linear", "better"):
        tribofmu("pack", home / name, "--nodes", 40, "-o", home / f"{name}.fmu")
        tribofmu("check", home / f"{name}.fmu")
    (home / "fre.yaml").write_text(SYSTEM)
    tribofmu("simulate", home / "fre.yaml", "-o", home / "runs" / "linear", "--csv")
    swap = ["--swap", f"friction={home / 'better.fmu'}"]
    tribofmu("simulate", home / "fre.yaml", *swap, "-o", home / "runs" / "better")
    tribofmu("simulate", home / "fre.yaml", *swap, "--mode", "jacobi", "-o", home / "runs" / "jacobi")
    runs = {name: Run.load(home / "runs" / name) for name in ("linear", "better", "jacobi")}
    for run in runs.values():
        assert run.synthetic  # its friction FMU says so; the system says nothing
        assert run["forming.stroke"][-1] == pytest.approx(6.0)
        assert run["forming.force"].max() > 200.0
    # the law with more friction at low speed needs more force; one step of lag more changes little
    assert runs["better"]["forming.force"].max() > 1.005 * runs["linear"]["forming.force"].max()
    assert runs["jacobi"]["forming.force"][-1] == pytest.approx(runs["better"]["forming.force"][-1], rel=0.01)
    assert "report written" in tribofmu("report", home / "runs" / "better")
    assert (home / "runs" / "linear" / "results.csv").is_file()


class Watch:
    """A progress display that keeps what steps say."""

    def __init__(self, said: list[str]) -> None:
        self.said = said

    def __call__(self, title: str) -> Watch:
        return self

    def __enter__(self) -> Callable[[int, int, str], None]:
        return lambda done, total, what: self.said.append(what)

    def __exit__(self, *_: object) -> None:
        return None


@pytest.fixture(scope="module")
def demo(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Demo:
    """A small demo on the same campaign: one level of the press, a short stroke, a quick second model."""
    scenario = Scenario(
        hidden=HIDDEN,
        seed=SEED,
        plan=str(home / "plan.csv"),
        other="polynomial",
        levels=(Level(20.0, 100.0),),
        stroke=4.0,
    )
    return Demo(grown(tmp_path_factory.mktemp("demo"), DEMO), scenario, jobs=1)


def test_errors_fall_on_unseen_tests_and_on_the_force(demo: Demo) -> None:
    result = demo.run()
    s = result.summary
    assert s["diagnosis"]["effects"] == [HIDDEN]
    first = json.loads((demo.out / "diagnosis.json").read_text(encoding="utf-8"))
    assert first["verdict"] == "ambiguous" and s["rounds"]  # so what it proposes was run
    assert s["rounds"][0]["before"] == first["confusion_set"]
    assert s["rounds"][0]["protocol"] == first["next_tests"][0]["protocol"]
    assert all(HIDDEN in r["after"] for r in s["rounds"])
    assert s["rounds"][-1]["after"] == s["diagnosis"]["confusion_set"] == [HIDDEN]
    assert s["diagnosis"]["verdict"] == "explained"
    tests = DataSet.load(demo.out / "further" / "data-1").tests
    assert tests is not None and len(tests) == s["rounds"][0]["tests"]
    assert s["held_out"]["after"]["rmse"] < s["held_out"]["before"]["rmse"]
    assert s["held_out"]["after"]["mae"] < s["held_out"]["before"]["mae"]
    for quantity in ("max_force", "work"):
        assert s["forces"]["after"][quantity]["mare"] < s["forces"]["before"][quantity]["mare"]
    printed = printed_summary(result)
    assert "The first answer was ambiguous" in printed and "not told apart" in printed
    assert "SYNTHETIC" in printed and str(result.report) in printed
    assert printed.count("falls by") >= 4 and printed.count("closed loop") == 2


def test_held_out_tests_are_predicted_as_if_nobody_had_run_them(demo: Demo) -> None:
    summary = json.loads((demo.out / "demo.json").read_text(encoding="utf-8"))
    for part, found in summary["predicted"].items():
        assert len(found["tests"]) == 3 and found["synthetic"]
        points = pd.read_csv(demo.out / "predicted" / part / "predicted.csv", dtype={"test_id": str})
        # mu is the model's answer to the loads of the loop itself, not to measured ones
        model = load_model(demo.out / "models" / part)
        mu = model.predict(model.domain.clamp(points[list(LOAD_NAMES)].to_numpy()))
        np.testing.assert_allclose(points["mu_model"], mu, rtol=1e-9)
        assert np.abs(points["T"] - points["T_measured"]).max() > 1.0
        # an error of mu changes the heat, and that changes mu; it stays of the size it has under measured loads
        assert found["summary"]["mu_rms"] < 2.0 * summary["held_out"][part]["rmse"]


def test_the_report_tells_the_whole_story_offline(demo: Demo) -> None:
    html = (demo.out / "report.html").read_text(encoding="utf-8")
    for anchor in (
        "verdict",
        "settled",
        "budget",
        "force",
        "residual",
        "evidence",
        "tests",
        "predicted",
        "response",
        "runs",
    ):
        assert f'<section id="{anchor}"' in html
    own = re.sub(r"<script.*?</script>", "", html, flags=re.DOTALL)
    assert not re.findall(r"(?:src|href)\s*=\s*[\"'](?!#|data:)", own)
    assert html.count("synthetic") >= 3


def test_the_report_of_a_model_that_lacks_nothing(demo: Demo, tmp_path: Path) -> None:
    for name in ("data", "models", "press", "runs", "predicted"):
        (tmp_path / name).symlink_to(demo.out / name)
    summary = json.loads((demo.out / "demo.json").read_text(encoding="utf-8"))
    summary["diagnosis"] |= {"verdict": "nothing_missing", "effects": [], "confusion_set": []}
    summary["rounds"] = []
    summary["frictions"] = [f for f in summary["frictions"] if f["part"] != "after"]
    del summary["held_out"]["after"], summary["forces"]["after"], summary["predicted"]["after"]
    (tmp_path / "demo.json").write_text(json.dumps(summary), encoding="utf-8")
    assert "lacks nothing" in write_report(tmp_path).read_text(encoding="utf-8")


@pytest.mark.nightly
def test_a_second_run_reuses_everything(demo: Demo) -> None:
    demo.run()
    kept: list[str] = []
    again = Demo(demo.out, demo.scenario, jobs=1, display=Watch(kept))
    before = {p: p.stat().st_mtime_ns for p in demo.out.rglob("results.nc")}
    assert len(before) == 4 + 2 * 3  # friction models in the extrusion, and held-out tests before and after
    again.run()
    assert kept.count("kept from before") == 8
    assert {p: p.stat().st_mtime_ns for p in demo.out.rglob("results.nc")} == before


@pytest.mark.nightly  # by day tests/orchestrator/reports/test_comparison_process.py
def test_compare_on_press_curves(demo: Demo, tribofmu: Tribofmu, tmp_path: Path) -> None:
    demo.run()
    models = [demo.out / "models" / part for part in ("before", "after")]
    shown = tribofmu(
        "compare", "--models", *models, "--data", demo.out / "press", "--json", tmp_path / "forces.json"
    )
    assert "synthetic press curves" in shown and "MARE" in shown
    before, after = json.loads((tmp_path / "forces.json").read_text(encoding="utf-8"))["models"]
    assert after["max_force"]["mare"] < before["max_force"]["mare"]
