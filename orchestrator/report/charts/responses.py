"""Response curves: mu against each load while the others stay at the median of the data, for any page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np

from friction_models.common.markup import escape
from friction_models.loads import LOADS, FloatArray, TriboLoads
from friction_models.loads.contract import QUANTITIES, with_unit
from friction_models.models.domain import known_domain
from friction_models.models.response_curves import after_sliding, remembers

from ..parts.chart import Chart
from ..parts.theme import LINE, Look

#: How far the curves go beyond the data, as a share of its range, so that the ends of a model show.
REACH = 0.15
_CAPTION = (
    "mu against each load, the others at the median of the data, each model limited to its trained domain as its FMU is by "
    "default. The shaded range is where nine tenths of the data lie."
)


def caption(data: TriboLoads, models: Iterable[object]) -> str:
    """Return the sentences below the curves; where a model remembers, they name the distance that it slid before.

    Examples
    --------
    >>> "remembers" in caption(TriboLoads.from_array([[50, 20, 500, 0, 1]]), [])
    False
    """
    if not any(map(remembers, models)):
        return _CAPTION
    slid = f"{float(np.median(data.sd)):.3g} {QUANTITIES['sd'].unit}"
    return (
        f"{_CAPTION} A model that remembers is drawn after it slid {slid} (sd) from fresh contact, the median of the data, at the loads of "
        "the point; over sd after that distance."
    )


class Predicts(Protocol):
    """What a response is drawn of."""

    def predict(self, loads: FloatArray, /) -> FloatArray:
        """Return mu of loads of shape (n, 5)."""


def response_chart(data: TriboLoads, curves: Sequence[tuple[str, Look, Predicts]]) -> Chart:
    """Return a chart with a panel for each load that was measured; `curves`: label, look of the line and model."""
    measured = [q for q in LOADS if q.name not in data.absent]
    chart = Chart(len(measured), shared_yaxes=True, horizontal_spacing=0.022)
    middle = np.median(data.as_array(), axis=0)
    for panel, quantity in enumerate(measured):
        values = getattr(data, quantity.name)
        low, high = np.quantile(values, [0.05, 0.95]).tolist()
        ends = [float(values.min()), float(values.max())]
        beyond = REACH * (ends[1] - ends[0])
        grid = np.linspace(max(quantity.lower, ends[0] - beyond), min(quantity.upper, ends[1] + beyond), 61)
        points = np.tile(middle, (len(grid), 1))
        points[:, LOADS.index(quantity)] = grid
        said = f"{quantity.name} %{{x:.4g}}<br>mu %{{y:.4f}}<extra>%{{fullData.name}}</extra>"
        for label, look, model in curves:
            domain = known_domain(model)
            mu = after_sliding(model, points if domain is None else domain.clamp(points))
            chart.scatter(panel, grid, mu, escape(label), said, mode="lines", line=look)
        # After the curves: plotly leaves out panels that are still empty.
        chart.figure.add_vrect(
            x0=low, x1=high, fillcolor=LINE, opacity=0.6, layer="below", line_width=0, **chart.place(panel)
        )
    return chart.dress(340, x=[with_unit(q.name) for q in measured], y="mu")
