"""Charts of residuals: over each load, and in the worst tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from friction_models.discovery.figures_data import varied
from friction_models.loads import LOADS, FloatArray
from friction_models.loads.labels import with_unit

from ..parts.chart import Chart
from ..parts.theme import AFTER, AFTER_BAND, BEFORE, BEFORE_BAND, PRESS
from .binned_residual import binned_residual

_LOOK = {"before": (BEFORE, BEFORE_BAND), "after": (AFTER, AFTER_BAND)}


def residual_chart(points: pd.DataFrame, predicted: Mapping[str, FloatArray]) -> Chart:
    """Return the mean residual over each load that varies with per-test intervals, one panel a load.

    Parameters
    ----------
    points : pandas.DataFrame
        Held-out points with ``mu`` and ``test_id``.
    predicted : mapping
        mu of the models ``before`` and (where there is one) ``after``.
    """
    names = varied(points) or [q.name for q in LOADS if q.name in points.columns][:1]
    chart = Chart(len(names), shared_yaxes=True, horizontal_spacing=0.022)
    test_id = points["test_id"].to_numpy().astype(str)
    weight = points["points"].to_numpy() if "points" in points.columns else None
    interval = " (mean, 95 % interval)" if len(np.unique(test_id)) > 1 else " (mean)"
    for panel, name in enumerate(names):
        for part, mu in predicted.items():
            color, shade = _LOOK[part]
            found = binned_residual(points[name].to_numpy(), points["mu"].to_numpy() - mu, test_id, weight)
            if np.isfinite(found.half).any():
                half = np.nan_to_num(found.half)
                chart.band(panel, found.centre, found.mean - half, found.mean + half, shade, group=part)
            chart.scatter(
                panel, found.centre, found.mean, f"{part}{interval}",
                f"{name} %{{x:.4g}}<br>%{{y:+.4f}} from %{{customdata}} tests<extra>{part}</extra>", part,
                mode="lines+markers", line={"color": color, "width": 2}, marker={"size": 5}, customdata=found.tests,
            )  # fmt: skip
    return chart.dress(330, x=[with_unit(n) for n in names], y="measured &#8722; model (mu)")


def worst_tests_chart(
    points: pd.DataFrame, predicted: Mapping[str, FloatArray], tests: Sequence[str]
) -> Chart:
    """Return mu over sliding distance, measured and modelled, one panel a test."""
    chart = Chart(len(tests), titles=tests, shared_yaxes=True, horizontal_spacing=0.022)
    test_id = points["test_id"].to_numpy().astype(str)
    along = "sd [mm]" if "sd" in points.columns and np.ptp(points["sd"]) > 0.0 else "number of the point"
    mode = "markers" if len(points) <= 2 * points["test_id"].nunique() else "lines"
    said = f"{along} %{{x:.1f}}<br>mu %{{y:.4f}}<extra>%{{fullData.name}}</extra>"
    for panel, name in enumerate(tests):
        rows = np.flatnonzero(test_id == name)
        rows = rows[:: max(1, len(rows) // 250)]
        sd = points["sd"].to_numpy()[rows] if along == "sd [mm]" else np.arange(len(rows))
        dots = {"size": 3.2, "color": PRESS, "opacity": 0.45}
        chart.scatter(panel, sd, points["mu"].to_numpy()[rows], "measured", said, mode="markers", marker=dots)
        for part, mu in predicted.items():
            line = {"color": _LOOK[part][0], "width": 2.4}
            chart.scatter(panel, sd, mu[rows], part, said, mode=mode, line=line)
    return chart.dress(330, x=along, y="mu", margin_t=62)
