"""The report of the forming-error study, with the paper's numbers beside ours."""

from __future__ import annotations

from collections.abc import Mapping

from friction_models.common.markup import bullets, escape, paragraph, table
from friction_models.common.wording import listed

from ...comparison.on_press import QUANTITIES
from ...jobs.store import JobResult
from ...studies.forming_error.result import TAU_OVER_K, FormingErrors, held_out
from ...studies.forming_error.study import FormingErrorStudy
from ...studies.forming_error.words import beside_paper, differs, findings, headline, percent
from ..charts.forming_error import (
    UNITS,
    absolute_bars,
    error_bars,
    force_charts,
    group_title,
    groups,
    level_map,
    share_bars,
)
from ..charts.measurements import parity_chart
from ..parts.chart import figure
from ..parts.page import VIRTUAL, Page, StudyManifest, footer


def forming_error_page(
    study: FormingErrorStudy,
    errors: FormingErrors,
    manifest: StudyManifest,
    results: Mapping[str, JobResult],
) -> str:
    """Return the HTML of the study; `results` hold models and measurements, where they are there."""
    page = Page(headline(errors), "tribofmu study forming-error", _lead(study, errors), errors.synthetic)
    shown = figures(
        ("force over stroke, measured and simulated", "Force over stroke"),
        ("absolute errors by level", "Level by level, in kN and J"),
        (
            "relative errors, their mean and standard deviation by friction model",
            "Error of the maximum force; Error of the forming work",
        ),
        ("run time of the friction models", "Run time of friction"),
        ("predicted against measured mu", "Models and where they were asked"),
    )
    page.add("findings", "Findings", bullets(findings(errors)))
    page.add(
        "paper",
        "Beside the paper",
        table(["quantity", "paper", "here"], beside_paper(errors), numeric=(1, 2)),
        bullets(differs(study, errors)),
        shown,
    )
    page.add("mare", "Error of the maximum force", *_bars(errors, "max_force"), _summary_table(errors))
    page.add("work", "Error of the forming work", *_bars(errors, "work"))
    page.add("levels", "Level by level", *(_map(errors, quantity) for quantity in QUANTITIES))
    page.add(
        "absolute", "Level by level, in kN and J", *(_absolute(errors, quantity) for quantity in QUANTITIES)
    )
    page.add("curves", "Force over stroke", *(_curves(errors, *group) for group in groups(errors)))
    highest = max((100 * r.friction_share for r in errors.runs), default=0.0)
    verdict = "every run is below 1 %" if highest < 1.0 else "not every run is below 1 %"
    page.plot(
        "time",
        "Run time of friction",
        share_bars(errors, "time"),
        "Time in the friction FMU over the time of everything else in the stepping loop, mean over the runs; the bar reaches to the largest.",
        "Bars of the share of friction in the run time",
        paragraph(
            f"Largest share of a single run: {highest:.2f} %; {verdict}. Measured in the jobs of the study, beside which others may have run."
        ),
    )
    page.plot(
        "tau",
        "Friction stress and shear yield stress",
        share_bars(errors, "tau"),
        "Highest friction stress of any contact point in any run over the shear yield stress there.",
        "Bars of the highest friction stress over shear yield stress",
        paragraph(_stress(errors)),
    )
    page.add("models", "Models and where they were asked", *_models(study, errors, results))
    page.add("how", "How it was computed", _how(study, manifest))
    origin = "Tests and press curves are the user's."
    if study.virtual:
        origin = VIRTUAL
    elif errors.synthetic:
        origin += " They say of themselves that they are synthetic, in part or all."
    return page.render(footer(origin, manifest["versions"]))


def figures(*rows: tuple[str, str]) -> str:
    """Return the table of what the paper's figures show and where it is in a report."""
    return table(
        ["what the paper's figures show, as far as its text says", "section here"],
        rows,
        caption="The figures themselves are not at hand, so numbers 2 - 6 and 9 - 11 cannot be matched one to one",
    )


def _lead(study: FormingErrorStudy, errors: FormingErrors) -> str:
    levels = len({(r.lubricant, r.level) for r in errors.runs})
    lubricants = listed(errors.lubricants)
    repeats = max((r.force.max_force.measured.repeats for r in errors.runs), default=0)
    missing = f" {errors.missing} pairs have no result." if errors.missing else ""
    return escape(
        f"{len(errors.runs)} pairs of friction law and press level: {len(errors.frictions)} friction laws at {levels} levels "
        f"({lubricants}; forward rod extrusion and backward cup extrusion, tool temperature by speed), each against "
        f"{repeats} strokes of the press. Friction comes from an FMU in every run, one increment behind the forming FMU.{missing}"
    )


def _bars(errors: FormingErrors, quantity: str) -> list[str]:
    words = QUANTITIES[quantity]
    mare = figure(
        f"{quantity}-mare",
        error_bars(errors, quantity, "mare"),
        f"MARE of the {words}: mean over the levels of |simulated / measured - 1|; bars: Gaussian propagation of the scatter of the press.",
        f"Bars of the mean error of the {words} by friction law",
    )
    spread = figure(
        f"{quantity}-std",
        error_bars(errors, quantity, "spread"),
        "Its standard deviation over the levels: how evenly a friction law errs.",
        f"Bars of the standard deviation of the error of the {words}",
    )
    return [mare, spread]


