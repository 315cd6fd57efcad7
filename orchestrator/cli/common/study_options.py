"""What all studies share on the command line: their options, and running a campaign."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_models.common import inert

from .console import keeping, progress, say
from .files_named import Reads, Writes

if TYPE_CHECKING:
    from ...jobs.campaign import Campaign, JobResult
    from ...studies.study import Study, StudyPlan

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
        help="Data set of a lubricant, repeated for each (default: the virtual laboratory).",
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

#: Failed jobs that are listed one by one.
LISTED = 10


def carry_out(
    study: Study[StudyPlan],
    folder: Path,
    written: Callable[[Campaign, dict[str, JobResult]], str],
    jobs: int | None,
    scheduler: str | None,
    dry_run: bool,
    title: str | None = None,
) -> None:
    """Run the jobs of a study and write its manifest; a dry run only counts them.

    `written` writes what was found and returns it as text, empty where nothing was found.
    """
    from friction_models.common import write_json

    campaign = study.campaign(folder)
    results = _run(campaign, title or f"study {study.name}", jobs, scheduler, dry_run)
    if results is None:
        return
    settings = {"study": study.name, **study.settings(results)}
    write_json(folder / "manifest.json", campaign.manifest(results, settings, {study.seeds: study.plan.seed}))
    text = written(campaign, results)
    if text:
        say(text)
        say(f"report written: {folder / 'report.html'}")
    campaign.check()


def _run(
    campaign: Campaign, title: str, jobs: int | None, scheduler: str | None, dry_run: bool
) -> dict[str, JobResult] | None:
    """Run a campaign with its progress shown; None for a dry run, which prints its counts.

    Jobs that failed are listed on stderr.
    """
    if dry_run:
        say(f"{title}: {campaign.dry_run(jobs, scheduler).report()}")
        return None

    def what_is_kept() -> str:
        return f"the finished jobs are kept in {campaign.folder}; the same command goes on from there"

    with keeping(what_is_kept), progress(title, says_time=True) as tick:
        results = campaign.run(jobs, scheduler, tick)
    for failure in list(campaign.failed.values())[:LISTED]:
        typer.echo(inert(f"failed: {failure.job.name}: {failure.error}"), err=True)
    if len(campaign.failed) > LISTED:
        more = len(campaign.failed) - LISTED
        typer.echo(f"failed: {more} more, all in {campaign.folder / 'failed.json'}", err=True)
    return results
