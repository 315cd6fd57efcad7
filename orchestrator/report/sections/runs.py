"""Runs of one system with several friction models, as a part of the report of `compare`."""

from __future__ import annotations

from friction_models.common.markup import bullets, escape, table
from friction_models.loads import LOADS, MU
from friction_models.loads.contract import with_unit

from ...comparison.in_one_system import RunsComparison, Totals
from ...force_curves.forces import ForceComparison
from ...force_curves.metrics import ScalarError
from ..charts.contact import contact_chart
from ..charts.force import draw_press
from ..parts.chart import Chart
from ..parts.page import Page
from ..parts.theme import looks
from .stated_errors import stated_errors_table


def add_runs(page: Page, c: RunsComparison, number: str = "") -> None:
    """Add table and charts of the runs to a page; `number` tells the sections of several levels apart."""
    where = f" ({c.system})" if number else ""
    headings = ["model", "max force [kN]", "work [J]", "by friction [%]"]
    against = ["max force against the press [%]", "work against the press [%]"] if c.press else []
    caption = (
        f"{c.system}, stroke {c.stroke[0]:.2f} to {c.stroke[1]:.2f} mm. By friction: one minus the work of the run without "
        "friction over that of this one."
        + (" Against the press: +- from the scatter of its repeats." if c.press else "")
    )
    page.add(
        f"runs{number}",
        f"Runs of one system{where}",
        table(
            [*headings, *against],
            [(*_totals(label, total), *_errors(c.press.get(label))) for label, total in c.totals.items()],
            numeric=range(1, 6),
            caption=caption,
        ),
        bullets(c.remarks()),
    )
    press = " The press: mean of its repeats and their standard deviation." if c.press else ""
    page.plot(
        f"run-forces{number}",
        f"Force over stroke{where}",
        _forces(c),
        f"Punch force of every run, unfiltered.{press}",
        "Force over stroke of all models.",
    )
    if c.contact:
        place = "number of the contact point"
        if all(course.is_distance for course in c.contact.values()):
            place = "distance along the surface from its first contact point"
        page.plot(
            f"run-contact{number}",
            f"Loads along the contact{where}",
            contact_chart(c.contact),
            f"Loads and mu over the {place}, at the stroke of the slider; gaps: no contact.",
            "Loads and mu along the contact, one panel a load, at a stroke that can be chosen.",
            stated_errors_table(c.errors),
        )
    if any(c.points.values()):
        page.plot(
            f"run-points{number}",
            f"Loads and friction at points{where}",
            _points(c),
            "Contact points that touch the tool long, the same in every run; gaps: no contact.",
            "Loads and mu over stroke at contact points, one column a point.",
        )


def _totals(label: str, total: Totals) -> tuple[str, ...]:
    share = "-" if total.friction_share is None else f"{100 * total.friction_share:.1f}"
    return label, f"{total.max_force:.2f}", f"{total.work:.1f}", share


def _errors(found: ForceComparison | None) -> tuple[str, ...]:
    return () if found is None else (_signed(found.max_force), _signed(found.work))


def _signed(error: ScalarError) -> str:
    spread = f" +- {100 * error.are_std:.1f}" if error.measured.repeats > 1 else ""
    return f"{100 * error.signed:+.1f}{spread}"


def _forces(c: RunsComparison) -> Chart:
    chart = Chart()
    styles = looks(c.curves)
    if c.press:
        draw_press(chart, 0, next(iter(c.press.values())))
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
