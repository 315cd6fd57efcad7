"""Charts of the reports as the pages take them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from ...report.reading import ReadFigure

if TYPE_CHECKING:
    from ...report.parts.chart import Chart


def as_read(chart: Chart, caption: str, description: str) -> ReadFigure:
    """Return a chart as one that was read from a report; arrays become typed ones, as in a report."""
    content = json.loads(chart.figure.to_json())
    return ReadFigure(content["data"], content["layout"], caption, description)


def with_fixed_margins(chart: Chart, left: int = 76, right: int = 14) -> Chart:
    """Return a chart whose margins are given: to find them itself, plotly would draw all points a second time."""
    chart.figure.update_layout(margin={"l": left, "r": right, "autoexpand": False})
    chart.figure.update_xaxes(automargin=False)
    chart.figure.update_yaxes(automargin=False)
    return chart
