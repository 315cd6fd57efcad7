"""Charts of the forming-error study: bars with error bars, errors level by level, forces at every level."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from friction_models.common.markup import escape

from ...studies.forming_error.result import TAU_OVER_K, FormingErrors
from ...studies.forming_error.rows import RunError
from ...studies.forming_error.words import PROCESS_TITLES
from ..parts.chart import Chart
from ..parts.theme import COLORS, INK, PRESS, PRESS_BAND, SIGNED, SOFT

UNITS = {"max_force": "kN", "work": "J"}
#: Constant friction in greys, trained models in colours.
_CONSTANT_COLOURS = ("#b4bcc5", "#7d8894", "#4d5661")
#: Points of a drawn curve.
_DRAWN = 90
#: From too low (blue) over none (white) to too high (orange).


def colours(errors: FormingErrors) -> dict[str, str]:
    """Return the colour of each friction law."""
    constants = [f.label for f in errors.frictions if f.constant]
    models = [f.label for f in errors.frictions if not f.constant]
    chosen = {label: _CONSTANT_COLOURS[k % 3] for k, label in enumerate(constants)}
    chosen |= {label: COLORS[k % len(COLORS)] for k, label in enumerate(models)}
    return {f.label: chosen[f.label] for f in errors.frictions}


def groups(errors: FormingErrors) -> list[tuple[str, str]]:
    """Return lubricant and process of each group of levels."""
    return [(lubricant, process) for lubricant in errors.lubricants for process in errors.processes]


def group_title(lubricant: str, process: str) -> str:
    """Return the heading of a group."""
    return f"{PROCESS_TITLES.get(process, process)}, {lubricant}"


def _whisker(
    above: Sequence[float],
    values: Sequence[float | None] | None = None,
    thickness: float = 1.1,
    width: int = 3,
) -> dict[str, object]:
    """Return error bars; with `values` also downward ones, none below zero, which an error cannot be."""
    bars: dict[str, object] = {"type": "data", "array": list(above), "symmetric": False}
    if values is not None:
        bars["arrayminus"] = [min(bar, value or 0.0) for bar, value in zip(above, values)]
    return bars | {"color": INK, "thickness": thickness, "width": width}


def error_bars(errors: FormingErrors, quantity: str, measure: Literal["mare", "spread"]) -> Chart:
    """Return bars of MARE or of its spread over the levels."""
    chart = Chart()
    names = [group_title(*group).replace(", ", "<br>") for group in groups(errors)]
    for label, color in colours(errors).items():
        values, bars = list[float | None](), list[float]()
        for lubricant, process in groups(errors):
            found = errors.summary(label, lubricant, process)
            level = getattr(found, quantity) if found is not None else None
            values.append(None if level is None else 100 * getattr(level, measure))
            bars.append(0.0 if level is None else 100 * getattr(level, f"{measure}_std"))
        said = f"{label} %{{y:.1f}} %<extra></extra>"
        chart.bars(0, names, values, label, said, marker={"color": color}, error_y=_whisker(bars, values))
    return chart.dress(380, y="error [%]", from_zero=True, barmode="group", bargap=0.22, margin_t=66)


def level_map(errors: FormingErrors, quantity: str) -> Chart:
    """Return the signed relative error of every friction law (rows) at every level (columns), a map a group.

    Columns are named by tool temperature and punch speed [mm/s].
    """
    parts = groups(errors)
    laws = [f.label for f in errors.frictions][::-1]
    chart = Chart.of_panels(
        len(parts), 2, 0.3, legend=False, titles=[group_title(*g) for g in parts],
        shared_yaxes=True, horizontal_spacing=0.03,
    )  # fmt: skip
    signed = {
        (r.lubricant, r.process, r.friction, r.level): 100 * getattr(r.force, quantity).signed
        for r in errors.runs
    }
    top = float(max(5.0, np.quantile(np.abs(list(signed.values())), 0.95)))
    for panel, group in enumerate(parts):
        levels = _levels(errors, *group)
        cells = [[signed.get((*group, law, r.level)) for r in levels] for law in laws]
        chart.figure.add_heatmap(
            x=[_level_name(r) for r in levels], y=laws, z=cells,
            text=[["" if c is None else f"{c:+.1f}".replace("-0.0", "0.0") for c in row] for row in cells], texttemplate="%{text}",
            textfont={"size": 11}, zmin=-top, zmax=top, colorscale=SIGNED, showscale=False, xgap=1, ygap=1,
            hovertemplate="%{y}, %{x}: %{z:+.1f} %<extra></extra>", **chart.place(panel),
        )  # fmt: skip
    chart.dress(60 + chart.rows * (110 + 27 * len(laws)), margin_t=34)
    chart.figure.update_xaxes(tickfont_size=10, tickangle=0, ticks="", showline=False)
    chart.figure.update_yaxes(ticks="", showgrid=False)
    return chart


def absolute_bars(errors: FormingErrors, quantity: str) -> Chart:
    """Return the absolute error of every friction law at every level with the scatter of the press, a panel a group."""
    parts = groups(errors)
    chart = Chart.of_panels(len(parts), 1, 0.24, titles=[escape(group_title(*g)) for g in parts])
    for panel, group in enumerate(parts):
        names = {r.level: _level_name(r) for r in _levels(errors, *group)}
        for label, color in colours(errors).items():
            runs = {r.level: getattr(r.force, quantity) for r in errors.of_group(label, *group)}
            there = [level for level in names if level in runs]
            values = [runs[level].ae for level in there]
            whisker = _whisker([runs[level].ae_std for level in there], values, 0.9, 2)
            chart.bars(
                panel, [names[level] for level in there], values, label, f"{label} %{{y:.2f}}<extra></extra>",
                marker_color=color, error_y=whisker,
            )  # fmt: skip
    height = 90 + 230 * len(parts)
    return chart.dress(height, y=UNITS[quantity], from_zero=True, barmode="group", bargap=0.2, margin_t=72)


def force_charts(errors: FormingErrors, lubricant: str, process: str, difference: bool = False) -> Chart:
    """Return force over stroke of every friction law and of the press, a panel a level; or what differs from the press."""
    levels = _levels(errors, lubricant, process)
    chart = Chart.of_panels(
        len(levels), titles=[f"tools {r.T_tool:g} °C, {r.speed:g} mm/s" for r in levels],
        gap=0.16 if len(levels) > 3 else 0.08, shared_xaxes=True, shared_yaxes="all", horizontal_spacing=0.025,
    )  # fmt: skip
    shade = colours(errors)
    for panel, shown in enumerate(levels):
        press = shown.force
        at = _thin(len(press.stroke))
        x, middle = press.stroke[at].round(2), (press.measured * (not difference))[at]
        scatter = press.measured_std[at]
        chart.band(
            panel, x, (middle - scatter).round(2), (middle + scatter).round(2), PRESS_BAND, group="press"
        )
        chart.scatter(
            panel, x, middle.round(2), "press, mean and scatter", "press %{y:.0f} kN<extra></extra>", "press",
            mode="lines", line={"color": PRESS, "width": 2.4},
        )  # fmt: skip
        for friction in errors.frictions:
            dash = "dash" if friction.constant else "solid"
            for run in errors.of_group(friction.label, lubricant, process):
                if run.level == shown.level:
                    at = _thin(len(run.force.stroke))
                    force = run.force.simulated - run.force.measured * difference
                    chart.scatter(
                        panel, run.force.stroke[at].round(2), force[at].round(2), friction.label,
                        f"{friction.label} %{{y:.0f}} kN<extra></extra>", mode="lines",
                        line={"color": shade[friction.label], "width": 1.4, "dash": dash},
                    )  # fmt: skip
    title = "difference [kN]" if difference else "force [kN]"
    chart.dress(100 + 215 * chart.rows, x="stroke [mm]", y=title, margin_t=76)
    chart.figure.update_yaxes(rangemode="normal" if difference else "tozero")
    return chart


def share_bars(errors: FormingErrors, what: Literal["time", "tau"]) -> Chart:
    """Return bars by friction law: ``"time"``, the run time of friction; ``"tau"``, the highest tau/k by process."""
    chart = Chart()
    time = what == "time"
    labels = [f.label for f in errors.frictions]
    for number, process in enumerate(errors.processes):
        found = [errors.summary(label, None, process) for label in labels]
        y = [None if s is None else 100 * (s.friction_share if time else s.tau_over_k) for s in found]
        more: dict[str, object] = {}
        if time:
            over = [0.0 if s is None else 100 * (s.friction_share_max - s.friction_share) for s in found]
            more["error_y"] = _whisker(over)
        title = PROCESS_TITLES.get(process, process)
        said = f"%{{x}}, {title}: %{{y:.2f}} %<extra></extra>"
        chart.bars(0, labels, y, title, said, marker={"color": COLORS[2 * number]}, **more)
    limit, note = (1.0, "1 %") if time else (100 * TAU_OVER_K, "paper: below 60 %")
    chart.figure.add_hline(
        y=limit, line={"color": SOFT, "width": 1.3, "dash": "dash"}, annotation_text=note, annotation_position="top right"
    )  # fmt: skip
    title = "time in friction over the rest [%]" if time else "highest tau/k [%]"
    return chart.dress(320, y=title, from_zero=True, barmode="group", bargap=0.3)


def _levels(errors: FormingErrors, lubricant: str, process: str) -> list[RunError]:
    """Return one run of each level of a group, by tool temperature and speed."""
    first: dict[str, RunError] = {}
    for run in errors.runs:
        if (run.lubricant, run.process) == (lubricant, process):
            first.setdefault(run.level, run)
    return sorted(first.values(), key=lambda r: (r.T_tool, r.speed))


def _level_name(run: RunError) -> str:
    return f"{run.T_tool:g} °C<br>{run.speed:g}"


def _thin(count: int) -> Sequence[int]:
    return [int(i) for i in np.unique(np.linspace(0, count - 1, min(count, _DRAWN)).round())]
