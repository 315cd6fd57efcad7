"""Runs of one system with several friction models, as a part of the report of `compare`."""

from __future__ import annotations

from typing import Any

from friction_models.loads import LOADS, MU

from ...comparison.in_one_system import RunsComparison
from ..parts.markup import bullets, escape, table
from ..parts.page import Page, figure
from ..parts.palette import looks
from ..parts.theme import dress


def add_runs(page: Page, c: RunsComparison) -> None:
    """Add table and charts of the runs to a page."""
    rows = [
        (
            label, f"{total.max_force:.2f}", f"{total.work:.1f}",
            "-" if total.friction_share is None else f"{100 * total.friction_share:.1f}",
        )
        for label, total in c.totals.items()
    ]  # fmt: skip
    page.add(
        "runs",
        "Runs of one system",
        table(
            ["model", "max force [kN]", "work [J]", "by friction [%]"], rows, numeric=range(1, 4),
            caption=f"{c.system}, stroke {c.stroke[0]:.2f} to {c.stroke[1]:.2f} mm. By friction: one minus the work of the "
            "run without friction over that of this one.",
        ),
        bullets(c.remarks()),
    )  # fmt: skip
    page.add(
        "run-forces",
        "Force over stroke",
        figure("run-forces", _forces(c), "Punch force of every run, unfiltered.", "Force over stroke of all models."),
    )  # fmt: skip
    if any(c.points.values()):
        page.add(
            "run-points",
            "Loads and friction at points",
            figure(
                "run-points", _points(c), "Contact points that touch the tool long, the same in every run; gaps: no contact.",
                "Loads and mu over stroke at contact points, one column a point.",
            ),
        )  # fmt: skip


def _forces(c: RunsComparison) -> Any:
    from plotly import graph_objects

    chart = graph_objects.Figure()
    styles = looks(c.curves)
    for label, curve in c.curves.items():
        chart.add_scatter(
            x=curve.stroke, y=curve.force, name=escape(label), line=styles[label],
            hovertemplate="%{y:.1f} kN<extra>%{fullData.name}</extra>",
        )  # fmt: skip
    dress(chart, 420)
    chart.update_xaxes(title_text="stroke [mm]")
    chart.update_yaxes(title_text="punch force [kN]", rangemode="tozero")
    return chart


def _points(c: RunsComparison) -> Any:
    from plotly.subplots import make_subplots

    first = next(points for points in c.points.values() if points)
    quantities = [
        q for q in (MU, *LOADS) if any(q.name in p.values for points in c.points.values() for p in points)
    ]
    chart = make_subplots(
        rows=len(quantities),
        cols=len(first),
        shared_xaxes=True,
        shared_yaxes="rows",
        horizontal_spacing=0.03,
        vertical_spacing=0.03,
        subplot_titles=[f"point {p.point}" for p in first],
    )
    styles = looks(c.curves)
    for label, points in c.points.items():
        for column, history in enumerate(points, 1):
            for row, quantity in enumerate(quantities, 1):
                if quantity.name not in history.values:
                    continue
                chart.add_scatter(
                    x=history.stroke, y=history.values[quantity.name], name=escape(label), legendgroup=escape(label),
                    showlegend=row == column == 1, line=styles[label], row=row, col=column,
                    hovertemplate="%{y:.4g}<extra>%{fullData.name}</extra>",
                )  # fmt: skip
    dress(chart, 150 * len(quantities) + 90)
    for row, quantity in enumerate(quantities, 1):
        unit = "" if quantity.unit == "1" else f" [{quantity.unit}]"
        chart.update_yaxes(title_text=f"{quantity.name}{unit}", row=row, col=1)
    chart.update_xaxes(title_text="stroke [mm]", row=len(quantities))
    return chart
