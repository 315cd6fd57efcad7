"""One look for all charts: colours that hold in print and for colour-blind readers, quiet axes."""

from __future__ import annotations

from typing import Any

INK, SOFT, LINE = "#1b2530", "#566474", "#e1e6eb"
PRESS, PRESS_BAND = "#3d4854", "rgba(61, 72, 84, 0.17)"
BEFORE, AFTER, OTHER, CONSTANT = "#c8641f", "#0a7f79", "#7d62a8", "#9aa4af"
BEFORE_BAND, AFTER_BAND = "rgba(200, 100, 31, 0.16)", "rgba(10, 127, 121, 0.16)"
#: Colour and dash of a friction model by its part in a comparison.
STYLES: dict[str, dict[str, str | float]] = {
    "constant": {"color": CONSTANT, "width": 2, "dash": "dash"},
    "before": {"color": BEFORE, "width": 2},
    "other": {"color": OTHER, "width": 2, "dash": "dot"},
    "after": {"color": AFTER, "width": 2.6},
}
FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif'


def dress(chart: Any, height: int, legend: bool = True) -> Any:
    """Apply the common look to a plotly figure and return it."""
    chart.update_layout(
        template="none",
        height=height,
        margin={"l": 62, "r": 14, "t": 48 if legend else 30, "b": 50},
        font={"family": FONT, "size": 13, "color": INK},
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        hoverlabel={"font": {"family": FONT, "size": 12}},
        showlegend=legend,
        legend={
            "orientation": "h",
            "x": 0,
            "y": 1.0,
            "yref": "container",
            "yanchor": "top",
            "font": {"size": 13},
        },
    )
    axis = {
        "gridcolor": LINE,
        "zerolinecolor": "#b8c2cc",
        "zerolinewidth": 1,
        "linecolor": "#b8c2cc",
        "ticks": "outside",
        "tickcolor": "#b8c2cc",
        "ticklen": 4,
        "title_standoff": 8,
        "title_font_size": 13,
        "automargin": True,
    }
    chart.update_xaxes(**axis, showgrid=False, showline=True)
    chart.update_yaxes(**axis, showgrid=True, showline=False)
    for note in chart.layout.annotations:
        note.font.size = 13
        note.font.color = SOFT
    return chart