def _summary_table(errors: FormingErrors) -> str:
    rows = []
    for s in errors.summaries():
        level = s.max_force
        where = group_title(s.lubricant, s.process) if s.lubricant and s.process else "all"
        spread = percent(level.spread, level.spread_std) if level.levels > 1 else "-"
        mare = percent(level.mare, level.mare_std)
        rows.append((where, s.friction, s.levels, mare, spread, percent(s.work.mare, s.work.mare_std)))
    headings = ["of", "friction", "over", "MARE", "standard deviation", "MARE of the work"]
    return f"<details><summary>All numbers</summary>{table(headings, rows, numeric=(2, 3, 4, 5))}</details>"


def _map(errors: FormingErrors, quantity: str) -> str:
    words = QUANTITIES[quantity]
    return figure(
        f"map-{quantity}",
        level_map(errors, quantity),
        f"{_capital(words)}, simulated against the mean of the press in percent; orange: too high, blue: too low. Columns: tool temperature, and punch speed in mm/s below it.",
        f"Signed error of the {words} by level and friction law",
    )


def _absolute(errors: FormingErrors, quantity: str) -> str:
    words = f"{QUANTITIES[quantity]} in {UNITS[quantity]}"
    return figure(
        f"absolute-{quantity}",
        absolute_bars(errors, quantity),
        f"Absolute error of the {words} |simulated - mean of the press| at every level; bars: scatter of the press. Columns as above.",
        f"Bars of the absolute error of the {words} by level and friction law",
    )


def _curves(errors: FormingErrors, lubricant: str, process: str) -> str:
    title = group_title(lubricant, process)
    chart = figure(
        f"force-{lubricant}-{process}",
        force_charts(errors, lubricant, process),
        f"{_capital(title)}: mean of the press with one standard deviation, constant friction dashed.",
        f"Force over stroke at every level, {title}",
    )
    apart = figure(
        f"difference-{lubricant}-{process}",
        force_charts(errors, lubricant, process, difference=True),
        "Simulated minus the mean of the press.",
        f"Difference of the force from the press over stroke at every level, {title}",
    )
    return f"<h3>{escape(title)}</h3>{chart}{apart}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _stress(errors: FormingErrors) -> str:
    above = [r for r in errors.runs if r.tau_over_k >= TAU_OVER_K]
    if not above:
        return "All runs stay below 60 % as in the paper, so friction stays in the range where a coefficient has a meaning."
    laws = ", ".join(dict.fromkeys(r.friction for r in above))
    return (
        f"{len(above)} of {len(errors.runs)} runs reach 60 % or more somewhere ({laws}): there a coefficient of friction begins "
        "to lose its meaning."
    )


def _models(study: FormingErrorStudy, errors: FormingErrors, results: Mapping[str, JobResult]) -> list[str]:
    found = held_out(study, results)
    parity = figure(
        "parity",
        parity_chart(found),
        "mu of the held-out tests, predicted over measured, thinned evenly; the line is perfect agreement.",
        "Predicted over measured mu, one panel a model",
    ) if found else ""  # fmt: skip
    rows = []
    for model in errors.models:
        runs = errors.of_group(model["family"], model["lubricant"])
        shares = [r.outside for r in runs if r.outside is not None]
        outside = f"{100 * sum(shares) / len(shares):.0f} %" if shares else "-"
        mae = "-" if model["mae_test"] is None else f"{model['mae_test']:.4f}"
        rows.append((model["family"], model["lubricant"], model["tests"], model["points"], mae, outside))
    headings = ["model", "lubricant", "tests", "points", "MAE of mu, held-out tests", "contact outside its domain"]  # fmt: skip
    return [
        table(headings, rows, numeric=(2, 3, 4, 5)),
        parity,
        paragraph("Outside its domain a model is asked at the nearest point inside (clamped)."),
    ]


def _how(study: FormingErrorStudy, manifest: StudyManifest) -> str:
    plan = study.plan
    source = (
        f"virtual laboratory, plan {plan.tests}, seed {plan.seed}, {plan.repeats} strokes of the press a level"
        if study.virtual
        else "the user's tests and press curves"
    )
    travel: dict[str, list[float]] = {}
    for item in study.levels:
        travel.setdefault(item.level.process, []).append(item.level.stroke)
    strokes = ", ".join(
        f"{name} {' to '.join(dict.fromkeys(f'{s:g}' for s in (min(all_), max(all_))))} mm"
        for name, all_ in travel.items()
    )
    return bullets(
        [
            f"Measurements: {source}.",
            "Training: time-series data, whole tests; every trained model as a native FMU.",
            f"Forming: punch travel {strokes}, 0.1 mm between two exchanges, one-step lag.",
            f"{len(manifest['jobs'])} jobs with results, {len(manifest['failed'])} without; hashes of all in manifest.json.",
            f"Sources {manifest['sources']['sha256'][:16]}; all runs in runs.csv, summaries in summary.csv and forming-error.json.",
        ]
    )
