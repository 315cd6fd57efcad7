"""Evidence charts: the error budget and the ranking of the effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .theme import AFTER, BEFORE, CONSTANT, SOFT, dress

_PARTS = (
    ("floor", "noise floor (cannot be removed)", CONSTANT),
    ("explained", "explained by the effect", AFTER),
    ("missing", "still missing", BEFORE),
)


def budget_chart(budget: Mapping[str, float | None]) -> Any:
    """Return the error budget as one bar: floor, explained, still missing, as shares of the mean square error."""
    import plotly.graph_objects as go

    values = {key: max(float(budget.get(key) or 0.0), 0.0) for key, _, _ in _PARTS}
    total = sum(values.values()) or 1.0
    chart = go.Figure()
    for key, label, color in _PARTS:
        share = 100 * values[key] / total
        chart.add_bar(
            y=[""], x=[share], name=f"{label}: {share:.0f} %", orientation="h", marker={"color": color},
            text=[f"{share:.0f} %" if share >= 6 else ""], textposition="inside", insidetextanchor="middle",
            textfont={"color": "white", "size": 14}, hovertemplate=f"{label} %{{x:.1f}} %<extra></extra>",
        )  # fmt: skip
    dress(chart, 150)
    chart.update_layout(
        barmode="stack", bargap=0.1, margin={"l": 4, "r": 14, "t": 44, "b": 34}, legend_traceorder="normal"
    )
    chart.update_xaxes(range=[0, 100], ticksuffix=" %", showgrid=False)
    chart.update_yaxes(showticklabels=False, ticks="", showgrid=False)
    return chart


def ranking_chart(
    ranking: Sequence[Mapping[str, Any]], chosen: Sequence[str], confusable: Sequence[str]
) -> Any:
    """Return the gain of each effect; the chosen ones and those the data cannot tell from them stand out."""
    import plotly.graph_objects as go

    shown = [r for r in ranking if r.get("gain") is not None][:12][::-1]
    colors = [
        AFTER if r["effect"] in chosen else "#6fb5b1" if r["effect"] in confusable else CONSTANT
        for r in shown
    ]
    chart = go.Figure()
    chart.add_bar(
        y=[str(r["effect"]) for r in shown],
        x=[max(float(r["gain"]), 0.0) for r in shown],
        orientation="h",
        marker={"color": colors},
        hovertemplate="%{y}: gain %{x:.1f}<extra></extra>",
    )
    dress(chart, 70 + 27 * max(len(shown), 2), legend=False)
    chart.update_layout(bargap=0.32, margin_t=10)
    chart.update_xaxes(
        title_text="evidence gained (whitened squares, less 2 for each parameter)", showgrid=True
    )
    chart.update_yaxes(showgrid=False, ticks="", tickfont={"color": SOFT, "size": 13})
    return chart
