"""Loads and mu along the contact, at a stroke that a slider chooses."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from friction_models.common.markup import escape
from friction_models.loads import LOADS, MU, FloatArray
from friction_models.loads.contract import with_unit

from ...comparison.contact_course import ContactCourse
from ..parts.chart import Chart, limits
from ..parts.theme import looks

#: Most positions of the slider: each holds all curves once.
STROKES = 25
#: Digits of the numbers behind the slider, which a page holds as text.
DIGITS = 4


def contact_chart(courses: Mapping[str, ContactCourse]) -> Chart:
    """Return one panel a load with a curve a model, and a slider for the stroke; the axes stay as they are.

    Examples
    --------
    >>> stroke, place = np.linspace(0.0, 2.0, 3), np.tile([0.0, 1.0], (3, 1))
    >>> course = ContactCourse(stroke, place, {"mu": np.full((3, 2), 0.1), "sigma_n": place + 500.0}, True)
    >>> layout = contact_chart({"law": course}).figure.layout
    >>> [step.label for step in layout.sliders[0].steps]
    ['0.00', '1.00', '2.00']
    """
    first = next(iter(courses.values()))
    names = [q.name for q in (MU, *LOADS) if any(q.name in c.values for c in courses.values())]
    chart = Chart.of_panels(
        len(names), titles=[with_unit(n) for n in names], horizontal_spacing=0.07, gap=0.3
    )
    styles = looks(courses)
    drawn = [
        (panel, label, name)
        for panel, name in enumerate(names)
        for label, course in courses.items()
        if name in course.values
    ]
    strokes = _strokes(courses)
    start = len(strokes) // 2
    data = [_at(courses, label, name, strokes[start]) for _, label, name in drawn]
    for (panel, label, _), (x, y) in zip(drawn, data, strict=True):
        said = "%{y:.4g} at %{x:.2f}<extra>%{fullData.name}</extra>"
        chart.scatter(panel, x, y, escape(label), said, line=styles[label], mode="lines", connectgaps=False)
    for panel, name in enumerate(names):
        found = [c.values[name] for c in courses.values() if name in c.values]
        chart.axes(panel, y=" ")
        chart.figure.update_yaxes(range=limits(found), **chart.place(panel))
    chart.dress(250 * chart.rows + 140, x="along the surface [mm]" if first.is_distance else "contact point")
    chart.figure.update_xaxes(range=limits([c.place for c in courses.values()]), zeroline=False)
    chart.figure.update_layout(
        margin_b=120,
        sliders=[
            {
                "active": start,
                "currentvalue": {"prefix": "stroke ", "suffix": " mm"},
                "pad": {"t": 60},
                "steps": [
                    {"label": f"{s:.2f}", "method": "restyle", "args": [_restyled(courses, drawn, s)]}
                    for s in strokes
                ],
            }
        ],
    )
    return chart


def _strokes(courses: Mapping[str, ContactCourse]) -> list[float]:
    """Return strokes spread evenly over what all runs cover."""
    first = min(courses.values(), key=lambda course: float(course.stroke[-1]))
    rows = np.unique(
        np.linspace(0, len(first.stroke) - 1, min(STROKES, len(first.stroke))).round().astype(int)
    )
    return [float(first.stroke[k]) for k in rows]


def _at(
    courses: Mapping[str, ContactCourse], label: str, name: str, stroke: float
) -> tuple[FloatArray, FloatArray]:
    course = courses[label]
    row = int(np.abs(course.stroke - stroke).argmin())
    return course.place[row], course.values[name][row]


def _restyled(
    courses: Mapping[str, ContactCourse], drawn: list[tuple[int, str, str]], stroke: float
) -> dict[str, object]:
    """Return what plotly puts in place of the curves: x and y of each, in their order."""
    found = [_at(courses, label, name, stroke) for _, label, name in drawn]
    return {"x": [_numbers(x) for x, _ in found], "y": [_numbers(y) for _, y in found]}


def _numbers(values: FloatArray) -> list[float | None]:
    return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in values]
