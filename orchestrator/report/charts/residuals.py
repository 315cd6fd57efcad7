"""Charts of residuals: over each load, and in the worst tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from friction_models.discovery.answer.figures_data import varied
from friction_models.discovery.answer.summaries import clustered_mean, load_bins
from friction_models.loads import LOADS, FloatArray
from friction_models.loads.contract import with_unit

from ..parts.chart import Chart
from ..parts.theme import AFTER, AFTER_BAND, BEFORE, BEFORE_BAND, PRESS

#: Most bins of a load, and fewest tests in each.
BINS, MIN_TESTS = 9, 3
_LOOK = {"before": (BEFORE, BEFORE_BAND), "after": (AFTER, AFTER_BAND)}


def residual_chart(points: pd.DataFrame, predicted: Mapping[str, FloatArray]) -> Chart:
    """Return the mean residual over each load that varies with per-test intervals, one panel a load.

    `predicted` is mu of the models ``before`` and (where there is one) ``after``.
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


class BinnedResidual(NamedTuple):
    """Mean of measured - model in bins of one load.

    `centre` is the mean load of each bin, `half` half of the 95 % interval of `mean` over tests (NaN for one test),
    `tests` their number.
    """

    centre: FloatArray
    mean: FloatArray
    half: FloatArray
    tests: np.ndarray


def binned_residual(
    load: FloatArray, residual: FloatArray, test_id: np.ndarray, weight: FloatArray | None = None
) -> BinnedResidual:
    """Bin residuals by quantiles of a load, levels of a plan kept together.

    The interval of a bin treats a test as the unit, so that 500 points of one test do not count as 500 observations
    (no interval for a single test). There are as many bins, up to nine, as leave at least three tests in each.

    `weight`: points behind each value; one each by default.

    Examples
    --------
    Six tests at two temperatures; the model is right at 20 degC and 0.01 too low at 80 degC:

    >>> load = np.array([20.0, 20.0, 20.0, 80.0, 80.0, 80.0])
    >>> residual = np.array([0.001, -0.001, 0.0, 0.011, 0.009, 0.010])
    >>> found = binned_residual(load, residual, np.array(list("abcdef")))
    >>> found.centre, found.mean.round(6) + 0.0, found.tests
    (array([20., 80.]), array([0.  , 0.01]), array([3, 3]))
    """
    _, test = np.unique(test_id, return_inverse=True)
    which = _bins(load, test)
    points = np.ones(len(load)) if weight is None else np.asarray(weight, dtype=float)
    rows = []
    for k in range(int(which.max()) + 1):
        inside = which == k
        mean, half, tests = clustered_mean(residual, points, test, inside)
        rows.append((float(load[inside].mean()), mean, half, tests))
    table = np.array(rows, dtype=float).reshape(-1, 4)
    return BinnedResidual(table[:, 0], table[:, 1], table[:, 2], table[:, 3].astype(int))


def _bins(load: FloatArray, test: np.ndarray) -> np.ndarray:
    """Return the bin of each point: quantiles of the load, as many as leave `MIN_TESTS` tests in each."""
    least = min(MIN_TESTS, len(np.unique(test)))
    for count in range(BINS, 0, -1):
        which = load_bins(load, count)
        present = [len(np.unique(test[which == k])) for k in range(int(which.max()) + 1)]
        if min(present) >= least:
            break
    return which
