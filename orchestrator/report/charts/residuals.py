"""Charts of residuals: over each load, and in the worst tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from friction_models.discovery.figures_data import varied
from friction_models.loads import LOADS, FloatArray
from friction_models.loads.contract import with_unit

from ..parts.theme import AFTER, AFTER_BAND, BEFORE, BEFORE_BAND, PRESS, dress
from .binned_residual import binned_residual

_LOOK = {"before": (BEFORE, BEFORE_BAND), "after": (AFTER, AFTER_BAND)}


def residual_chart(points: pd.DataFrame, predicted: Mapping[str, FloatArray]) -> Any:
    """Return the mean residual over each load that varies with per-test intervals, one panel a load.

    Parameters
    ----------
    points : pandas.DataFrame
        Held-out points with ``mu`` and ``test_id``.
    predicted : mapping
        mu of the models ``before`` and (where there is one) ``after``.
    """
    from plotly.subplots import make_subplots

    names = varied(points) or [q.name for q in LOADS if q.name in points.columns][:1]
    chart = make_subplots(rows=1, cols=len(names), shared_yaxes=True, horizontal_spacing=0.022)
    test_id = points["test_id"].to_numpy().astype(str)
    measured = points["mu"].to_numpy()
    weight = points["points"].to_numpy() if "points" in points.columns else None
    interval = " (mean, 95 % interval)" if len(np.unique(test_id)) > 1 else " (mean)"
    for column, name in enumerate(names, 1):
        load = points[name].to_numpy()
        for part, mu in predicted.items():
            color, band = _LOOK[part]
            found = binned_residual(load, measured - mu, test_id, weight)
            if np.isfinite(found.half).any():
                half = np.nan_to_num(found.half)
                chart.add_scatter(
                    x=np.concatenate([found.centre, found.centre[::-1]]),
                    y=np.concatenate([found.mean + half, (found.mean - half)[::-1]]),
                    fill="toself", fillcolor=band, line={"width": 0}, mode="lines", hoverinfo="skip",
                    legendgroup=part, showlegend=False, row=1, col=column,
                )  # fmt: skip
            chart.add_scatter(
                x=found.centre, y=found.mean, mode="lines+markers", name=f"{part}{interval}",
                line={"color": color, "width": 2}, marker={"size": 5}, legendgroup=part,
                showlegend=column == 1, row=1, col=column, customdata=found.tests,
                hovertemplate=f"{name} %{{x:.4g}}<br>%{{y:+.4f}} from %{{customdata}} tests<extra>{part}</extra>",
            )  # fmt: skip
        chart.update_xaxes(title_text=with_unit(name), row=1, col=column)
    dress(chart, 330)
    chart.update_yaxes(title_text="measured &#8722; model (mu)", row=1, col=1)
    return chart


def worst_tests_chart(points: pd.DataFrame, predicted: Mapping[str, FloatArray], tests: Sequence[str]) -> Any:
    """Return mu over sliding distance, measured and modelled, one panel a test."""
    from plotly.subplots import make_subplots

    chart = make_subplots(
        rows=1, cols=len(tests), shared_yaxes=True, horizontal_spacing=0.022, subplot_titles=tests
    )
    test_id = points["test_id"].to_numpy().astype(str)
    along = "sd [mm]" if "sd" in points.columns and np.ptp(points["sd"]) > 0.0 else "number of the point"
    lone = len(points) <= 2 * points["test_id"].nunique()
    for column, name in enumerate(tests, 1):
        rows = np.flatnonzero(test_id == name)
        rows = rows[:: max(1, len(rows) // 250)]
        sd = points["sd"].to_numpy()[rows] if along == "sd [mm]" else np.arange(len(rows))
        chart.add_scatter(
            x=sd, y=points["mu"].to_numpy()[rows], mode="markers", name="measured", legendgroup="measured",
            marker={"size": 3.2, "color": PRESS, "opacity": 0.45}, showlegend=column == 1, row=1, col=column,
            hovertemplate=f"{along} %{{x:.1f}}<br>mu %{{y:.4f}}<extra>measured</extra>",
        )  # fmt: skip
        for part, mu in predicted.items():
            chart.add_scatter(
                x=sd, y=mu[rows], name=part, legendgroup=part, line={"color": _LOOK[part][0], "width": 2.4},
                mode="markers" if lone else "lines", showlegend=column == 1, row=1, col=column,
                hovertemplate=f"{along} %{{x:.1f}}<br>mu %{{y:.4f}}<extra>{part}</extra>",
            )  # fmt: skip
        chart.update_xaxes(title_text=along, row=1, col=column)
    dress(chart, 330)
    chart.update_layout(margin_t=62)
    chart.update_yaxes(title_text="mu", row=1, col=1)
    return chart
