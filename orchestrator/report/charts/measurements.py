"""Charts of measurements: one test as a time series with its average, points in load space, measured against predicted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_models.loads import FloatArray
from friction_models.loads.contract import with_unit

from ..parts.markup import escape
from ..parts.palette import COLORS
from ..parts.theme import AFTER, BEFORE, INK, dress

if TYPE_CHECKING:
    import pandas as pd

#: Most points of a cloud.
_POINTS = 2500
#: Pairs of loads that are drawn against each other.
_PAIRS = (("sigma_n", "T"), ("sigma_n", "psi"), ("sd", "v_rel"))


def series_chart(points: pd.DataFrame, averages: pd.DataFrame) -> Any:
    """Return mu and the loads over sliding distance in one test (line), and its averages (dashed).

    The test is the one whose mu moves most within it: there the two collections differ most.
    """
    from plotly.subplots import make_subplots

    swing = points.groupby("test_id")["mu"].std()
    name = swing.idxmax() if swing.notna().any() else points["test_id"].iloc[0]
    test = points[points["test_id"] == name]
    mean = averages[averages["test_id"] == name]
    shown = ("mu", "sigma_n", "psi", "T", "v_rel")
    chart = make_subplots(
        rows=1,
        cols=len(shown),
        horizontal_spacing=0.045,
        subplot_titles=[escape(with_unit(n)) for n in shown],
    )
    for column, quantity in enumerate(shown, 1):
        place = {"row": 1, "col": column, "showlegend": column == 1}
        chart.add_scatter(
            x=test["sd"], y=test[quantity], mode="lines", name="time series", legendgroup="series",
            line={"color": AFTER, "width": 2}, hovertemplate="%{x:.1f} mm: %{y:.4g}<extra></extra>", **place,
        )  # fmt: skip
        if len(mean):
            chart.add_scatter(
                x=[test["sd"].min(), test["sd"].max()], y=[mean[quantity].iloc[0]] * 2, mode="lines", name="average",
                legendgroup="average", line={"color": BEFORE, "width": 2, "dash": "dash"},
                hovertemplate="average %{y:.4g}<extra></extra>", **place,
            )  # fmt: skip
        chart.update_xaxes(title_text="sd [mm]", row=1, col=column)
    dress(chart, 300)
    chart.update_layout(margin_t=66)
    return chart


def load_space_chart(points: pd.DataFrame, averages: pd.DataFrame) -> Any:
    """Return the points of both collections in load space, pairs of loads against each other."""
    from plotly.subplots import make_subplots

    chart = make_subplots(rows=1, cols=len(_PAIRS), horizontal_spacing=0.07)
    thinned = points.iloc[:: max(1, len(points) // _POINTS)]
    for column, (x, y) in enumerate(_PAIRS, 1):
        for frame, name, color, size, opacity in (
            (thinned, "time series", AFTER, 3, 0.35),
            (averages, "average", BEFORE, 7, 0.9),
        ):
            chart.add_scatter(
                x=frame[x], y=frame[y], mode="markers", name=name, legendgroup=name, showlegend=column == 1,
                marker={"size": size, "color": color, "opacity": opacity}, row=1, col=column,
                hovertemplate=f"{x} %{{x:.4g}}, {y} %{{y:.4g}}<extra>{name}</extra>",
            )  # fmt: skip
        chart.update_xaxes(title_text=with_unit(x), row=1, col=column)
        chart.update_yaxes(title_text=with_unit(y), row=1, col=column)
    dress(chart, 340)
    return chart


def parity_chart(found: Mapping[tuple[str, str], tuple[FloatArray, FloatArray]]) -> Any:
    """Return predicted over measured mu, one panel a model, one colour a lubricant.

    Parameters
    ----------
    found : mapping of (lubricant, model) to (measured, predicted)
    """
    from plotly.subplots import make_subplots

    models, lubricants = (list(dict.fromkeys(key[k] for key in found)) for k in (1, 0))
    chart = make_subplots(
        rows=1, cols=len(models), shared_yaxes=True, horizontal_spacing=0.022,
        subplot_titles=[escape(m) for m in models],
    )  # fmt: skip
    top = 1.05 * max(float(np.quantile(np.concatenate(pair), 0.999)) for pair in found.values())
    for column, model in enumerate(models, 1):
        chart.add_scatter(
            x=[0.0, top], y=[0.0, top], mode="lines", line={"color": INK, "width": 1}, hoverinfo="skip",
            showlegend=False, row=1, col=column,
        )  # fmt: skip
        for number, lubricant in enumerate(lubricants):
            if (lubricant, model) in found:
                measured, predicted = found[lubricant, model]
                rows = np.arange(0, len(measured), max(1, len(measured) * len(lubricants) // _POINTS))
                chart.add_scatter(
                    x=measured[rows].round(5), y=predicted[rows].round(5), mode="markers", name=escape(lubricant),
                    legendgroup=lubricant, showlegend=column == 1,
                    marker={"size": 3, "opacity": 0.45, "color": COLORS[number % len(COLORS)]}, row=1, col=column,
                    hovertemplate="measured %{x:.4f}<br>predicted %{y:.4f}<extra></extra>",
                )  # fmt: skip
        chart.update_xaxes(range=[0.0, top], title_text="measured mu", row=1, col=column)
    dress(chart, 320)
    chart.update_layout(margin_t=66)
    chart.update_yaxes(range=[0.0, top])
    chart.update_yaxes(title_text="predicted mu", row=1, col=1)
    return chart
