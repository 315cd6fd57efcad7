"""Order of models with its uncertainty, on tests and on press levels, and the page that shows it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from fmus.runtime.errors import SimulationError
from fmus.runtime.friction_names import entries_by_model
from friction_models import evaluate
from friction_models.common import InputError
from friction_models.loads import DataSet, FloatArray
from friction_models.models.domain import Domain
from orchestrator.cli.common.console import _plain
from orchestrator.cli.main import run
from orchestrator.comparison.on_press import ForcesComparison
from orchestrator.comparison.on_tests import compare_on_tests, known_domain
from orchestrator.comparison.order import FEWEST_UNITS, resampled_errors
from orchestrator.comparison.press_study import FailedRun, PressResults
from orchestrator.force_curves.forces import ForceCurve, LevelsComparison, compare_force
from orchestrator.report.pages.comparison import comparison_page
from orchestrator.report.reading import read_page


class Law:
    """mu with an offset that belongs to each test, and a domain."""

    def __init__(self, offset: float, wave: float = 0.0, top: float = 3000.0) -> None:
        self.offset, self.wave, self.top = offset, wave, top

    @property
    def domain(self) -> Domain:
        return Domain((0.0, 0.0, 0.0, 0.0, 1.0), (1000.0, 500.0, self.top, 60.0, 25.0))

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> FloatArray:
        number = data["test_id"].str.removeprefix("t").astype(int).to_numpy()
        return 0.08 + self.offset + self.wave * np.where(number % 2, 1.0, -1.0)

    def predict(self, loads: FloatArray) -> FloatArray:
        return np.full(len(loads), 0.08 + self.offset)


def measured(tests: int = 12, points: int = 20) -> DataSet:
    """Return tests whose pressure rises from 500 to 2000 MPa, mu = 0.08 everywhere but for noise."""
    rng = np.random.default_rng(1)
    n = tests * points
    table = pd.DataFrame(
        {
            "test_id": np.repeat([f"t{k}" for k in range(tests)], points),
            "v_rel": 100.0,
            "T": 60.0,
            "sigma_n": np.repeat(np.linspace(500.0, 2000.0, tests), points),
            "sd": np.tile(np.linspace(0.1, 20.0, points), tests),
            "psi": 1.2,
            "mu": 0.08 + 1e-4 * rng.standard_normal(n),
        }
    )
    return DataSet(table, pd.DataFrame({"test_id": [f"t{k}" for k in range(tests)]}), {"synthetic": True})


def test_order_domain_and_pairs_on_tests() -> None:
    models = {"near": Law(0.002), "same": Law(0.002), "far": Law(0.01, top=1250.0), "0.05": Law(-0.03)}
    c = compare_on_tests(models, measured())
    assert c.order.names[2:] == ["far", "0.05"]
    # Two names for one law share the first place, and nobody tells them apart.
    assert c.order.best["near"] == pytest.approx(0.5) and c.order.best["same"] == pytest.approx(0.5)
    assert c.order.indistinct == [tuple(c.order.names[:2])]
    assert c.order.ranks["far"] == (3, 3)
    # Half of the tests press harder than 1250 MPa.
    assert c.outside["near"] == 0.0 and c.outside["far"] == pytest.approx(0.5)
    content = json.loads(json.dumps(c.to_dict(), allow_nan=False))
    assert content["models"]["far"]["probability_best"] == 0.0 and content["models"]["far"]["rmse"] > 0.009
    assert content["order"]["units"] == 12 and len(content["order"]["pairs"]) == 6
    assert "cannot be told apart on 12 tests" in c.report()
    # `evaluate` extrapolates: whoever sees both errors must know why they differ.
    [said] = [line for line in c.report().splitlines() if "moved to its border" in line]
    assert said.startswith("far: ") and said in c.remarks()


def test_models_with_the_same_error_share_the_tests_they_are_best_on() -> None:
    """Three files of one law were best on 67 %, 0 % and 17 % of the tests, by rounding."""
    models = {
        "law": Law(0.002),
        "again": Law(0.002 + 3e-17),
        "other file": Law(0.002 - 3e-17),
        "far": Law(0.01),
    }
    errors = compare_on_tests(models, measured()).result.errors
    assert [errors[name].wins for name in models] == pytest.approx([1 / 3, 1 / 3, 1 / 3, 0.0])


def test_points_outside_are_counted_as_evaluate_counts_them() -> None:
    """Pressure that was read with 2 % of noise: of the readings of the last test, at 2000 MPa, half lie above."""
    data, rng = measured(), np.random.default_rng(2)
    read = data.points["sigma_n"] * (1.0 + 0.02 * rng.standard_normal(len(data.points)))
    noisy = DataSet(data.points.assign(sigma_n=read), data.tests, {"synthetic": True})
    law = Law(0.01, top=2000.0)
    counted = evaluate(law, noisy.points, noisy.tests).overall["outside_domain"]
    assert 0.3 < 12 * counted < 0.7
    assert compare_on_tests({"law": law}, noisy).outside["law"] == counted


def test_the_unit_is_the_test_and_few_of_them_prove_nothing() -> None:
    # In every second test one model is 0.004 better, in the others 0.004 worse: points are many, tests are few.
    swinging = {"even": Law(0.004, 0.004), "odd": Law(0.0041, -0.004)}
    c = compare_on_tests(swinging, measured())
    assert c.order.indistinct == [("even", "odd")] and 0.4 < c.order.best["even"] < 0.75
    few = compare_on_tests({"near": Law(0.002), "far": Law(0.01)}, measured(tests=FEWEST_UNITS - 1))
    assert few.order.best["near"] == 1.0 and few.order.indistinct == [("near", "far")]
    assert f"at least {FEWEST_UNITS} tests are needed" in few.report()
    assert few.report().startswith("near is ahead, but not clearly, of far")
    # No pair is told apart, so no model has a place of its own either.
    assert few.order.place("near") == few.order.place("far") == "not known"
    # The numbers of --json say no more than the words: the keys stay, None and the reason stand there.
    told = few.to_dict()
    assert told["order"]["best"] == told["order"]["ranks"] == {"near": None, "far": None}
    assert told["order"]["reason"] == f"at least {FEWEST_UNITS} tests are needed to tell models apart"
    assert [(p["interval"], p["probability"]) for p in told["order"]["pairs"]] == [(None, None)]
    assert {"probability_best", "rank_interval"} <= set(told["models"]["near"])
    assert told["models"]["near"]["probability_best"] is told["models"]["near"]["rank_interval"] is None
    assert c.to_dict()["order"]["reason"] is None and None not in c.to_dict()["order"]["pairs"][0].values()
    assert c.order.place("even") == "1-2" and c.order.place("odd", " to ") == "1 to 2"


def test_a_model_without_limits_has_no_domain() -> None:
    class Free:
        domain = Domain.physical()

    assert known_domain(Free()) is None and known_domain(object()) is None
    assert known_domain(Law(0.0)) == Law(0.0).domain


def test_resampled_errors_follow_levels_and_repeats() -> None:
    rng = np.random.default_rng(0)
    measured_mean = np.full(8, 100.0)
    exact, off = resampled_errors([measured_mean, 1.1 * measured_mean], measured_mean, np.full(8, 1.0), rng)
    # |x| of a normal error of 1 % has the mean 0.8 %; 10 % too much stays 10 % on the mean.
    assert np.mean(exact) == pytest.approx(0.01 * np.sqrt(2 / np.pi), rel=0.03)
    assert np.mean(off) == pytest.approx(0.1, rel=0.03)
    assert np.all(off > exact)


def forces(levels: int, shares: dict[str, float]) -> ForcesComparison:
    stroke = np.linspace(0.0, 10.0, 101)
    rng = np.random.default_rng(2)
    results = []
    names = [f"fre_{k}" for k in range(levels)]
    press = []
    for k in range(levels):
        size = (10.0 + k) * stroke
        repeats = [ForceCurve(stroke, size * (1.0 + 0.01 * rng.standard_normal())) for _ in range(5)]
        press.append(tuple(repeats))
    for label, share in shares.items():
        compared = tuple(
            compare_force(ForceCurve(stroke, share * (10.0 + k) * stroke), press[k], label)
            for k in range(levels)
        )
        results.append(LevelsComparison(label, compared))
    return ForcesComparison.of(results, names, synthetic=True)


def test_levels_of_several_lubricants_are_said() -> None:
    one = forces(7, {"a": 1.0, "b": 1.1})
    assert one.remarks() == [] and "count together" not in comparison_page(None, one)
    both = replace(one, lubricants=["mos2", "polymer"])
    said = "levels of mos2, polymer count together"
    assert said in both.report() and said in comparison_page(None, both)
    content = both.to_dict()
    assert content["lubricants"] == ["mos2", "polymer"] and said in content["remarks"][0]


def test_order_on_press_levels_knows_the_scatter_of_the_repeats() -> None:
    c = forces(9, {"good": 1.0, "alike": 1.0005, "bad": 1.08})
    assert c.orders["max_force"].names[-1] == "bad" and c.orders["work"].best["bad"] == 0.0
    pairs = {(p["better"], p["worse"]): p["apart"] for p in c.orders["max_force"].pairs}
    assert pairs["good", "bad"] and pairs["alike", "bad"]
    assert sum(pairs.values()) == 2
    content = json.loads(json.dumps(c.to_dict(), allow_nan=False))
    assert [m["label"] for m in content["models"]] == ["good", "alike", "bad"]
    assert content["ranking"] == c.orders["max_force"].names
    assert "probability of being the best" in c.report() and "MARE max force" in c.report()


def test_page_of_both(tmp_path: Path) -> None:
    c = compare_on_tests({"<near>": Law(0.002), "0.05": Law(-0.03)}, measured())
    html = comparison_page(c, forces(2, {"<near>": 1.0, "0.05": 0.9}))
    assert "synthetic data" in html and "&lt;near&gt;" in html and "<near>" not in html.replace("\\u003c", "")
    for anchor in ("parity", "response", "tests", "level-errors", "force-curves"):
        assert f'id="chart-{anchor}"' in html
    assert f"at least {FEWEST_UNITS} levels are needed" in html


def test_a_model_has_one_colour_in_all_pictures(tmp_path: Path) -> None:
    # The best comes last.
    c = compare_on_tests({"far": Law(0.01), "0.05": Law(-0.03), "near": Law(0.002)}, measured())
    (tmp_path / "page.html").write_text(comparison_page(c, None))
    page = read_page(tmp_path / "page.html")
    seen: dict[str, set[str]] = {}
    for anchor, style in (("response", "line"), ("tests", "marker")):
        section = page.section(anchor)
        found = section.figure() if section is not None else None
        assert found is not None
        for trace in found.data:
            if trace.get("name") in c.models:
                seen.setdefault(trace["name"], set()).add(trace[style]["color"])
    assert {name: len(colours) for name, colours in seen.items()} == {"far": 1, "0.05": 1, "near": 1}


def refused(capsys: pytest.CaptureFixture[str], *arguments: Any) -> str:
    assert run([str(a) for a in arguments]) == 2
    return capsys.readouterr().err


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    measured().save(tmp_path / "data")
    out = ("--json", tmp_path / "c.json", "--report", tmp_path / "c.html")
    assert (
        run([str(a) for a in ("compare", "--models", "0.08", "0.05", "--data", tmp_path / "data", *out)]) == 0
    )
    assert "probability best" in capsys.readouterr().out
    content = json.loads((tmp_path / "c.json").read_text())
    assert content["ranking"] == ["0.08", "0.05"] and content["synthetic"] and content["clear"]
    assert content["models"]["0.08"]["outside_domain"] is None
    assert "Measured against predicted" in (tmp_path / "c.html").read_text()
    assert "neither --data nor --press" in refused(capsys, "compare", "--models", "0.08")
    (tmp_path / "names.yaml").write_text("other.fmu: {mu: cof}\n")
    said = refused(
        capsys, "compare", "--models", "0.08", "--data", tmp_path / "data", "--names", tmp_path / "names.yaml"
    )
    assert "no FMU among the models" in said


def test_an_entry_of_names_belongs_to_one_fmu(tmp_path: Path) -> None:
    names = tmp_path / "names.yaml"
    models = ["a/law.fmu", "b/law.fmu", "0.08", "c/other.fmu"]
    names.write_text("a/law.fmu: {mu: cof}\nother: {mu: friction}\n")
    assert entries_by_model(models, names) == {"a/law.fmu": {"mu": "cof"}, "c/other.fmu": {"mu": "friction"}}
    for text, pattern in (
        ("law.fmu: {mu: cof}", "'law.fmu' may be a/law.fmu or b/law.fmu"),
        ("other: {mu: x}\nother.fmu: {mu: y}", "c/other.fmu has two entries"),
        ("othr.fmu: {mu: x}", "did you mean 'other.fmu'"),
    ):
        names.write_text(text)
        with pytest.raises(InputError, match=pattern):
            entries_by_model(models, names)


def test_mu_that_cannot_be_one_and_text_from_users_on_the_page() -> None:
    c = compare_on_tests({"<b>wrong</b>": Law(1.5), "0.05": Law(-0.03)}, measured())
    assert (
        c.remarks()[:-1] == ["<b>wrong</b>: mu from 1.58 to 1.58, outside 0 to 1"]
        and c.remarks()[0] in c.report()
    )
    html = comparison_page(c, None)
    assert "<b>wrong" not in html.replace("\\u003c", "<").replace("\\u003e", ">")
    # A rough third model does not blur the order of the others.
    fine = compare_on_tests({"near": Law(0.002), "next": Law(0.0021), "wrong": Law(3.0)}, measured())
    assert ("near", "next") not in fine.order.indistinct and fine.result.clear


def test_runs_that_failed_are_named_and_the_others_compared() -> None:
    lost = FailedRun("thin", "fre_1", "component 'friction' failed", {"speed": 5.0})
    c = replace(forces(9, {"good": 1.0, "bad": 1.08}), failed=[lost])
    assert "thin is not compared: 1 of 9 levels failed (fre_1: component 'friction' failed)" in c.report()
    assert c.to_dict()["failed"][0]["inputs"] == {"speed": 5.0}
    assert "thin is not compared" in comparison_page(None, c)
    results = PressResults(list(c.results), [lost], 27)
    with pytest.raises(SimulationError, match=r"1 of 27 runs failed: thin at fre_1: .*--runs FOLDER"):
        results.check(None)
    with pytest.raises(SimulationError, match=r"failed\.json"):
        results.check(Path("runs"))


def test_options_that_do_not_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "press").mkdir()
    (tmp_path / "press" / "levels.csv").write_text("", encoding="utf-8")
    models = ("compare", "--models", "0.08", "--data")
    assert "there are press curves only" in refused(capsys, *models, tmp_path / "press", "--tests", "t.csv")
    measured().save(tmp_path / "data")
    assert "no press curves" in refused(capsys, *models, tmp_path / "data", "--runs", tmp_path / "runs")
    # Nothing is computed before all inputs are known to be there.
    assert run([*models, str(tmp_path / "data"), "--press", str(tmp_path / "none")]) == 2
    assert capsys.readouterr().out == ""
    (tmp_path / "records" / "raw").mkdir(parents=True)
    assert "tribofmu twin" in refused(capsys, *models, tmp_path / "records")


def test_progress_without_a_terminal_is_heard_of_every_half_minute(
    capsys: pytest.CaptureFixture[str],
) -> None:
    now = 0.0
    with _plain("runs", lambda: now) as tick:
        for done in range(101):
            now = 10.0 * done
            tick(done, 1000, "")
    assert capsys.readouterr().err.count("runs:") == 1 + 33
