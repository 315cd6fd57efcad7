"""Charts of a coverage map: what lies outside the tested loads, load by load and in pairs."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from friction_models.loads import LOAD_NAMES
from friction_models.loads.contract import with_unit

from ...coverage.tested_loads import SLOW, Coverage, Region, cell_map, natural
from ..parts.chart import Chart
from ..parts.theme import AFTER, BEFORE

#: Friction work rises from paper to this colour.
_SCALE = [
    [0.0, "rgba(200, 100, 31, 0.0)"],
    [0.001, "rgba(200, 100, 31, 0.12)"],
    [1.0, "rgba(200, 100, 31, 1.0)"],
]


def shares_chart(coverage: Coverage) -> Chart:
    """Return bars: the share of the process outside the tested range of each load."""
    names = [s.names[0] for s in coverage.loads]
    chart = Chart()
    for name, shares, color in (
        ("contact area", [s.area for s in coverage.loads], BEFORE),
        ("friction work", [s.work for s in coverage.loads], AFTER),
    ):
        said = "%{x}: %{y:.1f} %<extra></extra>"
        chart.bars(0, names, [100 * share for share in shares], f"{name} outside", said, marker_color=color)
    return chart.dress(300, y="outside [%]", from_zero=True)


def pairs_chart(coverage: Coverage) -> Chart:
    """Return the friction work of the process over each pair of loads, and the outline of the tested points."""
    names = [s.names[0] for s in coverage.loads]
    pairs = list(combinations(names, 2))
    rows = -(-len(pairs) // 3)
    chart = Chart.of_panels(len(pairs), gap=0.4 * rows / (rows + 1), horizontal_spacing=0.09)
    tables = {n: natural(n, coverage.tested[:, LOAD_NAMES.index(n)]) for n in names}
    for panel, (first, second) in enumerate(pairs):
        x, y, work, area = cell_map(coverage, first, second)
        region = Region.of((first, second), np.column_stack([tables[first], tables[second]]))
        shown = np.where(work + area > 0.0, 100 * work, np.nan)
        chart.figure.add_heatmap(
            x=x, y=y, z=shown, colorscale=_SCALE, zmin=0, zmax=float(np.nanmax(shown)) or 1.0, showscale=False,
            hovertemplate="%{z:.2f} % of the friction work<extra></extra>", **chart.place(panel),
        )  # fmt: skip
        if region.outline is not None:
            closed = np.vstack([region.outline, region.outline[:1]])
            line = {"color": AFTER, "width": 2}
            chart.scatter(panel, closed[:, 0], closed[:, 1], "tested", mode="lines", line=line)
        chart.axes(panel, with_unit(first), with_unit(second))
        for update, name, edges in (
            (chart.figure.update_xaxes, first, x),
            (chart.figure.update_yaxes, second, y),
        ):
            places, texts = _ticks(name, float(edges[0]), float(edges[-1]))
            update(tickvals=places, ticktext=texts, **chart.place(panel))
    chart.dress(270 * rows + 60)
    chart.figure.update_xaxes(zeroline=False)
    chart.figure.update_yaxes(zeroline=False)
    return chart


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
