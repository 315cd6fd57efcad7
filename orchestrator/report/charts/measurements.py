"""Charts of measurements: one test as a time series with its average, points in load space, measured against predicted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from friction_models.common.markup import escape
from friction_models.loads import FloatArray
from friction_models.loads.contract import with_unit

from ..parts.chart import Chart
from ..parts.theme import AFTER, BEFORE, COLORS, INK

if TYPE_CHECKING:
    import pandas as pd

#: Most points of a cloud.
POINTS = 2500
#: Pairs of loads that are drawn against each other.
_PAIRS = (("sigma_n", "T"), ("sigma_n", "psi"), ("sd", "v_rel"))


def series_chart(points: pd.DataFrame, averages: pd.DataFrame) -> Chart:
    """Return mu and the loads over sliding distance in one test (line), and its averages (dashed).

    The test is the one whose mu moves most within it: there the two collections differ most.
    """
    swing = points.groupby("test_id")["mu"].std()
    name = swing.idxmax() if swing.notna().any() else points["test_id"].iloc[0]
    test = points[points["test_id"] == name]
    mean = averages[averages["test_id"] == name]
    shown = ("mu", "sigma_n", "psi", "T", "v_rel")
    chart = Chart(len(shown), titles=[escape(with_unit(n)) for n in shown], horizontal_spacing=0.045)
    for panel, quantity in enumerate(shown):
        chart.scatter(
            panel, test["sd"], test[quantity], "time series", "%{x:.1f} mm: %{y:.4g}<extra></extra>", "series",
            mode="lines", line={"color": AFTER, "width": 2},
        )  # fmt: skip
        if len(mean):
            ends = [test["sd"].min(), test["sd"].max()]
            chart.scatter(
                panel, ends, [mean[quantity].iloc[0]] * 2, "average", "average %{y:.4g}<extra></extra>",
                mode="lines", line={"color": BEFORE, "width": 2, "dash": "dash"},
            )  # fmt: skip
    return chart.dress(300, x="sd [mm]", margin_t=66)


def load_space_chart(points: pd.DataFrame, averages: pd.DataFrame) -> Chart:
    """Return the points of both collections in load space, pairs of loads against each other."""
    chart = Chart(len(_PAIRS), horizontal_spacing=0.07)
    thinned = points.iloc[:: max(1, len(points) // POINTS)]
    for panel, (x, y) in enumerate(_PAIRS):
        for frame, name, color, size, opacity in (
            (thinned, "time series", AFTER, 3, 0.35),
            (averages, "average", BEFORE, 7, 0.9),
        ):
            said = f"{x} %{{x:.4g}}, {y} %{{y:.4g}}<extra>{name}</extra>"
            dots = {"size": size, "color": color, "opacity": opacity}
            chart.scatter(panel, frame[x], frame[y], name, said, mode="markers", marker=dots)
        chart.axes(panel, with_unit(x), with_unit(y))
    return chart.dress(340)


def parity_chart(found: Mapping[tuple[str, str], tuple[FloatArray, FloatArray]]) -> Chart:
    """Return predicted over measured mu (`found`, by lubricant and model), one panel a model, one colour a lubricant."""
    models, lubricants = (list(dict.fromkeys(key[k] for key in found)) for k in (1, 0))
    chart = Chart(
        len(models), titles=[escape(m) for m in models], shared_yaxes=True, horizontal_spacing=0.022
    )
    top = 1.05 * max(float(np.quantile(np.concatenate(pair), 0.999)) for pair in found.values())
    for panel, model in enumerate(models):
        chart.scatter(panel, [0.0, top], [0.0, top], mode="lines", line={"color": INK, "width": 1})
        for number, lubricant in enumerate(lubricants):
            if (lubricant, model) in found:
                measured, predicted = found[lubricant, model]
                rows = np.arange(0, len(measured), max(1, len(measured) * len(lubricants) // POINTS))
                chart.scatter(
                    panel, measured[rows].round(5), predicted[rows].round(5), escape(lubricant),
                    "measured %{x:.4f}<br>predicted %{y:.4f}<extra></extra>", lubricant, mode="markers",
                    marker={"size": 3, "opacity": 0.45, "color": COLORS[number % len(COLORS)]},
                )  # fmt: skip
    chart.figure.update_xaxes(range=[0.0, top])
    chart.figure.update_yaxes(range=[0.0, top])
    return chart.dress(320, x="measured mu", y="predicted mu", margin_t=66)
