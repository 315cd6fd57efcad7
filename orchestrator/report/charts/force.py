"""Force over stroke of every friction model against the press."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...force_curves.forces import ForceComparison
from ..parts.chart import Chart
from ..parts.theme import PRESS, PRESS_BAND, STYLES


@dataclass(frozen=True)
class ForceLine:
    """One friction model on all levels; `part` chooses its look (see `theme.STYLES`)."""

    label: str
    part: str
    levels: Mapping[str, ForceComparison]


def draw_press(
    chart: Chart, at: int, press: ForceComparison, name: str = "press", width: float = 2.4
) -> None:
    """Draw the mean of the repeats of a press and the band of their standard deviation."""
    mean, std = press.measured, press.measured_std
    chart.band(at, press.stroke, mean - std, mean + std, PRESS_BAND, group="press")
    said = "press %{y:.1f} kN<extra></extra>"
    chart.scatter(at, press.stroke, mean, name, said, "press", line={"color": PRESS, "width": width})


def force_chart(lines: Sequence[ForceLine], levels: Mapping[str, str]) -> Chart:
    """Return forces (top) and their deviation from the press mean (bottom), one column a level (name to heading)."""
    chart = Chart(
        len(levels), 2, titles=list(levels.values()), shared_xaxes=True, shared_yaxes="rows",
        row_heights=[0.6, 0.4], vertical_spacing=0.07, horizontal_spacing=0.03,
    )  # fmt: skip
    for column, name in enumerate(levels):
        below = len(levels) + column
        press = lines[0].levels[name]
        draw_press(chart, column, press, "press, mean and scatter", 2.2)
        stroke, mean, std = press.stroke, press.measured, press.measured_std
        shown = mean > 0.15 * mean.max()
        relative = 100 * std[shown] / mean[shown]
        chart.band(below, stroke[shown], -relative, relative, PRESS_BAND, group="press")
        chart.figure.add_hline(y=0, line={"color": PRESS, "width": 1.5}, **chart.place(below))
        for line in lines:
            found, look = line.levels[name], STYLES[line.part]
            chart.scatter(
                column, found.stroke, found.simulated, line.label, f"{line.label} %{{y:.1f}} kN<extra></extra>", line=look
            )  # fmt: skip
            keep = found.measured > 0.15 * found.measured.max()
            deviation = 100 * (found.simulated[keep] / found.measured[keep] - 1)
            said = f"{line.label} %{{y:+.1f}} %<extra></extra>"
            chart.scatter(below, found.stroke[keep], deviation, hover=said, group=line.label, line=look)
    chart.dress(560, x="stroke [mm]", y=["punch force [kN]", "deviation [%]"], margin_t=66)
    chart.figure.update_yaxes(rangemode="tozero", **chart.place(0))
    return chart
