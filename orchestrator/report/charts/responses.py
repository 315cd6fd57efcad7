"""Response curves: mu against each load while the others stay at the median of the data, for any page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from friction_models.loads import LOADS, TriboLoads
from friction_models.models.domain import known_domain

from ..parts.markup import escape
from ..parts.theme import LINE, dress

#: How far the curves go beyond the data, as a share of its range, so that the ends of a model show.
REACH = 0.15
CAPTION = (
    "mu against each load, the others at the median of the data, each model limited to its trained domain as its FMU is by "
    "default. The shaded range is where nine tenths of the data lie."
)


def response_chart(data: TriboLoads, curves: Sequence[tuple[str, Mapping[str, Any], Any]]) -> Any:
    """Return the chart, one panel a load that was measured.

    Parameters
    ----------
    data : TriboLoads
        It decides the median and the range of each load.
    curves : sequence of (str, mapping, model)
        Label, look of the line and model; the model has ``predict(array[n, 5])``.
    """
    from plotly.subplots import make_subplots

    measured = [q for q in LOADS if q.name not in data.absent]
    chart = make_subplots(rows=1, cols=len(measured), shared_yaxes=True, horizontal_spacing=0.022)
    middle = np.median(data.as_array(), axis=0)
    for column, quantity in enumerate(measured, 1):
        values = getattr(data, quantity.name)
        low, high = np.quantile(values, [0.05, 0.95]).tolist()
        ends = [float(values.min()), float(values.max())]
        beyond = REACH * (ends[1] - ends[0])
        grid = np.linspace(max(quantity.lower, ends[0] - beyond), min(quantity.upper, ends[1] + beyond), 61)
        points = np.tile(middle, (len(grid), 1))
        points[:, LOADS.index(quantity)] = grid
        for label, look, model in curves:
            domain = known_domain(model)
            chart.add_scatter(
                x=grid, y=model.predict(points if domain is None else domain.clamp(points)), mode="lines",
                name=escape(label), legendgroup=escape(label), showlegend=column == 1, line=dict(look), row=1, col=column,
                hovertemplate=f"{quantity.name} %{{x:.4g}}<br>mu %{{y:.4f}}<extra>%{{fullData.name}}</extra>",
            )  # fmt: skip
        # After the curves: plotly leaves out panels that are still empty.
        chart.add_vrect(
            x0=low, x1=high, fillcolor=LINE, opacity=0.6, layer="below", line_width=0, row=1, col=column
        )
        unit = f" [{quantity.unit}]" if quantity.unit != "1" else ""
        chart.update_xaxes(title_text=f"{quantity.name}{unit}", row=1, col=column)
    dress(chart, 340)
    chart.update_yaxes(title_text="mu", row=1, col=1)
    return chart
