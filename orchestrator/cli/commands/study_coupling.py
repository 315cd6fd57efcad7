"""`study lag` and `study extrapolation`: what the coupling costs, and what happens beyond the trained domain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..common.console import say
from ..common.files_named import Reads
from ..common.options import Jobs
from ..common.study_options import DryRun, Quick, Scheduler, Seed, StudyFolder, run_campaign, write_manifest

if TYPE_CHECKING:
    from ...jobs.campaign import Campaign, JobResult
    from ...studies.extrapolation import ExtrapolationStudy
    from ...studies.lag import LagStudy

#: What a study found, as its JSON file holds it.
Values = dict[str, Any]
Data = Annotated[
    list[str] | None,
    typer.Option(
        "--data",
        metavar="[LUBRICANT=]DIR",
        help="Data set to train on. Default: the virtual laboratory measures.",
    ),
    Reads(),
]
Model = Annotated[
    list[str] | None,
    typer.Option(
        "--model",
        help="Family of friction models: linear, polynomial, power_law, gradient_boosting or ffnn; repeatable. Default: "
        "those of the study.",
    ),
]
Process = Annotated[
    list[str] | None,
    typer.Option("--process", help="Forming process, fre or bce; repeatable. Default: both."),
]
Stroke = Annotated[
    float | None,
    typer.Option(help="Punch travel in mm. Default: as far as a usual run goes.", min=0.1, max=100.0),
]


def lag(
    out: StudyFolder,
    data: Data = None,
    model: Model = None,
    process: Process = None,
    step: Annotated[
        list[float] | None,
        typer.Option(
            "--step",
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
    from ...report.lag_page import lag_page
    from ...studies.lag import LagStudy, table

    study = LagStudy.quick() if quick else LagStudy()
    study = replace(study, seed=seed, **_given(models=model, processes=process, steps=step, stroke=stroke))
    _carry_out("lag", study, data, out, (_lag_rows, lag_page, table), jobs, scheduler, dry_run)


def extrapolation(
    out: StudyFolder,
    data: Data = None,
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
    from ...report.extrapolation_page import extrapolation_page
    from ...studies.extrapolation import ExtrapolationStudy, table

    study = ExtrapolationStudy.quick() if quick else ExtrapolationStudy()
    study = replace(study, seed=seed, **_given(models=model, processes=process, stroke=stroke))
    shown = (_extrapolation_rows, extrapolation_page, table)
    _carry_out("extrapolation", study, data, out, shown, jobs, scheduler, dry_run)


def _carry_out(
    name: str,
    study: LagStudy | ExtrapolationStudy,
    data: list[str] | None,
    out: Path,
    shown: tuple[Callable[[Values], list[Values]], Callable[[Values], str], Callable[[Values], str]],
    jobs: int | None,
    scheduler: str | None,
    dry_run: bool,
) -> None:
    """Run a study and write what it found; `shown` makes the rows of its CSV file, its page and its text."""
    from ...jobs.campaign import Campaign

    chosen = _chosen(data)
    campaign = Campaign(out, study.jobs(chosen))
    results = run_campaign(campaign, f"study {name}", jobs, scheduler, dry_run)
    if results is None:
        return
    rows, page, table = shown
    values = study.evaluate(results, chosen)
    _write(campaign, results, values, [_flat(row) for row in rows(values)], name, page(values), study.seed)
    _finish(campaign, values, table(values))


def _given(**options: Any) -> dict[str, Any]:
    """Return the options that the user gave."""
    return {name: value for name, value in options.items() if value not in (None, [])}


def _chosen(data: list[str] | None) -> Any:
    from friction_models.common import InputError

    from ...studies.measurements import chosen_data

    chosen = chosen_data(data)
    if chosen is not None and len(chosen) > 1:
        raise InputError(
            f"--data: {len(chosen)} data sets, allowed: one, as the study compares runs of one lubricant"
        )
    return chosen


def _lag_rows(values: Values) -> list[Values]:
    rows: list[Values] = values["rows"]
    return rows


def _extrapolation_rows(values: Values) -> list[Values]:
    return [{k: v for k, v in run.items() if k != "loads"} | _by_load(run) for run in values["runs"]]


def _by_load(run: dict[str, Any]) -> dict[str, Any]:
    """Return shares outside by load as columns."""
    return {
        f"{item['load']}_{side}": item[side]["share"]
        for item in run.get("loads", [])
        for side in ("below", "above")
    }


def _flat(row: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested numbers as columns ``lag.work_pct``; measured times last."""
    flat: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _write(
    campaign: Campaign,
    results: dict[str, JobResult],
    values: dict[str, Any],
    rows: list[dict[str, Any]],
    name: str,
    page: str,
    seed: int,
) -> None:
    import pandas as pd

    from friction_models.common import write_json, write_text

    from ..common.console import plain

    write_json(campaign.folder / f"{name}.json", plain(values))
    table = pd.DataFrame(rows).assign(synthetic=values["synthetic"])
    write_text(campaign.folder / f"{name}.csv", table.to_csv(index=False, lineterminator="\n"))
    write_text(campaign.folder / "report.html", page)
    settings = {"study": name, **values["settings"], "synthetic": values["synthetic"]}
    write_manifest(campaign, results, settings, {"virtual_lab": seed})


def _finish(campaign: Campaign, values: dict[str, Any], shown: str) -> None:
    if values["synthetic"]:
        say("friction models trained on synthetic data")
    say(shown)
    say(f"report written: {campaign.folder / 'report.html'}")
    campaign.check()


def add_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    app.command(epilog="Example: tribofmu study lag --data data --model polynomial -o studies/lag")(lag)
    app.command(epilog="Example: tribofmu study extrapolation --quick -o studies/extrapolation")(
        extrapolation
    )
