"""Tests that were predicted in a closed loop: friction and contact temperature over the sliding distance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from .theme import PRESS, STYLES, dress


def prediction_chart(
    measured: Mapping[str, pd.DataFrame],
    predicted: Mapping[str, Mapping[str, pd.DataFrame]],
    labels: Mapping[str, str],
    headings: Sequence[str],
) -> Any:
    """Return mu (top) and contact temperature (bottom) over sliding distance, one column a test.

    Parameters
    ----------
    measured : mapping
        Test to its measured points (`sd, mu, T`).
    predicted : mapping
        Part of the story (``before``, ``after``) to test to predicted points (`sd, mu_model, T`).
    labels : mapping
        Part to the name of its model.
    headings : sequence of str
        Heading of each test.
    """
    from plotly.subplots import make_subplots

    chart = make_subplots(
        rows=2, cols=len(measured), shared_xaxes=True, shared_yaxes="rows", horizontal_spacing=0.03,
        vertical_spacing=0.08, subplot_titles=list(headings),
    )  # fmt: skip
    for column, (test, points) in enumerate(measured.items(), 1):
        thin = points.iloc[:: max(1, len(points) // 250)]
        marker = {"size": 3.2, "color": PRESS, "opacity": 0.45}
        for row, name, form in ((1, "mu", "mu %{y:.4f}"), (2, "T", "T %{y:.0f} degC")):
            chart.add_scatter(
                x=thin["sd"], y=thin[name], mode="markers", name="measured", legendgroup="measured", marker=marker,
                showlegend=column == row == 1, row=row, col=column,
                hovertemplate=f"sd %{{x:.1f}} mm<br>{form}<extra>measured</extra>",
            )  # fmt: skip
        for part, tests in predicted.items():
            found = tests[test]
            for row, name, form in ((1, "mu_model", "mu %{y:.4f}"), (2, "T", "T %{y:.0f} degC")):
                chart.add_scatter(
                    x=found["sd"], y=found[name], mode="lines", name=f"{part}: {labels[part]}", legendgroup=part,
                    line=STYLES[part], showlegend=column == row == 1, row=row, col=column,
                    hovertemplate=f"sd %{{x:.1f}} mm<br>{form}<extra>{part}</extra>",
                )  # fmt: skip
        chart.update_xaxes(title_text="sd [mm]", row=2, col=column)
    dress(chart, 520)
    chart.update_layout(margin_t=66)
    chart.update_yaxes(title_text="mu", row=1, col=1)
    chart.update_yaxes(title_text="contact T [°C]", row=2, col=1)
    return chart
