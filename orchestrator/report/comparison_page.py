"""The report of `compare`: models on tribometer tests, on press curves, in one system, or on several of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from friction_models.loads import FloatArray

from ..comparison.in_one_system import RunsComparison
from ..comparison.on_press import QUANTITIES, ForcesComparison
from ..comparison.on_tests import Order, TestsComparison
from ..force_curves.metrics import LevelSummary
from .charts.responses import CAPTION, response_chart
from .parts.markup import bullets, escape, table
from .parts.page import Page, figure
from .parts.palette import looks
from .parts.theme import INK, PRESS, PRESS_BAND, dress
from .sections.runs import add_runs

#: Most points of a parity plot, and most tests of the dot chart.
_POINTS, _TESTS = 2500, 40
#: With more pairs only those are listed that cannot be told apart.
_PAIRS = 10
_COLUMNS = 3


def comparison_page(
    tests: TestsComparison | None, forces: ForcesComparison | None, runs: RunsComparison | None = None
) -> str:
    """Return the HTML of a comparison; all but one may be missing."""
    found = [part for part in (tests, forces, runs) if part is not None]
    page = Page(
        title=_title(tests, forces, runs),
        kicker="tribofmu compare",
        lead=escape(_lead(tests, forces, runs)),
        synthetic=any(part.synthetic for part in found),
    )
    if tests is not None:
        _add_tests(page, tests)
    if forces is not None:
        _add_forces(page, forces)
    if runs is not None:
        add_runs(page, runs)
    return page.render()


def _title(
    tests: TestsComparison | None, forces: ForcesComparison | None, runs: RunsComparison | None
) -> str:
    if tests is None and forces is None and runs is not None:
        loads = [total.max_force for total in runs.totals.values()]
        return (
            f"{runs.system}: largest force {min(loads):.1f} to {max(loads):.1f} kN with {len(loads)} models"
        )
    order = tests.order if tests is not None else forces.orders["max_force"] if forces is not None else None
    assert order is not None
    if len(order.names) < 2:
        return f"{order.names[0]}: one model"
    best, second = order.names[:2]
    apart = (best, second) not in order.indistinct
    share = f"best of {len(order.names)} with a probability of {100 * order.best[best]:.0f} %"
    return f"{best} is {share}" + ("" if apart else f", not told apart from {second}")


def _lead(tests: TestsComparison | None, forces: ForcesComparison | None, runs: RunsComparison | None) -> str:
    parts = []
    if tests is not None:
        parts.append(f"{tests.result.tests} tests, {tests.result.points} points")
    if forces is not None:
        parts.append(f"{len(forces.names)} press level{'s' if len(forces.names) != 1 else ''}")
    if runs is not None:
        parts.append(f"{len(runs.totals)} runs of {runs.system}")
    if tests is None and forces is None:
        return f"{parts[0]}. Nothing was measured: the runs show what the choice of the model does, not which model is right."
    return "; ".join(parts) + ". Intervals and probabilities count whole tests and levels, not points."


def _add_tests(page: Page, c: TestsComparison) -> None:
    rows = []
    for name in c.order.names:
        e, share = c.result.errors[name], c.outside[name]
        low, high = c.order.ranks[name]
        rows.append(
            (
                name, _interval(e.mae, e.mae_interval), _interval(e.rmse, e.rmse_interval),
                _interval(e.bias, e.bias_interval, "+"), "not known" if share is None else f"{100 * share:.1f}",
                f"{100 * c.order.best[name]:.0f}", f"{low}" if low == high else f"{low} to {high}",
            )
        )  # fmt: skip
    page.add(
        "errors",
        "Errors on tests",
        table(
            ["model", "MAE [95 %]", "RMSE [95 %]", "bias [95 %]", "outside its domain [%]", "probability best [%]", "place"],
            rows, numeric=range(1, 7), caption="Place: 95 % interval over resampled sets of tests. Loads outside the trained domain of a model were "
            "moved to its border, as its FMU does by default; a model with memory got them as they are.",
        ),
        bullets(c.remarks()),
        _order_html(c.order, "tests", "RMSE of mu"),
    )  # fmt: skip
    names = c.order.names
    styles = looks(c.models)
    page.add(
        "parity",
        "Measured against predicted",
        figure("parity", _parity(c), "Points thinned evenly; the line is perfect agreement.", "Predicted over measured mu, one panel a model."),
    )  # fmt: skip
    page.add(
        "response",
        "Response curves",
        figure(
            "response", response_chart(c.loads, [(n, styles[n], c.models[n]) for n in names]),
            CAPTION, "Response curves of all models over the five loads.",
        ),
    )  # fmt: skip
    page.add(
        "tests",
        "Test by test",
        figure(
            "tests", _per_test(c, names),
            f"RMSE of each model in each test{'' if len(c.result.per_test) <= _TESTS else f', the {_TESTS} worst of the best model'}.",
            "RMSE of every model in every test.",
        ),
    )  # fmt: skip


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
                *(f"{100 * c.orders[q].best[name]:.0f}" for q in QUANTITIES),
            )
        )  # fmt: skip
    page.add(
        "force-errors",
        "Errors on press curves",
        table(
            ["model", "MARE max force [%]", "over levels [%]", "MARE work [%]", "over levels [%]", "best by force [%]", "best by work [%]"],
            rows, numeric=range(1, 7), caption="MARE: mean absolute relative error over the levels, +- from the scatter of the repeats.",
        ),
        bullets(c.remarks()),
        *(_order_html(order, "levels", f"MARE of the {QUANTITIES[q]}") for q, order in c.orders.items()),
    )  # fmt: skip
    page.add(
        "level-errors",
        "Level by level",
        figure(
            "levels", _signed(c), "Signed error of the maximum force and of the work; bars are the scatter of the repeats.",
            "Relative error of maximum force and work by level and model.",
        ),
    )  # fmt: skip
    page.add(
        "force-curves",
        "Force over stroke",
        figure("forces", _curves(c), "Press: mean of the repeats and their standard deviation.", "Force over stroke of the press and all models, one panel a level."),
    )  # fmt: skip


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


def _interval(value: float, interval: tuple[float, float], sign: str = "") -> str:
    text = f"{value:{sign}.4f}"
    return text if np.isnan(interval[0]) else f"{text} [{interval[0]:{sign}.4f}, {interval[1]:{sign}.4f}]"


def _spread(summary: LevelSummary) -> str:
    return f"{100 * summary.spread:.1f}" if summary.levels > 1 else "-"


def _grid(count: int) -> tuple[int, int]:
    columns = min(_COLUMNS, count)
    return -(-count // columns), columns


def _parity(c: TestsComparison) -> Any:
    from plotly.subplots import make_subplots

    names = c.order.names
    rows, columns = _grid(len(names))
    styles = looks(c.models)
    chart = make_subplots(
        rows=rows, cols=columns, shared_xaxes=True, shared_yaxes=True, subplot_titles=[escape(n) for n in names],
        horizontal_spacing=0.03, vertical_spacing=0.16 / rows,
    )  # fmt: skip
    shown = np.arange(0, len(c.mu), max(1, len(c.mu) // _POINTS))
    ids = c.loads.test_id
    low, top = _limits([c.mu, *c.predicted.values()])
    for number, name in enumerate(names):
        place = {"row": number // columns + 1, "col": number % columns + 1}
        chart.add_scatter(
            x=[low, top],
            y=[low, top],
            mode="lines",
            line={"color": INK, "width": 1},
            hoverinfo="skip",
            **place,
        )
        chart.add_scatter(
            x=c.mu[shown], y=c.predicted[name][shown], mode="markers",
            marker={"size": 3, "color": styles[name]["color"], "opacity": 0.45},
            text=None if ids is None else [escape(i) for i in ids[shown]], **place,
            hovertemplate="%{text}<br>measured %{x:.4f}<br>predicted %{y:.4f}<extra></extra>",
        )  # fmt: skip
        chart.update_xaxes(range=[low, top], **place)
        chart.update_yaxes(range=[low, top], **place)
        if place["row"] == rows:
            chart.update_xaxes(title_text="measured mu", **place)
    dress(chart, 300 * rows + 50, legend=False)
    chart.update_xaxes(zeroline=False)
    chart.update_yaxes(zeroline=False)
    for row in range(1, rows + 1):
        chart.update_yaxes(title_text="predicted mu", row=row, col=1)
    return chart


def _limits(values: Iterable[FloatArray]) -> tuple[float, float]:
    """Return limits of an axis that show all but the outermost thousandth of each, with a margin."""
    ends = np.array([np.quantile(v, [0.001, 0.999]) for v in values])
    low, top = float(ends[:, 0].min()), float(ends[:, 1].max())
    margin = 0.05 * (top - low) or 0.005
    return low - margin, top + margin


def _per_test(c: TestsComparison, names: Sequence[str]) -> Any:
    from plotly import graph_objects

    best = names[0]
    shown = c.result.per_test.sort_values(best, ascending=False).head(_TESTS)
    chart = graph_objects.Figure()
    styles = looks(c.models)
    for name in names:
        chart.add_scatter(
            x=[escape(i) for i in shown.index], y=shown[name], mode="markers", name=escape(name), marker={"size": 8, "color": styles[name]["color"], "opacity": 0.8},
            hovertemplate="%{x}: %{y:.4f}<extra>%{fullData.name}</extra>",
        )  # fmt: skip
    dress(chart, 360)
    chart.update_yaxes(title_text="RMSE of mu", rangemode="tozero")
    chart.update_xaxes(tickangle=-60, type="category")
    return chart


def _signed(c: ForcesComparison) -> Any:
    from plotly.subplots import make_subplots

    chart = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.08)
    styles = looks([r.label for r in c.results])
    for row, quantity in enumerate(QUANTITIES, 1):
        for result in c.results:
            errors = [getattr(level, quantity) for level in result.levels]
            chart.add_scatter(
                x=[escape(n) for n in c.names], y=[100 * e.signed for e in errors], mode="markers", name=escape(result.label), legendgroup=escape(result.label),
                showlegend=row == 1, marker={"size": 9, "color": styles[result.label]["color"]},
                error_y={"type": "data", "array": [100 * e.are_std for e in errors], "width": 3, "thickness": 1},
                row=row, col=1, hovertemplate="%{x}: %{y:+.1f} %<extra>%{fullData.name}</extra>",
            )  # fmt: skip
        chart.update_yaxes(title_text=f"{QUANTITIES[quantity]} [%]", row=row, col=1)
    dress(chart, 460)
    chart.update_xaxes(type="category")
    return chart


def _curves(c: ForcesComparison) -> Any:
    from plotly.subplots import make_subplots

    rows, columns = _grid(len(c.names))
    styles: Mapping[str, Any] = looks([r.label for r in c.results])
    chart = make_subplots(
        rows=rows,
        cols=columns,
        subplot_titles=[escape(n) for n in c.names],
        horizontal_spacing=0.06,
        vertical_spacing=0.2 / rows,
    )
    for number in range(len(c.names)):
        place = {"row": number // columns + 1, "col": number % columns + 1}
        first = number == 0
        press = c.results[0].levels[number]
        low, high = press.measured - press.measured_std, press.measured + press.measured_std
        chart.add_scatter(
            x=np.concatenate([press.stroke, press.stroke[::-1]]), y=np.concatenate([high, low[::-1]]), fill="toself",
            fillcolor=PRESS_BAND, line={"width": 0}, mode="lines", hoverinfo="skip", legendgroup="press", showlegend=False, **place,
        )  # fmt: skip
        chart.add_scatter(
            x=press.stroke, y=press.measured, name="press", legendgroup="press", showlegend=first,
            line={"color": PRESS, "width": 2.4}, hovertemplate="press %{y:.1f} kN<extra></extra>", **place,
        )  # fmt: skip
        for result in c.results:
            level = result.levels[number]
            chart.add_scatter(
                x=level.stroke, y=level.simulated, name=escape(result.label), legendgroup=escape(result.label), showlegend=first,
                line=styles[result.label], hovertemplate="%{y:.1f} kN<extra>%{fullData.name}</extra>", **place,
            )  # fmt: skip
        if place["row"] == rows or number + columns >= len(c.names):
            chart.update_xaxes(title_text="stroke [mm]", **place)
        if place["col"] == 1:
            chart.update_yaxes(title_text="punch force [kN]", **place)
    dress(chart, 260 * rows + 70)
    chart.update_layout(margin_t=66)
    return chart
