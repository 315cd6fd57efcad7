"""`study`: the paper's studies, resumable, on all cores or on a cluster."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from friction_models.common import InputError, inert, write_json

from ..common.console import keeping, progress, say
from ..common.files_named import Commands, Reads, Writes
from ..common.options import Jobs

if TYPE_CHECKING:
    from ...jobs.graph import JobGraph, JobResult
    from ...studies.study import Study, StudyPlan

    Results = dict[str, JobResult]

#: Failed jobs that are listed one by one.
LISTED = 10

app = Commands(
    name="study",
    help="The paper's studies: resumable, on all cores or on a cluster.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    epilog="Example: tribofmu study learning-curve --quick -o studies/learning-curve",
)


def _each_once(option: typer.CallbackParam, values: list[Any] | None) -> list[Any] | None:
    """Refuse a value of a repeatable option that was given twice."""
    for value in values or []:
        if (values or []).count(value) > 1:
            raise InputError(f"{option.opts[0]} {value}: given twice; allowed: each value once")
    return values


StudyFolder = Annotated[
    Path,
    typer.Option("-o", "--out", help="Folder of the study; what is there already is not computed again."),
    Writes("STUDY"),
]
Lubricants = Annotated[
    list[str] | None,
    typer.Option(
        "--data",
        metavar="[LUBRICANT=]DIR",
        help="Data set to train on; learning-curve and forming-error take one for each lubricant. Default: the virtual laboratory "
        "measures.",
    ),
    Reads(),
]
Seed = Annotated[
    int, typer.Option(min=0, help="Seed of the virtual laboratory, of training sets and of models.")
]
Quick = Annotated[bool, typer.Option("--quick", help="A small size that shows the way, under two minutes.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Only count the jobs and estimate the time.")]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="tcp://HOST:PORT",
        help="Run the jobs on a dask.distributed cluster whose workers see the folder, too.",
    ),
]
Model = Annotated[
    list[str] | None,
    typer.Option(
        "--model",
        callback=_each_once,
        help="Family of friction models: linear, polynomial, power_law, gradient_boosting or ffnn; repeatable. Default: "
        "those of the study.",
    ),
]
Process = Annotated[
    list[str] | None,
    typer.Option(
        "--process", callback=_each_once, help="Forming process, fre or bce; repeatable. Default: both."
    ),
]
Stroke = Annotated[
    float | None,
    typer.Option(help="Punch travel in mm. Default: as far as a usual run goes.", min=0.1, max=100.0),
]


@app.command(
    "learning-curve", epilog="Example: tribofmu study learning-curve --quick -o studies/learning-curve"
)
def learning_curve(
    out: StudyFolder,
    data: Lubricants = None,
    seed: Seed = 0,
    accuracy: Annotated[
        float, typer.Option(min=1e-5, max=1.0, help="Error in mu that is asked for (changes no job).")
    ] = 0.01,
    quick: Quick = False,
    dry_run: DryRun = False,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
) -> None:
    """How many compression tests five friction models need, time-series-based against average-based.

    The training set grows in steps, ten random repeats a size; the curve is the 0.95 percentile of the MAE on the
    held-out tests. A second run computes only what changed.
    """
    from ...report.registry import page_of
    from ...studies.learning_curve.files import write_results
    from ...studies.learning_curve.result import LearningCurves
    from ...studies.learning_curve.study import LearningCurvePlan, LearningCurveStudy
    from ...studies.learning_curve.words import text_table
    from ...studies.measurements import chosen_data

    plan = LearningCurvePlan.quick(seed) if quick else LearningCurvePlan(seed=seed)
    study = LearningCurveStudy.of(replace(plan, accuracy=accuracy), chosen_data(data))

    def written(graph: JobGraph, results: Results) -> str:
        curves = LearningCurves.of(study, results)
        if not curves.curves:
            return ""
        write_results(out, curves, page_of("learning-curve", study, curves, graph.manifest(results), results))
        return text_table(curves)

    carry_out(study, out, written, jobs, scheduler, dry_run, "learning curve")


@app.command("forming-error", epilog="Example: tribofmu study forming-error --quick -o studies/forming-error")
def forming_error(
    out: StudyFolder,
    data: Lubricants = None,
    press: Annotated[
        list[str] | None,
        typer.Option(
            "--press",
            metavar="[LUBRICANT=]DIR",
            help="Folder of press curves of the same lubricants, repeated for several.",
        ),
        Reads(),
    ] = None,
    seed: Seed = 0,
    quick: Quick = False,
    dry_run: DryRun = False,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
) -> None:
    """Errors of maximum force and work of five friction models and constant friction, at nine levels.

    252 pairs of friction law and press level; a second run computes only what changed.
    """
    from ...report.registry import page_of
    from ...studies.forming_error.files import write_results
    from ...studies.forming_error.result import FormingErrors
    from ...studies.forming_error.study import FormingErrorStudy, Plan
    from ...studies.forming_error.words import text_table
    from ...studies.measurements import chosen_data
    from ...studies.press_levels import chosen_press

    plan = Plan.quick(seed) if quick else Plan.full(seed)
    study = FormingErrorStudy.of(plan, chosen_data(data), chosen_press(press))

    def written(graph: JobGraph, results: Results) -> str:
        errors = FormingErrors.of(study, results)
        if not errors.runs:
            return ""
        write_results(out, errors, page_of("forming-error", study, errors, graph.manifest(results), results))
        return text_table(errors)

    carry_out(study, out, written, jobs, scheduler, dry_run, "forming error")


@app.command(epilog="Example: tribofmu study lag --data data --model polynomial -o studies/lag")
def lag(
    out: StudyFolder,
    data: Lubricants = None,
    model: Model = None,
    process: Process = None,
    step: Annotated[
        list[float] | None,
        typer.Option(
            "--step",
            callback=_each_once,
            help="Communication step in mm; repeatable, each divides the longest. Default: 0.05 0.1 0.2 0.4 0.8.",
        ),
    ] = None,
    stroke: Stroke = None,
    seed: Seed = 0,
    quick: Quick = False,
    dry_run: DryRun = False,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
) -> None:
    """Say what one-step lag costs against iterated coupling as the communication step grows."""
    from ...report.registry import page_of
    from ...studies.lag.result import evaluate, write_results
    from ...studies.lag.study import LagPlan, LagStudy
    from ...studies.lag.words import text_table
    from ...studies.measurements import chosen_data

    given = _given(models=model, processes=process, steps=step, stroke=stroke)
    plan = replace(LagPlan.quick() if quick else LagPlan(), seed=seed, **given)
    study = LagStudy.of(plan, chosen_data(data))

    def written(graph: JobGraph, results: Results) -> str:
        numbers = evaluate(study, results)
        write_results(out, numbers, page_of("lag", numbers))
        return text_table(numbers)

    carry_out(study, out, written, jobs, scheduler, dry_run)


@app.command(epilog="Example: tribofmu study extrapolation --quick -o studies/extrapolation")
def extrapolation(
    out: StudyFolder,
    data: Lubricants = None,
    model: Model = None,
    process: Process = None,
    stroke: Stroke = None,
    seed: Seed = 0,
    quick: Quick = False,
    dry_run: DryRun = False,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
) -> None:
    """Say how friction models behave in forming where the loads leave the domain that they were trained on."""
    from ...report.registry import page_of
    from ...studies.extrapolation.result import evaluate, write_results
    from ...studies.extrapolation.study import ExtrapolationPlan, ExtrapolationStudy
    from ...studies.extrapolation.words import text_table
    from ...studies.measurements import chosen_data

    given = _given(models=model, processes=process, stroke=stroke)
    plan = replace(ExtrapolationPlan.quick() if quick else ExtrapolationPlan(), seed=seed, **given)
    study = ExtrapolationStudy.of(plan, chosen_data(data))

    def written(graph: JobGraph, results: Results) -> str:
        numbers = evaluate(study, results)
        write_results(out, numbers, page_of("extrapolation", numbers))
        return text_table(numbers)

    carry_out(study, out, written, jobs, scheduler, dry_run)


def carry_out(
    study: Study[StudyPlan],
    folder: Path,
    written: Callable[[JobGraph, Results], str],
    jobs: int | None,
    scheduler: str | None,
    dry_run: bool,
    title: str | None = None,
) -> None:
    """Run the jobs of a study and write its manifest; a dry run only counts them.

    `written` writes what was found and returns it as text, empty where nothing was found.
    """
    graph, title = study.graph(folder), title or f"study {study.name}"
    if dry_run:
        say(f"{title}: {graph.dry_run(jobs, scheduler).report()}")
        return
    kept = f"the finished jobs are kept in {folder}; the same command goes on from there"
    with keeping(lambda: kept), progress(title, says_time=True) as tick:
        results = graph.run(jobs, scheduler, tick)
    for failure in list(graph.failed.values())[:LISTED]:
        typer.echo(inert(f"failed: {failure.job.name}: {failure.error}"), err=True)
    if len(graph.failed) > LISTED:
        more = len(graph.failed) - LISTED
        typer.echo(f"failed: {more} more, all in {folder / 'failed.json'}", err=True)
    settings = {"study": study.name, **study.settings(results)}
    write_json(folder / "manifest.json", graph.manifest(results, settings, {study.seeds: study.plan.seed}))
    text = written(graph, results)
    if text:
        say(text)
        say(f"report written: {folder / 'report.html'}")
    graph.check()


def _given(**options: Any) -> dict[str, Any]:
    """Return the options that the user gave."""
    return {name: value for name, value in options.items() if value not in (None, [])}
