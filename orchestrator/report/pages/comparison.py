"""The report of `compare`: models on tribometer tests, on press curves, in one system, or on several of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from friction_models.common.markup import bullets, escape, table
from friction_models.common.wording import counted

from ...comparison.in_one_system import RunsComparison
from ...comparison.on_press import QUANTITIES, ForcesComparison
from ...comparison.on_tests import TestsComparison
from ...comparison.order import Order
from ...force_curves.metrics import LevelSummary
from ..charts.comparison import MOST_TESTS, per_test_chart
from ..charts.force import draw_press
from ..charts.measurements import POINTS
from ..charts.responses import caption, response_chart
from ..parts.cards import with_interval
from ..parts.chart import Chart, limits
from ..parts.page import Page
from ..parts.theme import INK, looks
from ..sections.runs import add_runs

#: With more pairs only those are listed that cannot be told apart.
_PAIRS = 10
#: Fewer points than these are drawn large.
_FEW = 300


def comparison_page(
    tests: TestsComparison | None, forces: ForcesComparison | None, runs: Sequence[RunsComparison] = ()
) -> str:
    """Return the HTML of a comparison; all but one may be missing. `runs`: one a system, or one a level of a process."""
    found = [part for part in (tests, forces, *runs) if part is not None]
    page = Page("", "tribofmu compare", synthetic=any(part.synthetic for part in found))
    titles, said = list[str](), list[str]()
    if tests is not None:
        titles.append(_verdict(tests.order))
        said.append(f"{counted(tests.result.tests, 'test')}, {counted(tests.result.points, 'point')}")
        _add_tests(page, tests)
    if forces is not None:
        titles.append(_verdict(forces.orders["max_force"]))
        said.append(f"{counted(len(forces.names), 'press level')}")
        _add_forces(page, forces)
    if runs:
        loads = [total.max_force for each in runs for total in each.totals.values()]
        where = runs[0].system if len(runs) == 1 else f"{len(runs)} levels"
        span, models = f"{min(loads):.1f} to {max(loads):.1f} kN", max(len(each.totals) for each in runs)
        titles.append(f"{where}: largest force {span} with {models} models")
    for number, each in enumerate(runs, 1):
        said.append(f"{len(each.totals)} runs of {each.system}")
        add_runs(page, each, "" if len(runs) == 1 else f"-{number}")
    page.title = titles[0]
    note = "Intervals and probabilities count whole tests and levels, not points."
    if tests is None and forces is None:
        note = (
            "The press was measured at one level: what follows holds for that level."
            if any(each.press for each in runs)
            else "Nothing was measured: the runs show what the choice of the model does, not which model is right."
        )
    page.lead = escape(f"{'; '.join(said)}. {note}")
    return page.render()


def _verdict(order: Order) -> str:
    if len(order.names) < 2:
        return f"{order.names[0]}: one model"
    best, second = order.names[:2]
    if not order.judged:
        return f"{best} has the smallest error of {len(order.names)} models; too few were measured to tell models apart"
    apart = (best, second) not in order.indistinct
    share = f"best of {len(order.names)} with a probability of {order.chance(best)}"
    return f"{best} is {share}" + ("" if apart else f", not told apart from {second}")


def _add_tests(page: Page, c: TestsComparison) -> None:
    rows = []
    for name in c.order.names:
        e, share = c.result.errors[name], c.outside[name]
        rows.append(
            (
                name, with_interval(e.mae, e.mae_interval), with_interval(e.rmse, e.rmse_interval),
                with_interval(e.bias, e.bias_interval, sign="+"), "not known" if share is None else f"{100 * share:.1f}",
                c.order.chance(name), c.order.place(name, " to "),
            )
        )  # fmt: skip
    page.add(
        "errors",
        "Errors on tests",
        table(
            ["model", "MAE [95 %]", "RMSE [95 %]", "bias [95 %]", "outside its domain [%]", "probability best", "place"],
            rows, numeric=range(1, 7), caption="Place: 95 % interval over resampled sets of tests. Loads outside the trained domain of a model were "
            "moved to its border, as its FMU does by default; a model with memory got them as they are.",
        ),
        bullets(c.remarks()),
        _order_html(c.order, "tests", "RMSE of mu"),
    )  # fmt: skip
    styles = looks(c.models)
    page.plot(
        "parity",
        "Measured against predicted",
        _parity(c),
        "Points thinned evenly; the line is perfect agreement.",
        "Predicted over measured mu, one panel a model.",
    )
    page.plot(
        "response",
        "Response curves",
        response_chart(c.loads, [(n, styles[n], c.models[n]) for n in c.order.names]),
        caption(c.loads, [c.models[n] for n in c.order.names]),
        "Response curves of all models over the five loads.",
    )
    which = "" if len(c.result.per_test) <= MOST_TESTS else f", the {MOST_TESTS} worst of the best model"
    page.plot(
        "tests",
        "Test by test",
        per_test_chart(c.result.per_test, c.order.names),
        f"RMSE of each model in each test{which}.",
        "RMSE of every model in every test.",
    )


def _add_forces(page: Page, c: ForcesComparison) -> None:
    rows = []
    by = c.orders["max_force"]
    results = {r.label: r for r in c.results}
    for name in by.names:
        force, work = results[name].max_force, results[name].work
        rows.append(
            (
                name, f"{100 * force.mare:.1f} +- {100 * force.mare_std:.1f}", _spread(force),
                f"{100 * work.mare:.1f} +- {100 * work.mare_std:.1f}", _spread(work),
                *(c.orders[q].chance(name) for q in QUANTITIES),
            )
        )  # fmt: skip
    page.add(
        "force-errors",
        "Errors on press curves",
        table(
            ["model", "MARE max force [%]", "over levels [%]", "MARE work [%]", "over levels [%]", "probability best by force", "by work"],
            rows, numeric=range(1, 7), caption="MARE: mean absolute relative error over the levels, +- from the scatter of the repeats.",
        ),
        bullets(c.remarks()),
        *(_order_html(order, "levels", f"MARE of the {QUANTITIES[q]}") for q, order in c.orders.items()),
    )  # fmt: skip
    page.plot(
        "level-errors",
        "Level by level",
        _signed(c),
        "Signed error of the maximum force and of the work; bars are the scatter of the repeats.",
        "Relative error of maximum force and work by level and model.",
    )
    page.plot(
        "force-curves",
        "Force over stroke",
        _curves(c),
        "Press: mean of the repeats and their standard deviation.",
        "Force over stroke of the press and all models, one panel a level.",
    )


def _order_html(order: Order, unit: str, error: str) -> str:
    if len(order.names) < 2:
        return ""
    rows = [
        (
            f"{p['better']} before {p['worse']}", f"{p['difference']:.5f}", "{:.5f} to {:.5f}".format(*p["interval"]),
            f"{100 * p['probability']:.0f}", "yes" if p["apart"] else "no",
        )
        for p in order.pairs
        if len(order.pairs) <= _PAIRS or not p["apart"]
    ]  # fmt: skip
    shown = table(
        ["pair", "difference", "95 % interval", "probability [%]", "told apart"], rows, numeric=(1, 2, 3),
        caption=f"Order of the models by the {error} on {order.units} {unit}; the difference is that of this error"
        + ("" if len(rows) == len(order.pairs) else f"; {len(order.pairs) - len(rows)} more pairs are told apart"),
    )  # fmt: skip
    return bullets(order.sentences(unit)) + shown


def _spread(summary: LevelSummary) -> str:
    return f"{100 * summary.spread:.1f}" if summary.levels > 1 else "-"


def _parity(c: TestsComparison) -> Chart:
    names = c.order.names
    chart = Chart.of_panels(
        len(names), legend=False, titles=[escape(n) for n in names],
        shared_xaxes=True, shared_yaxes=True, horizontal_spacing=0.03,
    )  # fmt: skip
    styles = looks(c.models)
    shown = np.arange(0, len(c.mu), max(1, len(c.mu) // POINTS))
    ids = None if c.loads.test_id is None else [escape(i) for i in c.loads.test_id[shown]]
    ends = limits([c.mu, *c.predicted.values()], flat=0.005)
    for panel, name in enumerate(names):
        chart.scatter(panel, ends, ends, mode="lines", line={"color": INK, "width": 1})
        chart.scatter(
            panel, c.mu[shown], c.predicted[name][shown], mode="markers", text=ids,
            hover="%{text}<br>measured %{x:.4f}<br>predicted %{y:.4f}<extra></extra>",
            # A few points are seen only where they are large, many only where they are small.
            marker={"color": styles[name]["color"], **({"size": 6, "opacity": 0.8} if len(shown) < _FEW else {"size": 3, "opacity": 0.45})},
        )  # fmt: skip
        chart.axes(panel, range=ends)
    chart.dress(300 * chart.rows + 50, x="measured mu", y="predicted mu")
    chart.figure.update_xaxes(zeroline=False)
    chart.figure.update_yaxes(zeroline=False)
    return chart


def _signed(c: ForcesComparison) -> Chart:
    chart = Chart(rows=2, shared_xaxes=True, vertical_spacing=0.08)
    styles = looks([r.label for r in c.results])
    levels = [escape(n) for n in c.names]
    for panel, quantity in enumerate(QUANTITIES):
        for result in c.results:
            errors = [getattr(level, quantity) for level in result.levels]
            scatter = [100 * e.are_std for e in errors]
            chart.scatter(
                panel, levels, [100 * e.signed for e in errors], escape(result.label),
                "%{x}: %{y:+.1f} %<extra>%{fullData.name}</extra>", mode="markers",
                marker={"size": 9, "color": styles[result.label]["color"]},
                error_y={"type": "data", "array": scatter, "width": 3, "thickness": 1},
            )  # fmt: skip
    chart.dress(460, y=[f"{words} [%]" for words in QUANTITIES.values()])
    chart.figure.update_xaxes(type="category")
    return chart


def _curves(c: ForcesComparison) -> Chart:
    titles = [escape(n) for n in c.names]
    chart = Chart.of_panels(len(titles), gap=0.2, titles=titles, horizontal_spacing=0.06)
    styles = looks([r.label for r in c.results])
    for panel in range(len(titles)):
        draw_press(chart, panel, c.results[0].levels[panel])
        for result in c.results:
            level = result.levels[panel]
            chart.scatter(
                panel, level.stroke, level.simulated, escape(result.label),
                "%{y:.1f} kN<extra>%{fullData.name}</extra>", line=styles[result.label],
            )  # fmt: skip
        if panel + chart.columns >= len(titles):
            chart.axes(panel, x="stroke [mm]")
    return chart.dress(260 * chart.rows + 70, y="punch force [kN]", margin_t=66)
