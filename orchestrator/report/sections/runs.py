"""Runs of one system with several friction models, as a part of the report of `compare`."""

from __future__ import annotations

from friction_models.common.markup import bullets, escape, table
from friction_models.loads import LOADS, MU
from friction_models.loads.contract import with_unit

from ...comparison.in_one_system import RunsComparison
from ..parts.chart import Chart
from ..parts.page import Page
from ..parts.theme import looks


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
    page.plot(
        "run-forces",
        "Force over stroke",
        _forces(c),
        "Punch force of every run, unfiltered.",
        "Force over stroke of all models.",
    )
    if any(c.points.values()):
        page.plot(
            "run-points",
            "Loads and friction at points",
            _points(c),
            "Contact points that touch the tool long, the same in every run; gaps: no contact.",
            "Loads and mu over stroke at contact points, one column a point.",
        )


def _forces(c: RunsComparison) -> Chart:
    chart = Chart()
    styles = looks(c.curves)
    for label, curve in c.curves.items():
        said = "%{y:.1f} kN<extra>%{fullData.name}</extra>"
        chart.scatter(0, curve.stroke, curve.force, escape(label), said, line=styles[label])
    return chart.dress(420, x="stroke [mm]", y="punch force [kN]", from_zero=True)


def _points(c: RunsComparison) -> Chart:
    first = next(points for points in c.points.values() if points)
    known = {name for points in c.points.values() for p in points for name in p.values}
    names = [q.name for q in (MU, *LOADS) if q.name in known]
    chart = Chart(
        len(first), len(names), titles=[f"point {p.point}" for p in first], shared_xaxes=True, shared_yaxes="rows",
        horizontal_spacing=0.03, vertical_spacing=0.03,
    )  # fmt: skip
    styles = looks(c.curves)
    for label, points in c.points.items():
        for column, history in enumerate(points):
            for row, name in enumerate(names):
                if name in history.values:
                    chart.scatter(
                        row * len(first) + column, history.stroke, history.values[name], escape(label),
                        "%{y:.4g}<extra>%{fullData.name}</extra>", line=styles[label],
                    )  # fmt: skip
    return chart.dress(150 * len(names) + 90, x="stroke [mm]", y=[with_unit(name) for name in names])
