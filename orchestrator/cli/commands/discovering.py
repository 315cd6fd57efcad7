"""`diagnose`, `refine`: which effect a model is missing, adding it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_models.common import InputError
from friction_models.common.processes.stages import Stages

from ..common.console import built_page, keeping, progress, say, write_result
from ..common.files_named import Commands, Reads, Writes
from ..common.options import (
    Isolate,
    Json,
    Names,
    NextTests,
    OutFolder,
    Report,
    Tests,
    any_model,
    as_number,
    given_names,
    learning_part,
    read_data,
)
from .modelling import Interval, add_interval

if TYPE_CHECKING:
    from friction_models.discovery.further_tests.next_tests import NextTest
    from friction_models.loads import DataSet

app = Commands(rich_markup_mode="rich")

Campaigns = Annotated[
    list[Path],
    typer.Option(
        "--data",
        help="Data set: a folder with points.csv, or a CSV or Parquet file. Several: the first campaign and further "
        "tests, judged together.",
    ),
]


@app.command(
    epilog="Example: tribofmu diagnose --data data --model models/linear --report diagnosis.html --plan next.csv"
)
def diagnose(
    data: Campaigns,
    model: Annotated[
        str,
        typer.Option(help="Model folder, .fmu or .onnx file, number (constant mu) or name of a family."),
        Reads(),
    ],
    tests: Tests = None,
    seed: Annotated[
        int, typer.Option(min=0, help="Seed of the bootstrap, and of how the tests are dealt to folds.")
    ] = 0,
    json: Json = None,
    report: Report = None,
    plan: NextTests = None,
    after: Annotated[
        Path | None,
        typer.Option(help="An earlier answer (--json) of fewer tests: shows what the new tests changed."),
    ] = None,
    names: Names = None,
    isolate: Isolate = None,
) -> None:
    """Say which physical effect the model is missing: or that nothing is, or that the data cannot tell."""
    from friction_models.discovery import diagnose as search
    from friction_models.discovery.answer.changes import changes_text, read_diagnosis

    earlier = None if after is None else read_diagnosis(after)
    friction = any_model(model, given_names([model], names))
    dataset = read_campaigns(data, tests)
    part = learning_part(dataset, ", ".join(map(str, data)))
    with keeping(), progress("diagnose") as tick:
        stages = Stages(tick)
        searching = stages.part(60 if report else 100)
        result = search(part.points, part.tests, model=friction, seed=seed, progress=searching)
        write = built_page(None, "diagnosis")
        if report:
            from ...report.pages.diagnosis import confirmed_addition

            stages(60, "before and after")
            confirmed = confirmed_addition(friction, part, result.effects)
            stages(75, "page of the answer")
            held_out = dataset.points["test_id"].nunique() - part.points["test_id"].nunique()
            write = built_page(report, "diagnosis", result, model, confirmed, held_out)
            stages(100, "the answer")
    say(result.report())
    if earlier is not None:
        say(changes_text(earlier, result))
    # All is computed: an interrupt before leaves no file, so none of an answer beside one of another.
    write_result(json, {"synthetic": result.synthetic, **result.to_dict()})
    write()
    if plan is not None:
        _write_plan(plan, result.next_tests)


def _write_plan(plan: Path, next_tests: list[NextTest]) -> None:
    from friction_models.discovery.further_tests.next_tests import plan_rows

    from ...prediction.plan_file import missing_settings, write_plan

    rows = plan_rows(next_tests)
    if not rows:
        say("no plan written: no test within the tested range is expected to tell more")
        return
    write_plan(plan, rows)
    absent = missing_settings(rows)
    todo = f"; fill in {', '.join(absent)} first: the data do not hold them" if absent else ""
    say(f"plan written: {plan} ({len(rows)} tests{todo})")


@app.command(
    epilog="Example: tribofmu refine --data data --model models/linear --add stribeck -o models/better "
    "--report refined.html"
)
def refine(
    data: Campaigns,
    model: Annotated[str, typer.Option(help="Model folder or name of a family."), Reads()],
    add: Annotated[
        list[str],
        typer.Option(
            "--add",
            help="Effect to add, again for each further one; factor:COLUMN for a column of the test table.",
        ),
    ],
    out: Annotated[OutFolder, Writes("MODEL")],
    tests: Tests = None,
    force: Annotated[
        bool, typer.Option("--force", help="Keep an addition that makes tests not seen in the fit worse.")
    ] = False,
    report: Report = None,
    interval: Interval = True,
) -> None:
    """Add physical effects to a model, refit everything together and save the new model.

    The addition is judged by whole tests that the fit did not see: those held out, else by cross-validation. An
    addition that clearly makes them worse is refused. Every round is kept with the model and shown.
    """
    from friction_models import evaluate
    from friction_models.discovery import refine as improve
    from friction_models.discovery.refinement_rounds import fault_note, history_text
    from friction_models.effects import known_effect, make_effect

    for name in add:
        several = name.split(",")
        if len(several) > 1 and all(map(known_effect, several)):
            raise InputError(
                f"--add {name}: several effects; allowed: {' '.join(f'--add {n}' for n in several)}"
            )
        make_effect(name)
    number = as_number(model) is not None and not Path(model).is_dir()
    if number or Path(model).suffix == ".fmu":
        kind = "a number" if number else "an FMU"
        raise InputError(f"{model}: {kind} is a fixed law; allowed: a model folder or the name of a family")
    friction = any_model(model)
    dataset = read_campaigns(data, tests)
    # Without this the tests that are held out would be fitted, and shown as unseen.
    learning_part(dataset, ", ".join(map(str, data)))
    said: list[str] = []
    with keeping(), progress("refine") as tick:
        stages = Stages(tick)
        fitting = stages.part(25)
        better = improve(
            dataset.points, dataset.tests, model=friction, add=add, force=force, progress=fitting
        )
        stages(25, "errors")
        if friction.is_fitted:
            said.append(evaluate(friction, dataset, name=f"before: {model}").report())
        result = evaluate(better, dataset, name=f"after: {model} + {' + '.join(add)}")
        for role, measures in result.roles.items():
            better.record_errors(role, measures)
        note = fault_note(better)
        said += [result.report(), *([f"{note}\n"] if note else []), history_text(better.error_history_)]
        if interval:
            stages(30, "prediction interval")
            said.append(add_interval(better, dataset))
        stages(75, "page of the answer")
        if report and not friction.is_fitted:
            friction = improve(dataset.points, dataset.tests, model=friction)
        write = built_page(report, "refinement", friction, better, dataset, model)
        stages(100, "the model")
    for text in said:
        say(text)
    better.save(out)
    say(f"model written: {out}")
    write()


def read_campaigns(data: list[Path], tests: Path | None) -> DataSet:
    """Read one data set, or several as one, and say what was changed to join them."""
    if len(data) == 1:
        return _in_order(read_data(data[0], tests))
    if tests is not None:
        raise InputError(
            f"--tests {tests}: beside {len(data)} --data; allowed: folders that hold their tests.csv"
        )
    known: dict[Path, Path] = {}
    for path in data:
        if path.resolve() in known:
            raise InputError(f"--data {path}: given twice; allowed: each campaign once")
        known[path.resolve()] = path
    from friction_models.discovery.further_tests.joined import join_campaigns

    names = [p.name for p in known]
    parts = {
        full.name if names.count(full.name) == 1 else str(path): _in_order(read_data(path))
        for full, path in known.items()
    }
    dataset, remarks = join_campaigns(parts)
    for remark in remarks:
        say(remark)
    return dataset


def _in_order(dataset: DataSet) -> DataSet:
    """Return the data set; its points must have an order, since effects with memory are among those looked for."""
    if dataset.points["test_id"].nunique() > 1:
        dataset.require_order()
    return dataset
