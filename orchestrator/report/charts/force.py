"""Force over stroke of every friction model against the press."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...force_curves.forces import ForceComparison
from ..parts.theme import PRESS, PRESS_BAND, STYLES, dress


@dataclass(frozen=True)
class ForceLine:
    """One friction model on all levels; `part` chooses its look (see `theme.STYLES`)."""

    label: str
    part: str
    levels: Mapping[str, ForceComparison]


def force_chart(lines: Sequence[ForceLine], levels: Mapping[str, str]) -> Any:
    """Return forces (top) and their deviation from the press mean (bottom), one column a level.

    Parameters
    ----------
    lines : sequence of ForceLine
        The simulations.
    levels : mapping
        Name of each level and its heading.
    """
    from plotly.subplots import make_subplots

    names = list(levels)
    chart = make_subplots(
        rows=2,
        cols=len(names),
        shared_xaxes=True,
        shared_yaxes="rows",
        row_heights=[0.6, 0.4],
        vertical_spacing=0.07,
        horizontal_spacing=0.03,
        subplot_titles=[levels[n] for n in names],
    )
    for column, name in enumerate(names, 1):
        first = column == 1
        press = lines[0].levels[name]
        stroke, mean, std = press.stroke, press.measured, press.measured_std
        _band(chart, stroke, mean - std, mean + std, 1, column, first)
        chart.add_scatter(
            x=stroke, y=mean, name="press, mean and scatter", line={"color": PRESS, "width": 2.2},
            legendgroup="press", showlegend=first, row=1, col=column,
            hovertemplate="press %{y:.1f} kN<extra></extra>",
        )  # fmt: skip
        shown = mean > 0.15 * mean.max()
        relative = 100 * std[shown] / mean[shown]
        _band(chart, stroke[shown], -relative, relative, 2, column, False)
        chart.add_hline(y=0, line={"color": PRESS, "width": 1.5}, row=2, col=column)
        for line in lines:
            result = line.levels[name]
            style = STYLES[line.part]
            chart.add_scatter(
                x=result.stroke, y=result.simulated, name=line.label, legendgroup=line.label, showlegend=first,
                line=style, row=1, col=column, hovertemplate=f"{line.label} %{{y:.1f}} kN<extra></extra>",
            )  # fmt: skip
            keep = result.measured > 0.15 * result.measured.max()
            deviation = 100 * (result.simulated[keep] / result.measured[keep] - 1)
            chart.add_scatter(
                x=result.stroke[keep], y=deviation, legendgroup=line.label, showlegend=False, line=style, row=2,
                col=column, hovertemplate=f"{line.label} %{{y:+.1f}} %<extra></extra>",
            )  # fmt: skip
        chart.update_xaxes(title_text="stroke [mm]", row=2, col=column)
    dress(chart, 560)
    chart.update_layout(margin_t=66)
    chart.update_yaxes(title_text="punch force [kN]", rangemode="tozero", row=1, col=1)
    chart.update_yaxes(title_text="deviation [%]", row=2, col=1)
    return chart


def _band(chart: Any, x: Any, low: Any, high: Any, row: int, column: int, legend: bool) -> None:
    common = {"mode": "lines", "line": {"width": 0}, "hoverinfo": "skip", "showlegend": False}
    chart.add_scatter(x=x, y=low, legendgroup="press", row=row, col=column, **common)
    chart.add_scatter(
        x=x, y=high, legendgroup="press", fill="tonexty", fillcolor=PRESS_BAND, row=row, col=column, **common
    )
