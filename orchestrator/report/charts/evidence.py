"""Evidence charts: the error budget and the ranking of the effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..parts.theme import AFTER, BEFORE, CONSTANT, SOFT, dress


def budget_chart(floor: float, explained: float, missing: float, named: bool) -> Any:
    """Return the error budget before and after as bars of the mean square error, relative to that before."""
    import plotly.graph_objects as go

    squares = {"floor": floor**2, "explained": explained**2, "missing": missing**2}
    total = sum(squares.values()) or 1.0
    rows = ["after", "before"] if named else ["now"]
    parts = (
        ("floor", "noise floor (cannot be removed)", CONSTANT),
        ("explained", "explained by what is named", AFTER),
        ("missing", "still missing", BEFORE),
    )
    chart = go.Figure()
    for key, label, color in parts:
        share = 100 * squares[key] / total
        if key == "explained" and not named:
            continue
        values = [0.0 if key == "explained" and row == "after" else share for row in rows]
        chart.add_bar(
            y=rows, x=values, name=label, orientation="h", marker={"color": color},
            text=[f"{v:.0f} %" if v >= 5 else "" for v in values], textposition="inside", insidetextanchor="middle",
            textfont={"color": "white", "size": 14}, hovertemplate=f"{label} %{{x:.1f}} %<extra>%{{y}}</extra>",
        )  # fmt: skip
    dress(chart, 118 + 46 * len(rows))
    chart.update_layout(
        barmode="stack", bargap=0.22, margin={"l": 58, "t": 44, "b": 40}, legend_traceorder="normal"
    )
    chart.update_xaxes(range=[0, 100], ticksuffix=" %", title_text="share of the mean square error before")
    chart.update_yaxes(ticks="", showgrid=False, tickfont={"color": SOFT, "size": 13})
    return chart


def ranking_chart(
    ranking: Sequence[Mapping[str, Any]],
    chosen: Sequence[str],
    confusable: Sequence[str],
    threshold: float | None = None,
) -> Any:
    """Return the gain of each effect and the gain that chance alone may give (dashed line).

    The chosen ones and those the data cannot tell from them stand out.
    """
    import plotly.graph_objects as go

    shown = ranking[:12][::-1]
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
    if threshold is not None:
        chart.add_vline(x=threshold, line={"color": SOFT, "width": 1.5, "dash": "dash"})
        chart.add_annotation(
            x=threshold, y=0, yref="paper", yanchor="bottom", xanchor="left", showarrow=False,
            text=f" needed: {threshold:.0f}",
        )  # fmt: skip
    dress(chart, 70 + 27 * max(len(shown), 2), legend=False)
    chart.update_layout(bargap=0.32, margin_t=10)
    chart.update_xaxes(title_text="gain (whitened squares, less 2 for each parameter)", showgrid=True)
    chart.update_yaxes(showgrid=False, ticks="", tickfont={"color": SOFT, "size": 13})
    return chart
