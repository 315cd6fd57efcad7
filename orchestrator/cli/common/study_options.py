"""What all studies share on the command line: their options, and running a campaign."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .console import keeping, progress, say
from .files_named import Reads, Writes

if TYPE_CHECKING:
    from ...jobs.campaign import Campaign, JobResult

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

#: Failed jobs that are shown one by one.
SHOWN = 10


def run_campaign(
    campaign: Campaign, title: str, jobs: int | None, scheduler: str | None, dry_run: bool
) -> dict[str, JobResult] | None:
    """Run a campaign with its progress shown; None for a dry run, which prints its counts.

    Jobs that failed are listed on stderr; call `Campaign.check` when everything else is written.
    """
    if dry_run:
        say(f"{title}: {campaign.dry_run(jobs, scheduler).report()}")
        return None

    def kept() -> str:
        return f"the finished jobs are kept in {campaign.folder}; the same command goes on from there"

    with keeping(kept), progress(title, says_time=True) as tick:
        results = campaign.run(jobs, scheduler, tick)
    for failure in list(campaign.failed.values())[:SHOWN]:
        typer.echo(f"failed: {failure.job.name}: {failure.error}", err=True)
    if len(campaign.failed) > SHOWN:
        more = len(campaign.failed) - SHOWN
        typer.echo(f"failed: {more} more, all in {campaign.folder / 'failed.json'}", err=True)
    return results


def write_manifest(
    campaign: Campaign,
    results: Mapping[str, JobResult],
    settings: Mapping[str, Any],
    seeds: Mapping[str, int],
) -> None:
    """Write ``manifest.json`` into the folder of the study."""
    from friction_models.common import write_json

    write_json(campaign.folder / "manifest.json", campaign.manifest(results, settings, seeds))
