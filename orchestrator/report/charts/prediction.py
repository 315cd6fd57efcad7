"""Tests that were predicted in a closed loop: friction and contact temperature over the sliding distance."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from ..parts.chart import Chart
from ..parts.theme import PRESS, STYLES


def prediction_chart(
    headings: Mapping[str, str],
    measured: Mapping[str, pd.DataFrame],
    predicted: Mapping[str, Mapping[str, pd.DataFrame]],
    labels: Mapping[str, str],
) -> Chart:
    """Return mu (top) and contact temperature (bottom) over sliding distance, one column a test.

    `headings` and `measured` (`sd, mu, T`, where it was run) are by test, `predicted` (`sd, mu_model, T`) by part
    (``before``, ``after``) and test, `labels` name the parts in the legend.
    """
    chart = Chart(
        len(headings), 2, titles=list(headings.values()), shared_xaxes=True, shared_yaxes="rows",
        horizontal_spacing=0.03, vertical_spacing=0.08,
    )  # fmt: skip
    dots = {"size": 3.2, "color": PRESS, "opacity": 0.45}
    for column, test in enumerate(headings):
        points = measured.get(test, pd.DataFrame(columns=["sd", "mu", "T"]))
        thin = points.iloc[:: max(1, len(points) // 250)]
        for panel, mu, form in (
            (column, "mu_model", "mu %{y:.4f}"),
            (len(headings) + column, "T", "T %{y:.0f} degC"),
        ):
            said = f"sd %{{x:.1f}} mm<br>{form}<extra>%{{fullData.name}}</extra>"
            if len(thin):
                y = thin[mu.removesuffix("_model")]
                chart.scatter(panel, thin["sd"], y, "measured", said, mode="markers", marker=dots)
            for part, tests in predicted.items():
                found = tests[test]
                chart.scatter(
                    panel, found["sd"], found[mu], labels[part], said, part, mode="lines", line=STYLES[part]
                )
    chart.dress(520, x="sd [mm]", y=["mu", "contact T [°C]"], margin_t=66)
    chart.figure.update_yaxes(rangemode="nonnegative", row=1)
    return chart
