"""`study forming-error`: every friction model in every forming run, against the press."""

from __future__ import annotations

from typing import Annotated

import typer

from ..common.console import say
from ..common.files_named import Reads
from ..common.options import Jobs
from ..common.study_options import (
    DryRun,
    Lubricants,
    Quick,
    Scheduler,
    Seed,
    StudyFolder,
    run_campaign,
    write_manifest,
)


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
    from ...report.forming_error_page import forming_error_page
    from ...studies.forming_error.files import table, write_results
    from ...studies.forming_error.result import FormingErrors
    from ...studies.forming_error.study import FormingErrorStudy, Plan
    from ...studies.measurements import chosen_data
    from ...studies.press_levels import chosen_press

    plan = Plan.quick(seed) if quick else Plan.full(seed)
    study = FormingErrorStudy.of(plan, chosen_data(data), chosen_press(press))
    campaign = study.campaign(out)
    results = run_campaign(campaign, "forming error", jobs, scheduler, dry_run)
    if results is None:
        return
    settings = {"study": "forming-error", **study.settings(results)}
    write_manifest(campaign, results, settings, {"virtual_lab": seed})
    errors = FormingErrors.of(study, results)
    if errors.runs:
        write_results(out, errors, forming_error_page(study, errors, campaign.manifest(results), results))
        say(table(errors))
        say(f"report written: {out / 'report.html'}")
    campaign.check()


def add_commands(app: typer.Typer) -> None:
    """Register the command of this file."""
    app.command(
        "forming-error", epilog="Example: tribofmu study forming-error --quick -o studies/forming-error"
    )(forming_error)
