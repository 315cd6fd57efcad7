"""Tests that were predicted in a closed loop: friction and contact temperature over the sliding distance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from ..parts.theme import PRESS, STYLES, dress


def prediction_chart(
    headings: Mapping[str, str],
    measured: Mapping[str, pd.DataFrame],
    predicted: Mapping[str, Mapping[str, pd.DataFrame]],
    labels: Mapping[str, str],
) -> Any:
    """Return mu (top) and contact temperature (bottom) over sliding distance, one column a test.

    Parameters
    ----------
    headings : mapping
        Test to its heading; the columns of the chart.
    measured : mapping
        Test to its measured points (`sd, mu, T`), where it was run.
    predicted : mapping
        Part of the story (``before``, ``after``) to test to predicted points (`sd, mu_model, T`).
    labels : mapping
        Part to its name in the legend.
    """
    from plotly.subplots import make_subplots

    chart = make_subplots(
        rows=2, cols=len(headings), shared_xaxes=True, shared_yaxes="rows", horizontal_spacing=0.03,
        vertical_spacing=0.08, subplot_titles=list(headings.values()),
    )  # fmt: skip
    forms = {"mu": "mu %{y:.4f}", "T": "T %{y:.0f} degC"}
    for column, test in enumerate(headings, 1):
        points = measured.get(test, pd.DataFrame(columns=["sd", "mu", "T"]))
        thin = points.iloc[:: max(1, len(points) // 250)]
        marker = {"size": 3.2, "color": PRESS, "opacity": 0.45}
        for row, name in ((1, "mu"), (2, "T")) if len(thin) else ():
            chart.add_scatter(
                x=thin["sd"], y=thin[name], mode="markers", name="measured", legendgroup="measured", marker=marker,
                showlegend=column == row == 1, row=row, col=column,
                hovertemplate=f"sd %{{x:.1f}} mm<br>{forms[name]}<extra>measured</extra>",
            )  # fmt: skip
        for part, tests in predicted.items():
            found = tests[test]
            for row, name in ((1, "mu_model"), (2, "T")):
                chart.add_scatter(
                    x=found["sd"], y=found[name], mode="lines", name=labels[part], legendgroup=part,
                    line=STYLES[part], showlegend=column == row == 1, row=row, col=column,
                    hovertemplate=f"sd %{{x:.1f}} mm<br>{forms[name.partition('_')[0]]}<extra>{labels[part]}</extra>",
                )  # fmt: skip
        chart.update_xaxes(title_text="sd [mm]", row=2, col=column)
    dress(chart, 520)
    chart.update_layout(margin_t=66)
    chart.update_yaxes(rangemode="nonnegative", row=1)
    chart.update_yaxes(title_text="mu", row=1, col=1)
    chart.update_yaxes(title_text="contact T [°C]", row=2, col=1)
    return chart
