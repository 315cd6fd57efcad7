"""`diagnose`, `refine`: which effect a model is missing, adding it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .console import say, write_result
from .modelling import Interval, add_interval
from .options import Json, Names, OutFolder, Tests, any_model, given_names, read_data

if TYPE_CHECKING:
    import pandas as pd

    from friction_models.loads import DataSet

Campaigns = Annotated[
    list[Path],
    typer.Option(
        "--data",
        help="Data set: a folder with points.csv, or a CSV or Parquet file. Several: the first campaign and further "
        "tests, judged together.",
    ),
]


def diagnose(
    data: Campaigns,
    model: Annotated[
        str, typer.Option(help="Model folder, .fmu or .onnx file, number (constant mu) or name of a family.")
    ],
    tests: Tests = None,
    seed: Annotated[int, typer.Option(help="Seed of the bootstrap.")] = 0,
    json: Json = None,
    report: Annotated[Path | None, typer.Option(help="Also write an HTML report.")] = None,
    plan: Annotated[
        Path | None, typer.Option(help="Also write the proposed tests as a plan (CSV, one row a test).")
    ] = None,
    names: Names = None,
) -> None:
    """Say which physical effect the model is missing: or that nothing is, or that the data cannot tell."""
    from friction_models.discovery import diagnose as search

    friction = any_model(model, given_names([model], names))
    dataset, absent = read_campaigns(data, tests)
    part = dataset.select("train")  # tests that are held out stay unseen
    result = search(part.points.drop(columns=absent), part.tests, model=friction, seed=seed)
    say(result.report())
    if json is not None:
        write_result(json, {"synthetic": result.synthetic, **result.to_dict()})
    if report is not None:
        from ..report import write_diagnosis_report

        write_diagnosis_report(report, friction, part, result, label=model)
        say(f"report written: {report}")
    if plan is not None:
        _write_plan(plan, result.next_tests)


def _write_plan(plan: Path, next_tests: list[dict[str, Any]]) -> None:
    from friction_models.discovery.next_tests import plan_rows

    from ..plan_file import missing_settings, write_plan

    rows = plan_rows(next_tests)
    if not rows:
        say("no plan written: there are no rivals that a further test would tell apart")
        return
    write_plan(plan, rows)
    absent = missing_settings(rows)
    todo = f"; fill in {', '.join(absent)} first: the data do not hold them" if absent else ""
    say(f"plan written: {plan} ({len(rows)} tests{todo})")


def refine(
    data: Campaigns,
    model: Annotated[str, typer.Option(help="Model folder or name of a family.")],
    add: Annotated[list[str], typer.Option("--add", help="Effects to add, one or more.")],
    out: OutFolder,
    tests: Tests = None,
    force: Annotated[
        bool, typer.Option("--force", help="Keep an addition that makes tests not seen in the fit worse.")
    ] = False,
    report: Annotated[Path | None, typer.Option(help="Also write an HTML report.")] = None,
    interval: Interval = True,
) -> None:
    """Add physical effects to a model, refit everything together and save the new model.

    The addition is judged by whole tests that the fit did not see: those held out, else by cross-validation. An
    addition that makes them worse is refused. Every round is kept with the model and shown.
    """
    from friction_models import evaluate
    from friction_models.discovery import refine as improve
    from friction_models.discovery.refinement import history_text
    from friction_models.effects import make_effect
    from friction_models.loads import InputError, write_text

    for name in add:
        make_effect(name)
    if Path(model).suffix == ".fmu":
        raise InputError(f"{model}: an FMU is a fixed law; allowed: a model folder or the name of a family")
    friction = any_model(model)
    dataset, _ = read_campaigns(data, tests)
    better = improve(dataset.points, dataset.tests, model=friction, add=add, force=force)
    if friction.is_fitted:
        say(evaluate(friction, dataset, name=f"before: {model}").report())
    result = evaluate(better, dataset, name=f"after: {model} + {' + '.join(add)}")
    for role, measures in result.roles.items():
        better.record_errors(role, measures)
    say(result.report())
    say(history_text(better.error_history_))
    if interval:
        say(add_interval(better, dataset))
    better.save(out)
    say(f"model written: {out}")
    if report is not None:
        from ..report.refinement_page import refinement_page

        if not friction.is_fitted:
            friction = improve(dataset.points, dataset.tests, model=friction)
        write_text(report, refinement_page(friction, better, dataset, model))
        say(f"report written: {report}")


def read_campaigns(data: list[Path], tests: Path | None) -> tuple[DataSet, list[str]]:
    """Read one data set, or several as one, and say what was changed to join them; see `read_some_loads`.

    Raises
    ------
    InputError
        What `read_some_loads` refuses; a data set that is given twice, a test table beside several of them, campaigns
        with other loads than the others.
    """
    from friction_models.loads import InputError

    if len(data) == 1:
        return read_some_loads(data[0], tests)
    if tests is not None:
        raise InputError(
            f"--tests {tests}: beside {len(data)} --data; allowed: folders that hold their tests.csv"
        )
    known: dict[Path, Path] = {}
    for path in data:
        if path.resolve() in known:
            raise InputError(f"--data {path}: given twice; allowed: each campaign once")
        known[path.resolve()] = path
    from friction_models.discovery.joined import join_campaigns

    names = [p.name for p in known]
    parts, absent = {}, {}
    for full, path in known.items():
        name = full.name if names.count(full.name) == 1 else str(path)
        part, absent[name] = read_some_loads(path, None)
        part.points = part.points.drop(columns=absent[name])
        parts[name] = part
    dataset, remarks = join_campaigns(parts)
    for remark in remarks:
        say(remark)
    lacking = next(iter(absent.values()))  # the same in all: others were refused
    dataset.points = constants(dataset.points, lacking)
    return dataset, lacking


def read_some_loads(data: Path, tests: Path | None) -> tuple[DataSet, list[str]]:
    """Read a data set that may lack some of the five loads; return it with constants for them, and their names.

    Raises
    ------
    InputError
        What `DataSet.load` refuses, other than missing loads; no load at all.
    """
    from friction_models.loads import LOADS, DataSet
    from friction_models.loads.dataset import check_points, read_info, read_table, says_synthetic

    file = data
    if data.is_dir():
        file = next((data / n for n in ("points.csv", "points.parquet") if (data / n).is_file()), data)
    if file.is_dir() or not file.is_file():
        return read_data(data, tests), []
    table = read_table(file)
    absent = [q for q in LOADS if q.name not in table.columns]
    if not absent or len(absent) == len(LOADS) or "mu" not in table.columns:
        return read_data(data, tests), []
    if "test_id" not in table.columns:
        table["test_id"] = "all"
    names = [q.name for q in absent]
    points = check_points(constants(table, names), str(file))
    beside = data / "tests.csv"
    listed = tests if tests is not None else beside if data.is_dir() and beside.is_file() else None
    frame = None
    if listed is not None:
        from friction_models.loads import missing_column

        frame = read_table(listed)
        if "test_id" not in frame.columns:
            raise missing_column("test_id", frame.columns, str(listed))
        frame["test_id"] = frame["test_id"].astype(str)
    info = read_info(data)
    if frame is not None and says_synthetic(frame):
        info["synthetic"] = True
    return DataSet(points, frame, info), names


def constants(points: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    """Return points with a constant for each of the loads in `names`."""
    from friction_models.loads import QUANTITIES

    return points.assign(**{n: 1.0 if n == "psi" else QUANTITIES[n].nominal for n in names})


def add_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    app.command(
        epilog="Example: tribofmu diagnose --data data --model models/linear --report diagnosis.html --plan next.csv"
    )(diagnose)
    app.command(
        epilog="Example: tribofmu refine --data data --model models/linear --add stribeck -o models/better "
        "--report refined.html"
    )(refine)
