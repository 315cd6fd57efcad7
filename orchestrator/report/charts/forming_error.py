"""Charts of the forming-error study: bars with error bars, errors level by level, forces at every level."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...studies.forming_error.result import TAU_OVER_K, FormingErrors
from ...studies.forming_error.rows import RunError
from ...studies.forming_error.words import PROCESS_TITLES
from ..parts.markup import escape
from ..parts.palette import COLORS
from ..parts.theme import INK, PRESS, PRESS_BAND, SOFT, dress

#: Constant friction in greys, trained models in colours.
_CONSTANT_COLOURS = ("#b4bcc5", "#7d8894", "#4d5661")
#: Points of a drawn curve.
_DRAWN = 90


def colours(errors: FormingErrors) -> dict[str, str]:
    """Return the colour of each friction law."""
    constants = [f.label for f in errors.frictions if f.constant]
    models = [f.label for f in errors.frictions if not f.constant]
    chosen = {label: _CONSTANT_COLOURS[k % 3] for k, label in enumerate(constants)}
    return chosen | {label: COLORS[k % len(COLORS)] for k, label in enumerate(models)}


def groups(errors: FormingErrors) -> list[tuple[str, str]]:
    """Return lubricant and process of each group of levels."""
    return [(lubricant, process) for lubricant in errors.lubricants for process in errors.processes]


def group_title(lubricant: str, process: str) -> str:
    """Return the heading of a group."""
    return f"{PROCESS_TITLES.get(process, process)}, {lubricant}"


def error_bars(errors: FormingErrors, quantity: str, measure: str) -> Any:
    """Return bars of MARE (`measure` ``"mare"``) or of the spread (``"spread"``) of ``max_force`` or ``work``."""
    import plotly.graph_objects as go

    chart = go.Figure()
    names = [group_title(*group).replace(", ", "<br>") for group in groups(errors)]
    shade = colours(errors)
    for friction in errors.frictions:
        values, bars = list[float | None](), list[float]()
        for lubricant, process in groups(errors):
            found = errors.summary(friction.label, lubricant, process)
            level = getattr(found, quantity) if found is not None else None
            values.append(None if level is None else 100 * getattr(level, measure))
            bars.append(0.0 if level is None else 100 * getattr(level, f"{measure}_std"))
        chart.add_bar(
            x=names, y=values, name=friction.label, marker={"color": shade[friction.label]},
            # No bar of an error reaches below zero, which an error cannot be.
            error_y={
                "type": "data", "array": bars, "arrayminus": [min(b, v or 0.0) for b, v in zip(bars, values)],
                "symmetric": False, "color": INK, "thickness": 1.1, "width": 3,
            },
            hovertemplate=f"{friction.label} %{{y:.1f}} %<extra></extra>",
        )  # fmt: skip
    dress(chart, 380)
    chart.update_layout(barmode="group", bargap=0.22, margin_t=66)
    chart.update_yaxes(title_text="error [%]", rangemode="tozero")
    return chart


def level_map(errors: FormingErrors, quantity: str) -> Any:
    """Return the signed relative error of every friction law (rows) at every level (columns), a map a group.

    Columns are named by tool temperature and punch speed [mm/s].
    """
    from plotly.subplots import make_subplots

    parts = groups(errors)
    laws = [f.label for f in errors.frictions][::-1]
    columns = 2 if len(parts) > 1 else 1
    rows = -(-len(parts) // columns)
    chart = make_subplots(
        rows=rows, cols=columns, subplot_titles=[group_title(*g) for g in parts], shared_yaxes=True,
        horizontal_spacing=0.03, vertical_spacing=0.3 / rows,
    )  # fmt: skip
    signed = {
        (r.lubricant, r.process, r.friction, r.level): 100 * getattr(r.force, quantity).signed
        for r in errors.runs
    }
    top = float(max(5.0, np.quantile(np.abs(list(signed.values())), 0.95)))
    for k, (lubricant, process) in enumerate(parts):
        levels = _levels(errors, lubricant, process)
        cells = [[signed.get((lubricant, process, law, r.level)) for r in levels] for law in laws]
        chart.add_heatmap(
            x=[f"{r.T_tool:g} °C<br>{r.speed:g}" for r in levels], y=laws, z=cells,
            text=[["" if c is None else f"{c:+.1f}".replace("-0.0", "0.0") for c in row] for row in cells], texttemplate="%{text}",
            textfont={"size": 11}, zmin=-top, zmax=top, colorscale=_SIGNED, showscale=False, xgap=1, ygap=1,
            hovertemplate="%{y}, %{x}: %{z:+.1f} %<extra></extra>",
            row=k // columns + 1, col=k % columns + 1,
        )  # fmt: skip
    dress(chart, 60 + rows * (110 + 27 * len(laws)), legend=False)
    chart.update_layout(margin_t=34)
    chart.update_xaxes(tickfont_size=10, tickangle=0, ticks="", showline=False)
    chart.update_yaxes(ticks="", showgrid=False)
    return chart


def absolute_bars(errors: FormingErrors, quantity: str) -> Any:
    """Return the absolute error of every friction law at every level with the scatter of the press, a panel a group."""
    from plotly.subplots import make_subplots

    parts = groups(errors)
    chart = make_subplots(
        rows=len(parts), cols=1, subplot_titles=[escape(group_title(*g)) for g in parts],
        vertical_spacing=0.24 / max(len(parts), 1),
    )  # fmt: skip
    shade = colours(errors)
    for row, (lubricant, process) in enumerate(parts, 1):
        names = {r.level: f"{r.T_tool:g} °C<br>{r.speed:g}" for r in _levels(errors, lubricant, process)}
        for friction in errors.frictions:
            runs = {
                r.level: getattr(r.force, quantity)
                for r in errors.of_group(friction.label, lubricant, process)
            }
            there = [level for level in names if level in runs]
            scatter = [runs[level].ae_std for level in there]
            chart.add_bar(
                x=[names[level] for level in there], y=[runs[level].ae for level in there], name=friction.label,
                legendgroup=friction.label, showlegend=row == 1, marker_color=shade[friction.label], row=row, col=1,
                error_y={
                    "type": "data", "array": scatter, "arrayminus": [min(s, runs[level].ae) for s, level in zip(scatter, there)],
                    "symmetric": False, "color": INK, "thickness": 0.9, "width": 2,
                },
                hovertemplate=f"{friction.label} %{{y:.2f}}<extra></extra>",
            )  # fmt: skip
    dress(chart, 90 + 230 * len(parts))
    chart.update_layout(barmode="group", bargap=0.2, margin_t=72)
    chart.update_yaxes(title_text="kN" if quantity == "max_force" else "J", rangemode="tozero")
    return chart


#: From too low (blue) over none (white) to too high (orange).
_SIGNED = [[0.0, "#3b7fb5"], [0.5, "#ffffff"], [1.0, "#d9772f"]]


def force_charts(errors: FormingErrors, lubricant: str, process: str, difference: bool = False) -> Any:
    """Return force over stroke of every friction law and of the press, a panel a level; or what differs from the press."""
    from plotly.subplots import make_subplots

    levels = _levels(errors, lubricant, process)
    columns = min(3, len(levels))
    rows = -(-len(levels) // columns)
    chart = make_subplots(
        rows=rows, cols=columns, shared_xaxes=True, shared_yaxes="all", horizontal_spacing=0.025,
        vertical_spacing=0.16 / max(rows, 2),
        subplot_titles=[f"tools {r.T_tool:g} °C, {r.speed:g} mm/s" for r in levels],
    )  # fmt: skip
    shade = colours(errors)
    for k, shown in enumerate(levels):
        place = {"row": k // columns + 1, "col": k % columns + 1}
        press = shown.force
        at = _thin(len(press.stroke))
        x = press.stroke[at].round(2)
        quiet = {"mode": "lines", "line": {"width": 0}, "hoverinfo": "skip", "showlegend": False}
        middle = press.measured * (not difference)
        low, high = middle - press.measured_std, middle + press.measured_std
        chart.add_scatter(x=x, y=low[at].round(2), legendgroup="press", **quiet, **place)
        chart.add_scatter(
            x=x,
            y=high[at].round(2),
            fill="tonexty",
            fillcolor=PRESS_BAND,
            legendgroup="press",
            **quiet,
            **place,
        )
        chart.add_scatter(
            x=x, y=middle[at].round(2), name="press, mean and scatter", legendgroup="press", showlegend=k == 0,
            mode="lines", line={"color": PRESS, "width": 2.4}, hovertemplate="press %{y:.0f} kN<extra></extra>", **place,
        )  # fmt: skip
        for friction in errors.frictions:
            for run in errors.of_group(friction.label, lubricant, process):
                if run.level == shown.level:
                    at = _thin(len(run.force.stroke))
                    force = run.force.simulated - run.force.measured * difference
                    line = {
                        "color": shade[friction.label],
                        "width": 1.4,
                        "dash": "dash" if friction.constant else "solid",
                    }
                    chart.add_scatter(
                        x=run.force.stroke[at].round(2), y=force[at].round(2), name=friction.label,
                        legendgroup=friction.label, showlegend=k == 0, mode="lines", line=line,
                        hovertemplate=f"{friction.label} %{{y:.0f}} kN<extra></extra>", **place,
                    )  # fmt: skip
    dress(chart, 100 + 215 * rows)
    chart.update_layout(margin_t=76)
    chart.update_xaxes(title_text="stroke [mm]", row=rows)
    chart.update_yaxes(rangemode="normal" if difference else "tozero")
    chart.update_yaxes(title_text="difference [kN]" if difference else "force [kN]", col=1)
    return chart


def share_bars(errors: FormingErrors, what: str) -> Any:
    """Return bars by friction law: ``"time"``, the run time of friction; ``"tau"``, the highest tau/k by process."""
    import plotly.graph_objects as go

    chart = go.Figure()
    labels = [f.label for f in errors.frictions]
    for number, process in enumerate(errors.processes):
        found = [errors.summary(label, None, process) for label in labels]
        time = what == "time"
        y = [None if s is None else 100 * (s.friction_share if time else s.tau_over_k) for s in found]
        more: dict[str, object] = {}
        if time:
            over = [0.0 if s is None else 100 * (s.friction_share_max - s.friction_share) for s in found]
            more["error_y"] = {
                "type": "data", "array": over, "symmetric": False, "color": INK, "thickness": 1.1, "width": 3,
            }  # fmt: skip
        title = PROCESS_TITLES.get(process, process)
        chart.add_bar(
            x=labels, y=y, name=title, marker={"color": COLORS[2 * number]},
            hovertemplate=f"%{{x}}, {title}: %{{y:.2f}} %<extra></extra>", **more,
        )  # fmt: skip
    limit, note = (1.0, "1 %") if what == "time" else (100 * TAU_OVER_K, "paper: below 60 %")
    chart.add_hline(
        y=limit,
        line={"color": SOFT, "width": 1.3, "dash": "dash"},
        annotation_text=note,
        annotation_position="top right",
    )
    dress(chart, 320)
    chart.update_layout(barmode="group", bargap=0.3)
    title = "time in friction over the rest [%]" if what == "time" else "highest tau/k [%]"
    chart.update_yaxes(title_text=title, rangemode="tozero")
    return chart


def _levels(errors: FormingErrors, lubricant: str, process: str) -> list[RunError]:
    """Return one run of each level of a group, by tool temperature and speed."""
    first: dict[str, RunError] = {}
    for run in errors.runs:
        if (run.lubricant, run.process) == (lubricant, process):
            first.setdefault(run.level, run)
    return sorted(first.values(), key=lambda r: (r.T_tool, r.speed))


def _thin(count: int) -> Sequence[int]:
    return [int(i) for i in np.unique(np.linspace(0, count - 1, min(count, _DRAWN)).round())]
