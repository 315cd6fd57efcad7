"""`study learning-curve`: how many tests a friction model needs."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from ..common.console import say
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
    from ...report.learning_curve_page import learning_curve_page
    from ...studies.learning_curve.files import write_results
    from ...studies.learning_curve.result import LearningCurves
    from ...studies.learning_curve.study import LearningCurvePlan, LearningCurveStudy
    from ...studies.learning_curve.words import text_table
    from ...studies.measurements import chosen_data

    plan = LearningCurvePlan.quick(seed) if quick else LearningCurvePlan(seed=seed)
    study = LearningCurveStudy.of(replace(plan, accuracy=accuracy), chosen_data(data))
    campaign = study.campaign(out)
    results = run_campaign(campaign, "learning curve", jobs, scheduler, dry_run)
    if results is None:
        return
    settings = {"study": "learning-curve", **study.plan.to_dict()}
    write_manifest(campaign, results, settings, {"study": seed})
    curves = LearningCurves.of(study, results)
    if curves.curves:
        write_results(out, curves, learning_curve_page(study, curves, campaign.manifest(results), results))
        say(text_table(curves))
        say(f"report written: {out / 'report.html'}")
    campaign.check()


def add_commands(app: typer.Typer) -> None:
    """Register the command of this file."""
    app.command(
        "learning-curve", epilog="Example: tribofmu study learning-curve --quick -o studies/learning-curve"
    )(learning_curve)
