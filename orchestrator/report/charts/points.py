"""Points of measurements: any quantity over any other, coloured by a third."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.common.markup import escape
from friction_models.loads import LOAD_NAMES
from friction_models.loads.contract import with_unit

from ..parts.chart import Chart
from ..parts.theme import AFTER, COLORS, CONSTANT

#: Most points that are drawn, and most levels that have a colour of their own.
MOST, LEVELS = 6000, 8
#: From dark to light at even steps of lightness, so that it also holds in grey.
_SCALE = [[0.0, "#24406e"], [0.35, "#1f7f86"], [0.7, "#8db35c"], [1.0, "#f2d95c"]]


def points_chart(points: pd.DataFrame, x: str, y: str, color: str = "") -> Chart:
    """Return a cloud of points, thinned evenly to at most `MOST`.

    Parameters
    ----------
    points : pandas.DataFrame
        With ``test_id`` and the columns `x`, `y` and `color`.
    x, y : str
        Columns of numbers.
    color : str, optional
        A column; numbers have a scale, names (at most eight, the commonest) a colour each.

    Examples
    --------
    >>> frame = pd.DataFrame({"test_id": ["a", "b"], "sd": [1.0, 2.0], "mu": [0.1, 0.2], "batch": ["A", "B"]})
    >>> [trace.name for trace in points_chart(frame, "sd", "mu", "batch").figure.data]
    ['A', 'B']
    """
    # A fixed shuffle: points that are drawn last would hide the tests before them.
    rows = np.random.default_rng(0).permutation(len(points))[:MOST]
    shown = points.iloc[rows]
    named = bool(color) and not pd.api.types.is_numeric_dtype(shown[color])
    said = f"%{{text}}<br>{escape(x)} %{{x:.4g}}<br>{escape(y)} %{{y:.4g}}"
    chart = Chart(legend=named)
    if named:
        values = shown[color].astype(str)
        levels = list(values.value_counts().index[:LEVELS])
        for number, level in enumerate(sorted(levels)):
            _cloud(chart, shown[values == level], x, y, said, escape(level), {"color": COLORS[number]})
        rest = shown[~values.isin(levels)]
        if len(rest):
            _cloud(chart, rest, x, y, said, "others", {"color": CONSTANT})
    elif color:
        bar = {"title": {"text": escape(_label(color)), "side": "right"}, "thickness": 12, "outlinewidth": 0}
        look = {
            "color": shown[color].to_numpy(dtype=float),
            "colorscale": _SCALE,
            "colorbar": bar,
            "showscale": True,
        }
        _cloud(chart, shown, x, y, f"{said}<br>{escape(color)} %{{marker.color:.4g}}", "", look)
    else:
        _cloud(chart, shown, x, y, said, "", {"color": AFTER})
    return chart.dress(520, x=escape(_label(x)), y=escape(_label(y)))


def _cloud(
    chart: Chart, shown: pd.DataFrame, x: str, y: str, said: str, name: str, look: dict[str, object]
) -> None:
    chart.scatter(
        0, shown[x].to_numpy(dtype=float), shown[y].to_numpy(dtype=float), name, f"{said}<extra></extra>", mode="markers",
        text=[escape(t) for t in shown["test_id"]], marker={"size": 4.5, "opacity": 0.65, **look},
    )  # fmt: skip


def _label(name: str) -> str:
    return with_unit(name) if name in LOAD_NAMES else name
