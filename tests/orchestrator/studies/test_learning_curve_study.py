"""The learning-curve study from made-up tests to its report."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models import DataSet
from friction_models.common import InputError, write_json
from orchestrator.jobs.graph import JobResult
from orchestrator.report import write_report
from orchestrator.report.study_pages.learning_curve import learning_curve_page
from orchestrator.report.study_pages.saved_study import study_page
from orchestrator.studies.learning_curve.files import write_results
from orchestrator.studies.learning_curve.jobs import AVERAGE, MEAN, SERIES, Collection
from orchestrator.studies.learning_curve.result import LearningCurves
from orchestrator.studies.learning_curve.study import LearningCurvePlan, LearningCurveStudy
from orchestrator.studies.learning_curve.words import beside_paper, findings, headline, text_table
from orchestrator.studies.measurements import (
    chosen_data,
    data_jobs,
    load_measurements,
    measurement_jobs,
)
from tests.friction_models.made_up import campaign

NETWORK: dict[str, dict[str, list[Any]]] = {"ffnn": {"hidden": [[4]], "weight_decay": [0.1, 1.0]}}
TINY = LearningCurvePlan(
    sizes=(5, 9, 90), repeats=3, thin=2, search_thin=1, steps=40,
    parameters={"gradient_boosting": {"trees": 10}, "ffnn": {"members": 1}},
    grids={SERIES: {"gradient_boosting": {"min_points": [3]}, **NETWORK}, AVERAGE: NETWORK},
)  # fmt: skip


def made_up_data(folder: Path, tests: int = 16, held: int = 4) -> Path:
    frame = campaign(tests, 16)
    ids = frame["test_id"].unique()
    roles = ["train"] * (tests - held) + ["test"] * held
    table = pd.DataFrame({"test_id": ids, "role": roles} if held else {"test_id": ids})
    DataSet(frame, table, {"synthetic": True}).save(folder)
    return folder


@pytest.fixture(scope="module")
def done(
    tmp_path_factory: pytest.TempPathFactory,
) -> tuple[LearningCurveStudy, Path, dict[str, JobResult], LearningCurves]:
    folder = tmp_path_factory.mktemp("study")
    data = made_up_data(folder / "paste")
    study = LearningCurveStudy.of(TINY, {"paste": data})
    work = study.graph(folder / "out")
    results = work.run(jobs=1)
    work.check()
    return study, folder / "out", results, LearningCurves.of(study, results)


def alike(errors: list[float]) -> np.ndarray:
    """Return these errors at three sizes, the same in three repeats and six held-out tests."""
    return np.tile(np.array(errors)[None, :, None], (3, 1, 6))


Done = tuple[LearningCurveStudy, Path, dict[str, JobResult], LearningCurves]


def test_every_model_and_collection_has_its_curve(done: Done) -> None:
    study, _, _, curves = done
    assert curves.lubricants == ["paste"] and curves.models == list(study.plan.models) and not curves.missing
    for collection in (SERIES, AVERAGE):
        for model in (MEAN, *study.plan.models):
            curve = curves.curve("paste", collection, model)
            assert curve is not None
            assert curve.sizes == (5, 9, 12), "sizes beyond the data give way to all tests"
            assert curve.errors.shape == (3, 3) and curve.parts.shape == curve.averages.shape == (3, 3, 4)
            assert np.isfinite(curve.errors).all() and (curve.errors > 0).all()
    series, average = (curves.curve("paste", c, "linear") for c in (SERIES, AVERAGE))
    assert series is not None and average is not None
    assert series.points == (40, 72, 96) and average.points == (5, 9, 12)
    # With all tests there is one training set.
    assert np.ptp(series.errors[:, -1]) < 1e-12
    mean = curves.curve("paste", SERIES, MEAN)
    assert mean is not None and series.percentile[-1] < mean.percentile[-1]


def test_linear_errors_are_those_of_a_fit_by_hand(done: Done) -> None:
    from friction_models import LinearFriction
    from friction_models.loads import LOAD_NAMES
    from friction_models.training import growing_sets

    _, _, results, curves = done
    train, test = load_measurements(results["data-paste"]).frames()
    chosen = growing_sets(list(train["test_id"].unique()), 3, 0)[1][:9]
    own = train[train["test_id"].isin(chosen)]
    own = own[own.groupby("test_id").cumcount() % 2 == 0]
    model = LinearFriction().fit_frame(own)
    loads = model.domain.clamp(test[list(LOAD_NAMES)].to_numpy())
    expected = np.mean(np.abs(model.predict(loads) - test["mu"].to_numpy()))
    curve = curves.curve("paste", SERIES, "linear")
    assert curve is not None and curve.errors[1, 1] == pytest.approx(expected, rel=1e-12)
    worst = (model.predict(loads) - test["mu"]).abs().groupby(test["test_id"]).mean().max()
    assert curve.parts[1, 1].max() == pytest.approx(worst, rel=1e-12), (
        "tests of equal length: each its own MAE"
    )


def test_loads_that_the_plan_does_not_vary_are_no_inputs_of_averages(done: Done) -> None:
    _, _, results, _ = done
    averages = Collection.of(results["data-paste"], AVERAGE, 1)
    assert averages.not_varied == ["sd"] and averages.training["sd"].nunique() == 1
    assert averages.training["T"].nunique() == 3
    assert Collection.of(results["data-paste"], SERIES, 1).training["sd"].nunique() > 10


def test_files_hold_the_same_numbers(done: Done, tmp_path: Path) -> None:
    study, folder, results, curves = done
    page = learning_curve_page(study, curves, study.graph(folder).manifest(results), results)
    write_results(tmp_path, curves, page)
    content = json.loads((tmp_path / "learning-curve.json").read_text(encoding="utf-8"))
    assert content["synthetic"] is True and len(content["curves"]) == 12
    assert [c["model"] for c in content["comparisons"]] == list(study.plan.models)
    with (tmp_path / "repeats.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 12 * 3 * 3 and {row["synthetic"] for row in rows} == {"True"}
    errors = [
        float(r["mae"]) for r in rows if (r["collection"], r["model"], r["tests"]) == (SERIES, "ffnn", "9")
    ]
    (curve,) = (c for c in content["curves"] if (c["collection"], c["model"]) == (SERIES, "ffnn"))
    assert errors == curve["mae"][1]
    assert curve["mae_percentile"][1] == pytest.approx(np.quantile(errors, 0.95))
    assert set(curve["parameters"][1]) == {"hidden", "weight_decay"}
    assert 'id="chart-series"' in page and 'id="chart-loads"' in page
    for text in ("synthetic data", "Beside the paper", headline(curves), "fewest points a leaf", "details"):
        assert text in page.replace("&lt;", "<")
    assert "says of itself that it is synthetic" in page and "virtual laboratory" not in page
    page = learning_curve_page(
        study, replace(curves, virtual=True), study.graph(folder).manifest(results), {}
    )
    assert "made by the virtual laboratory" in page


def test_the_page_is_made_again_from_the_folder(done: Done, monkeypatch: pytest.MonkeyPatch) -> None:
    study, folder, results, curves = done
    work = study.graph(folder)
    manifest = work.manifest(results, {"study": "learning-curve", **study.plan.to_dict()})
    file = write_json(folder / "manifest.json", manifest)
    assert study_page(folder) == learning_curve_page(study, curves, manifest, results)
    assert study_page(folder) == write_report(folder).read_text(encoding="utf-8")
    # What strangers may have made of it.
    for change, message in (
        ({"settings": {"study": "learning-curv"}}, "did you mean 'learning-curve'"),
        ({"settings": {**manifest["settings"], "lubricants": 3}}, "damaged or of another version"),
        ({"jobs": {"facts-paste": {"job": "../../paste"}}}, "holds none of the results"),
    ):
        write_json(file, manifest | change)
        with pytest.raises(InputError, match=message):
            study_page(folder)
    monkeypatch.setattr("orchestrator.studies.saved.MAX_BYTES", 100)
    with pytest.raises(InputError, match="allowed: at most 100"):
        study_page(folder)
    with pytest.raises(InputError, match="allowed: a place in it"):
        JobResult("x", {"dataset": "../elsewhere"}, folder, 1.0).file("dataset")


def test_words_and_table_follow_the_numbers(done: Done) -> None:
    _, _, _, curves = done
    table = text_table(curves)
    assert table.startswith("synthetic") and all(model in table for model in curves.models)
    assert len(beside_paper(curves)) == 8
    worse = [replace(c, parts=alike([0.02, 0.01, 0.02])) for c in curves.curves]
    row = next(
        r for r in beside_paper(replace(curves, curves=tuple(worse))) if r[0].startswith("time-series: conv")
    )
    assert row[1] == "about 30" and row[2].startswith("- (not linear paste, ")
    first = findings(curves)[0]
    assert (
        "needs fewer tests than average-based data in none, more in none; there is no clear difference in "
        in first
    ), "four held-out tests tell nothing apart"
    # Made-up errors: the time series saves tests in one model, and costs some in another.
    flat = [replace(c, parts=alike([0.02, 0.015, 0.0105])) for c in curves.curves]
    good = {(SERIES, "ffnn"): 0.6, (SERIES, "linear"): 0.4}
    quick = [replace(c, parts=c.parts * good.get((c.collection, c.model), 1.0)) for c in flat]
    saved = replace(curves, curves=tuple(quick))
    assert headline(saved) == "Time-series data needs fewer tests for MAE < 0.01 in 2 of 5 cases"
    assert "linear paste: at most 5 against not reached, ffnn paste: 8 against" in findings(saved)[0]
    bad = [replace(c, parts=c.parts * 0.6) if c.collection == AVERAGE else c for c in flat]
    assert headline(replace(curves, curves=tuple(bad))) == (
        "Time-series data needs more tests for MAE < 0.01 in 5 of 5 cases"
    )
    assert headline(replace(curves, curves=tuple(flat))).startswith("Time-series data does not clearly need")
    easy = replace(curves, curves=tuple(replace(c, parts=c.parts * 0.1) for c in flat))
    assert {c.verdict for c in easy.comparisons} == {"both at once"}
    assert "in 5 of 5 the smallest training set, 5 tests, suffices with either" in findings(easy)[0]


def test_a_failed_job_leaves_a_hole(done: Done) -> None:
    study, folder, results, _ = done
    partial = {name: result for name, result in results.items() if name != "paste-average-ffnn-9"}
    curves = LearningCurves.of(study, partial)
    assert curves.missing == 1
    hole = curves.curve("paste", AVERAGE, "ffnn")
    assert hole is not None and hole.sizes == (5, 12)
    assert "ffnn" not in [c.model for c in curves.comparisons]
    assert "1 jobs have no result" in text_table(curves)
    assert learning_curve_page(study, curves, study.graph(folder).manifest(partial), partial)


def test_tests_are_held_out_where_none_have_roles(tmp_path: Path) -> None:
    data = made_up_data(tmp_path / "plain", tests=11, held=0)
    (job,) = data_jobs({"plain": data}, seed=3)["plain"]
    from orchestrator.studies.measurements import take

    (tmp_path / "job").mkdir()
    values = take(job.inputs, job.files, {}, tmp_path / "job")
    assert (values["train"], values["held_out"]) == (8, 3) and "seed" in values["roles"]
    averages = DataSet.load(tmp_path / "job" / values["averages"])
    assert len(averages.points) == 11 and averages.synthetic


def test_jobs_of_the_laboratory_cover_the_plan() -> None:
    jobs = measurement_jobs("mos2", "factorial-81+30", seed=4)
    shapes, tests = jobs[:4], jobs[4:-1]
    assert [job.inputs for job in shapes] == [{"psi_set": psi} for psi in (1.069, 5.0, 10.0, 20.0)]
    assert jobs[-1].name == "data-mos2" and set(jobs[-1].needs) == {job.name for job in tests}
    parts = [(job.inputs["part"], job.inputs["parts"]) for job in tests]
    assert parts == [(k, 8) for k in range(8)] and all(job.inputs["seed"] == 4 for job in tests)
    assert all(set(job.needs) == {shape.name for shape in shapes} for job in tests)
    full = LearningCurveStudy.of(LearningCurvePlan())
    trained = {
        (job.inputs["collection"], model, size)
        for job in full.jobs
        if job.function.endswith(":learn")
        for model in job.inputs["models"]
        for size in job.inputs["sizes"]
    }
    assert len(trained) == 2 * 6 * 14


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["polymer=nowhere"], "no such folder or file nowhere"),
        (["a=.", "a=."], "'a' stands twice"),
        (["a/b=."], "plain name"),
    ],
)
def test_bad_data_options_are_refused(texts: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        chosen_data(texts)


def test_data_that_cannot_be_studied_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="3 tests; allowed: at least 4"):
        data_jobs({"x": made_up_data(tmp_path / "few", tests=3, held=1)})
    one_role = made_up_data(tmp_path / "one", tests=5, held=5)
    with pytest.raises(InputError, match="no test has the role 'train'"):
        data_jobs({"x": one_role})
    with pytest.raises(InputError, match="did you mean 'polymer'"):
        measurement_jobs("polymr")
    lone = made_up_data(tmp_path / "lone", tests=4, held=3)
    with pytest.raises(InputError, match="1 training test"):
        LearningCurveStudy.of(TINY, {"x": lone})


def test_command_runs_and_says_what_it_would_do(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from orchestrator.cli.main import run

    data = made_up_data(tmp_path / "paste")
    arguments = [
        "study",
        "learning-curve",
        "--quick",
        "--dry-run",
        "--data",
        str(data),
        "-o",
        str(tmp_path / "o"),
    ]
    assert run(arguments) == 0
    assert "jobs" in capsys.readouterr().out and not (tmp_path / "o" / "report.html").exists()
    assert run([*arguments[:5], "no=where", "-o", str(tmp_path / "o")]) == 2
    assert "no such folder" in capsys.readouterr().err
