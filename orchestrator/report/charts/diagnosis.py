"""Charts of a diagnosis: residual over two loads, and the share of mu that each effect named has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from friction_models.discovery import Diagnosis
from friction_models.discovery.figures_data import LoadMap, effect_curve
from friction_models.loads.contract import with_unit

from ..parts.markup import escape
from ..parts.theme import AFTER, CONSTANT, dress

#: From too much friction in the model (blue) over nothing to too little (red); safe for colour-blind readers.
_DIVERGING = [[0.0, "#2f6da8"], [0.25, "#9fc3df"], [0.5, "#f4f5f6"], [0.75, "#eeb48a"], [1.0, "#b4531a"]]
_MOST_DOTS = 1500


def map_chart(found: LoadMap, parts: Sequence[tuple[str, str]]) -> Any:
    """Return the mean residual over two loads, one panel a part (key, heading); empty cells stay blank."""
    from plotly.subplots import make_subplots

    chart = make_subplots(
        rows=1,
        cols=len(parts),
        shared_yaxes=True,
        horizontal_spacing=0.03,
        subplot_titles=[h for _, h in parts],
    )
    largest = float(np.nanmax(np.abs(found.mean[parts[0][0]]))) or 1.0
    for column, (part, _) in enumerate(parts, 1):
        chart.add_heatmap(
            x=found.x_edges, y=found.y_edges, z=found.mean[part], customdata=found.tests,
            colorscale=_DIVERGING, zmin=-largest, zmax=largest, zmid=0.0, hoverongaps=False, xgap=1, ygap=1,
            colorbar={"title": {"text": "measured &#8722; model (mu)", "side": "right"}, "thickness": 12, "len": 1.0,
                      "outlinewidth": 0, "tickformat": "+.3f"},
            showscale=column == len(parts), row=1, col=column,
            hovertemplate=f"{found.x} %{{x:.4g}}, {found.y} %{{y:.4g}}<br>%{{z:+.4f}} from %{{customdata}} tests<extra></extra>",
        )  # fmt: skip
        chart.update_xaxes(title_text=with_unit(found.x), row=1, col=column)
    dress(chart, 380, legend=False)
    chart.update_layout(margin_t=44)
    chart.update_yaxes(showgrid=False, zeroline=False)
    chart.update_xaxes(zeroline=False)
    chart.update_yaxes(title_text=with_unit(found.y), row=1, col=1)
    return chart


def effect_chart(found: Diagnosis) -> Any:
    """Return the share of mu of each effect over each of its drivers: dots in the tests, a line by its formula."""
    from plotly.subplots import make_subplots

    averages, parameters = found.averages, found.parameters
    panels = [
        (name, d) for name, effect in found.named.items() for d in effect.driver if d in averages.columns
    ]
    if not panels:
        return None
    chart = make_subplots(rows=1, cols=len(panels), horizontal_spacing=0.3 / (len(panels) + 2))
    step = max(1, len(averages) // _MOST_DOTS)
    for column, (name, driver) in enumerate(panels, 1):
        values = {k: float(v["value"]) for k, v in parameters[name]["values"].items()}
        label = with_unit(driver)
        chart.add_scatter(
            x=averages[driver][::step], y=averages[f"effect {name}"][::step], mode="markers", name="in the tests",
            marker={"size": 4, "color": CONSTANT, "opacity": 0.5}, legendgroup="dots", showlegend=column == 1,
            row=1, col=column, hovertemplate=f"{driver} %{{x:.4g}}<br>%{{y:+.4f}}<extra>{escape(name)}</extra>",
        )  # fmt: skip
        curve = effect_curve(found.named[name], values, averages, driver)
        if curve is not None:
            chart.add_scatter(
                x=curve[0], y=curve[1], mode="lines", name="by its formula, other loads at their median",
                line={"color": AFTER, "width": 2.6}, legendgroup="line", showlegend=column == 1, row=1, col=column,
                hovertemplate=f"{driver} %{{x:.4g}}<br>%{{y:+.4f}}<extra>{escape(name)}</extra>",
            )  # fmt: skip
        chart.update_xaxes(title_text=label, row=1, col=column)
        chart.update_yaxes(title_text=f"{escape(name)}: share of mu", row=1, col=column)
    return dress(chart, 330)
