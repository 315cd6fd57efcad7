"""The report of the learning-curve study, with the paper's numbers beside ours."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from friction_models.common.markup import bullets, escape, paragraph, table

from ...jobs.store import JobResult
from ...studies.learning_curve.jobs import AVERAGE, MEAN, SERIES
from ...studies.learning_curve.result import APART, Comparison, LearningCurves
from ...studies.learning_curve.study import COLLECTIONS, LearningCurveStudy
from ...studies.learning_curve.words import beside_paper, differs, findings, headline
from ...studies.measurements import data_name, load_measurements
from ..charts.measurements import load_space_chart, series_chart
from ..parts.chart import Chart, figure
from ..parts.page import VIRTUAL, Page, StudyManifest, footer
from ..parts.theme import CONSTANT, SOFT, looks
from .forming_error import figures

#: Errors beyond this multiple of the accuracy are cut off: a polynomial of five tests is off by any amount.
SHOWN = 2.5


def learning_curve_page(
    study: LearningCurveStudy,
    curves: LearningCurves,
    manifest: StudyManifest,
    results: Mapping[str, JobResult],
) -> str:
    """Return the HTML of the study; `results` hold the measurements, where they are there."""
    page = Page(headline(curves), "tribofmu study learning-curve", _lead(curves), curves.synthetic)
    page.add("findings", "Findings", bullets(findings(curves)))
    page.add("measured", "The two data collections", *_measured(curves, results))
    page.plot(
        "curves",
        "Learning curves",
        _overview(curves),
        f"0.95 percentile of the MAE on the held-out tests over {curves.repeats} random training sets of each size. Dashed: the "
        f"accuracy of a tribometer, {curves.accuracy:g}. Grey: the mean of the training tests, no model. Errors far "
        "above are cut off.",
        "Error over number of training tests, one panel a lubricant and data collection.",
    )
    page.plot(
        "models",
        "Model by model",
        _by_model(curves),
        "The same curves, both data collections in one panel; the band holds all repeats.",
        "Error over number of training tests, one panel a lubricant and model.",
    )
    page.add(
        "needed",
        "Tests needed",
        _needed(curves.comparisons, f"For an MAE below {curves.accuracy:g} with 95 % probability"),
        _needed(
            curves.apart,
            f"At {APART:g} times the lowest error of the model, as the paper's limit is to its own",
        ),
        _needed(curves.strict, "To come within 10 % of the lowest error of the model"),
        paragraph(
            "In brackets the 95 % interval from resampled repeats and held-out tests. The verdict needs 95 % of the resamples to agree on "
            "at least one test fewer, or more; where the smallest training set suffices with both collections it says so. The last column is the easier task: only the averages of the held-out tests "
            "have to be met, as far as average-based data goes."
        ),
    )
    page.add("lowest", "Lowest error", _lowest(curves))
    page.add(
        "paper",
        "Beside the paper",
        table(["quantity", "paper", "here"], beside_paper(curves), numeric=(1, 2)),
        bullets(differs(curves)),
        figures(
            ("a compression test over time and its average", "The two data collections"),
            ("training points of both collections over the loads", "The two data collections"),
            (
                "error over the number of tests, average-based and time-series-based",
                "Learning curves; Model by model",
            ),
            ("lowest errors of the models", "Lowest error"),
        ),
    )
    page.add("data", "Data", _data(curves))
    page.add("how", "How it was computed", bullets(_how(study)), _search(curves))
    if curves.virtual:
        origin = VIRTUAL
    elif curves.synthetic:
        origin = "The data is the user's and says of itself that it is synthetic."
    else:
        origin = "The measurements are the user's."
    return page.render(footer(origin, manifest["versions"]))


def _lead(curves: LearningCurves) -> str:
    held = ", ".join(f"{f['held_out']} held-out tests ({name})" for name, f in curves.facts.items())
    missing = f" {curves.missing} jobs have no result." if curves.missing else ""
    return escape(
        f"{len(curves.models)} friction models learn from a growing number of sliding compression tests, "
        f"{curves.repeats} random training sets of each size; the time series of {held} judge them.{missing}"
    )


def _measured(curves: LearningCurves, results: Mapping[str, JobResult]) -> list[str]:
    """Return the charts of the first lubricant whose measurements are there: the plan is the same for all."""
    for lubricant in curves.lubricants:
        found = results.get(data_name(lubricant))
        if found is None:
            continue
        series, averages = (
            load_measurements(found, averages=a).select("train").points for a in (False, True)
        )
        return [
            figure(
                "series",
                series_chart(series, averages),
                f"The training test of {escape(lubricant)} whose mu moves most: its time series and the one point that average-based "
                "data keeps of it.",
                "mu and loads over sliding distance in one test, with their averages.",
            ),
            figure(
                "loads",
                load_space_chart(series, averages),
                f"Training points of {escape(lubricant)} over the loads, time series thinned: a time series also shows what happens "
                "between the points of the plan.",
                "Points of both data collections over pairs of loads.",
            ),
        ]
    return [paragraph("The measurements are not in the folder of the study.")]


def _overview(curves: LearningCurves) -> Chart:
    """Return one panel a lubricant and data collection, all models in it."""
    titles = [f"{name}, {c}-based" for name in curves.lubricants for c in COLLECTIONS]
    chart = _panels(curves, len(COLLECTIONS), titles, horizontal_spacing=0.03)
    styles = looks(curves.models) | {MEAN: {"color": CONSTANT, "width": 1.5}}
    for row, lubricant in enumerate(curves.lubricants):
        for column, collection in enumerate(COLLECTIONS):
            panel = row * len(COLLECTIONS) + column
            for model in (MEAN, *curves.models):
                curve = curves.curve(lubricant, collection, model)
                if curve is not None:
                    chart.scatter(
                        panel, curve.sizes, curve.percentile, model, f"%{{x}} tests<br>MAE %{{y:.4f}}<extra>{model}</extra>",
                        line=styles[model], mode="lines+markers", marker={"size": 5},
                    )  # fmt: skip
    return _dressed(chart, curves, 290)


def _by_model(curves: LearningCurves) -> Chart:
    """Return one panel a lubricant and model, both collections in it."""
    titles = [f"{name}, {model}" for name in curves.lubricants for model in curves.models]
    chart = _panels(curves, max(1, len(curves.models)), titles, horizontal_spacing=0.02)
    styles = looks(COLLECTIONS)
    bands = {SERIES: "rgba(0, 114, 178, 0.14)", AVERAGE: "rgba(213, 94, 0, 0.14)"}
    for row, lubricant in enumerate(curves.lubricants):
        for column, model in enumerate(curves.models):
            panel = row * len(curves.models) + column
            for collection in COLLECTIONS:
                curve = curves.curve(lubricant, collection, model)
                if curve is None:
                    continue
                low, high = curve.errors.min(axis=0), curve.errors.max(axis=0)
                chart.band(panel, np.array(curve.sizes), low, high, bands[collection], group=collection)
                chart.scatter(
                    panel, curve.sizes, curve.percentile, f"{collection}-based",
                    f"%{{x}} tests<br>MAE %{{y:.4f}}<extra>{collection}</extra>", collection,
                    line=styles[collection], mode="lines",
                )  # fmt: skip
    _dressed(chart, curves, 230).figure.update_annotations(font_size=12)
    return chart


def _panels(curves: LearningCurves, columns: int, titles: list[str], horizontal_spacing: float) -> Chart:
    """Return panels with a row for each lubricant."""
    return Chart(
        columns, max(1, len(curves.lubricants)), titles=titles, shared_xaxes=True, shared_yaxes=True,
        horizontal_spacing=horizontal_spacing, vertical_spacing=0.1,
    )  # fmt: skip


def _dressed(chart: Chart, curves: LearningCurves, height: int) -> Chart:
    """Return the chart with the accuracy that is asked for as a line; `height` of a row."""
    line = {"color": SOFT, "width": 1.3, "dash": "dash"}
    for panel in range(chart.rows * chart.columns):
        chart.figure.add_hline(y=curves.accuracy, line=line, **chart.place(panel))
    y = "MAE of mu, 0.95 percentile"
    chart.dress(130 + height * chart.rows, x="training tests", y=y, margin_t=74)
    chart.figure.update_yaxes(range=[0.0, SHOWN * curves.accuracy])
    return chart


def _needed(found: Sequence[Comparison], caption: str) -> str:
    rows = [
        (c.lubricant, c.model, f"{c.accuracy:.4f}", c.series.text(), c.average.text(), c.verdict, c.own.text())
        for c in found
    ]  # fmt: skip
    heads = ["lubricant", "model", "MAE below", "time-series", "average", "time-series needs", "average, judged by averages"]  # fmt: skip
    return table(heads, rows, numeric=(2, 3, 4, 6), caption=caption)


def _lowest(curves: LearningCurves) -> str:
    rows = []
    for lubricant in curves.lubricants:
        for model in (*curves.models, MEAN):
            cells: list[str] = []
            for collection in COLLECTIONS:
                curve = curves.curve(lubricant, collection, model)
                if curve is None:
                    cells += ["-", "-"]
                    continue
                at = curve.converged.tests
                cells += [
                    "{:.4f} ({:.4f} - {:.4f})".format(*curve.lowest),
                    "-" if at is None else f"{math.ceil(at)}",
                ]
            rows.append((lubricant, model, *cells))
    heads = ["lubricant", "model", "time-series: lowest", "within 10 % from", "average: lowest", "within 10 % from"]  # fmt: skip
    return table(
        heads, rows, numeric=(2, 3, 4, 5), caption="Lowest 0.95 percentile of the MAE (95 % interval)"
    )


def _data(curves: LearningCurves) -> str:
    rows = [
        (
            lubricant, f["train"], f["held_out"], f["points"], f"{f['mu_mean']:.4f}", f"{f['scatter_between_tests']:.4f}",
            f"{f['scatter_within_tests']:.4f}", f"{f['mae_mean_of_training']:.4f}", f"{f['mae_own_mean_of_test']:.4f}",
        )
        for lubricant, f in curves.facts.items()
    ]  # fmt: skip
    heads = ["lubricant", "training tests", "held-out tests", "training points", "mean mu", "scatter between tests", "scatter within tests", "MAE of the training mean", "MAE of each test's own mean"]  # fmt: skip
    thinned = [
        (lubricant, model, f"{c['every_point']:.5f}", f"{c['thinned']:.5f}")
        for lubricant, f in curves.facts.items()
        for model, c in f["thinning"].items()
    ]
    shown = table(heads, rows, numeric=range(1, 9))
    if not thinned:
        return shown
    return shown + table(
        ["lubricant", "model", "every point", "thinned"],
        thinned,
        numeric=(2, 3),
        caption="What thinning costs: MAE on the held-out tests, trained on all training tests",
    )


def _how(study: LearningCurveStudy) -> list[str]:
    plan = study.plan
    return [
        f"Each of the {plan.repeats} repeats puts the training tests into a random order; its training set of n tests is the first n. "
        "Models and data collections see the same sets.",
        (
            "Time-series models learn from every point of a test."
            if plan.thin == 1
            else f"Time-series models learn from every {plan.thin}th point of a test (neighbours say the same, see the table above); "
            "the judge has every point."
        ),
        "Average-based data has one point a test: means over the distance slid, friction as mean force over mean force.",
        "ffnn: hidden layers and weight decay by grid search with 5-fold cross-validation over whole tests, once for each size "
        f"and data set on thinned series (every {plan.thin * plan.search_thin}th point); then one model of four networks for each repeat. Folds, grid and repeats are trained "
        f"together, {plan.steps} steps each whatever the size. gradient_boosting: fewest points a leaf in the same way.",
        "linear, polynomial and power_law have nothing to search and are those of `tribofmu train`.",
        "The curve is the 0.95 percentile over the repeats. The tests needed are where it falls below the limit for good, a power law "
        "between the sizes, rounded up.",
    ]


def _search(curves: LearningCurves) -> str:
    rows = [
        (c.lubricant, c.collection, c.model, size, ", ".join(f"{k} {v}" for k, v in chosen.items()))
        for c in curves.curves
        for size, chosen in zip(c.sizes, c.parameters)
        if chosen
    ]
    if not rows:
        return ""
    heads = ["lubricant", "collection", "model", "tests", "chosen"]
    inner = table(heads, rows, numeric=(3,))
    return f"<details><summary>What the searches chose</summary>{inner}</details>"
