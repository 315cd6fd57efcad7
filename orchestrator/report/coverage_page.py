"""The report of a coverage map: what was tested, what the process asks for, which tests would cover it."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from friction_models.loads.contract import with_unit

from ..coverage.tested_loads import SLOW, Coverage, Region, cell_map, natural
from .parts.markup import bullets, escape, paragraph, table
from .parts.page import Page, figure
from .parts.theme import AFTER, BEFORE, dress

#: Friction work rises from paper to this colour.
_SCALE = [
    [0.0, "rgba(200, 100, 31, 0.0)"],
    [0.001, "rgba(200, 100, 31, 0.12)"],
    [1.0, "rgba(200, 100, 31, 1.0)"],
]


def coverage_page(coverage: Coverage, label: str) -> str:
    """Return the HTML of a coverage map; `label` names the process."""
    page = Page(
        title=f"Coverage of {label}",
        kicker="tribofmu coverage",
        lead=escape(coverage.sentence),
        synthetic=coverage.synthetic,
    )
    rows = [
        (
            with_unit(s.names[0]),
            "{:.4g} to {:.4g}".format(*s.tested[0]),
            "{:.4g} to {:.4g}".format(*s.asked[0]),
            f"{100 * s.area:.1f} %",
            f"{100 * s.work:.1f} %",
        )
        for s in coverage.loads
    ]
    page.add(
        "loads",
        "Load by load",
        figure(
            "shares",
            _shares(coverage),
            "Share of the process outside the tested loads.",
            "Bars for each load.",
        ),
        table(["load", "tested", "process", "area outside", "work outside"], rows, numeric=(1, 2, 3, 4)),
    )
    names = [s.names[0] for s in coverage.loads]
    if len(names) > 1:
        page.add(
            "pairs",
            "Pairs of loads",
            figure(
                "pairs",
                _maps(coverage, names),
                "Where the friction work of the process is done (colour), and the hull of all tested points (line): "
                "what lies outside the line, the model extrapolates.",
                "Maps of friction work over each pair of loads with the outline of the tested region.",
            ),
        )
    if coverage.proposals:
        keys = ("sigma_set", "psi_set", "v_set", "T_tool", "sd_set")
        page.add(
            "tests",
            "Tests that would cover more",
            table(
                ["pressure [MPa]", "expansion", "speed [mm/s]", "tool [degC]", "distance [mm]", "adds"],
                [
                    (
                        *(f"{p['setpoints'][k]:g}" for k in keys),
                        ", ".join(
                            f"{' with '.join(c['loads'])} {100 * c['share']:.1f} %" for c in p["covers"]
                        ),
                    )
                    for p in coverage.proposals
                ],
                numeric=range(1, 5),
                caption="What each test adds: mean of its shares of contact area and friction work.",
            ),
        )
    if coverage.beyond_rig:
        page.add("beyond", "Beyond every test of the rig", bullets(coverage.beyond_rig))
    page.add("notes", "Notes", paragraph(f"Process: {coverage.history.source}"), bullets(coverage.notes))
    return page.render()


def _shares(coverage: Coverage) -> Any:
    from plotly import graph_objects

    names = [s.names[0] for s in coverage.loads]
    chart = graph_objects.Figure()
    for part, color in (("area", BEFORE), ("work", AFTER)):
        chart.add_bar(
            x=names,
            y=[100 * getattr(s, part) for s in coverage.loads],
            name=f"{'contact area' if part == 'area' else 'friction work'} outside",
            marker_color=color,
            hovertemplate="%{x}: %{y:.1f} %<extra></extra>",
        )
    dress(chart, 300)
    chart.update_yaxes(title_text="outside [%]", rangemode="tozero")
    return chart


def _maps(coverage: Coverage, names: list[str]) -> Any:
    from plotly.subplots import make_subplots

    pairs = list(combinations(names, 2))
    columns = min(3, len(pairs))
    rows = -(-len(pairs) // columns)
    chart = make_subplots(rows=rows, cols=columns, horizontal_spacing=0.09, vertical_spacing=0.4 / (rows + 1))
    tables = {n: natural(n, coverage.tested[:, k]) for n, k in _places(names)}
    for number, (first, second) in enumerate(pairs):
        row, column = number // columns + 1, number % columns + 1
        x, y, work, area = cell_map(coverage, first, second)
        region = Region.of((first, second), np.column_stack([tables[first], tables[second]]))
        shown = np.where(work + area > 0.0, 100 * work, np.nan)
        chart.add_heatmap(
            x=x, y=y, z=shown, colorscale=_SCALE, zmin=0, zmax=float(np.nanmax(shown)) or 1.0, showscale=False,
            hovertemplate="%{z:.2f} % of the friction work<extra></extra>", row=row, col=column,
        )  # fmt: skip
        if region.outline is not None:
            closed = np.vstack([region.outline, region.outline[:1]])
            chart.add_scatter(
                x=closed[:, 0], y=closed[:, 1], mode="lines", line={"color": AFTER, "width": 2},
                name="tested", legendgroup="tested", showlegend=number == 0, hoverinfo="skip", row=row, col=column,
            )  # fmt: skip
        for axis, name, edges in (("x", first, x), ("y", second, y)):
            places, texts = _ticks(name, float(edges[0]), float(edges[-1]))
            update = chart.update_xaxes if axis == "x" else chart.update_yaxes
            update(title_text=with_unit(name), tickvals=places, ticktext=texts, row=row, col=column)
    dress(chart, 270 * rows + 60)
    chart.update_xaxes(zeroline=False)
    chart.update_yaxes(zeroline=False)
    return chart


def _places(names: list[str]) -> list[tuple[str, int]]:
    from friction_models.loads import LOAD_NAMES

    return [(n, LOAD_NAMES.index(n)) for n in names]


def _ticks(name: str, low: float, high: float) -> tuple[list[float], list[str]]:
    """Return round values of a load and where they stand on its natural scale."""
    if name == "v_rel":
        values = [float(v) for v in (0, 1, 5, 20, 100, 500, 2000) if low <= np.log(v + SLOW) <= high]
    elif name == "psi":
        values = [float(v) for v in (0.2, 0.5, 0.7, 1, 1.5, 2, 3, 5, 10, 20, 50) if low <= np.log(v) <= high]
    else:
        step = 10.0 ** np.floor(np.log10(max(high - low, 1e-9)))
        step *= 2.0 if (high - low) / step > 5 else (1.0 if (high - low) / step > 2.5 else 0.5)
        values = list(np.arange(np.ceil(low / step) * step, high + 1e-9, step))
    return [float(natural(name, v)) for v in values], [f"{v:g}" for v in values]
