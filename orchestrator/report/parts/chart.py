"""A chart in the one look of all pages: panels, curves, bands, axes, one legend."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from friction_models.common.markup import escape
from friction_models.loads import FloatArray

from .theme import AXIS, INK, LINE, SOFT

if TYPE_CHECKING:
    import pandas as pd
    from plotly.graph_objects.layout import Template

Values: TypeAlias = "Sequence[object] | np.ndarray | pd.Series[Any]"
FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif'
_AXIS = {
    "gridcolor": LINE,
    "zerolinecolor": AXIS,
    "zerolinewidth": 1,
    "linecolor": AXIS,
    "ticks": "outside",
    "tickcolor": AXIS,
    "ticklen": 4,
    "title": {"standoff": 8, "font": {"size": 13}},
    "automargin": True,
}
#: What all charts have in common. A template, because plotly takes long to look at every property of every axis.
_LOOK = {
    "font": {"family": FONT, "size": 13, "color": INK},
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "rgba(0,0,0,0)",
    "hoverlabel": {"font": {"family": FONT, "size": 12}},
    "legend": {
        "orientation": "h",
        "x": 0,
        "y": 1.0,
        "yref": "container",
        "yanchor": "top",
        "font": {"size": 13},
    },
    "xaxis": _AXIS | {"showgrid": False, "showline": True},
    "yaxis": _AXIS | {"showgrid": True, "showline": False},
}


@cache
def _template() -> Template:
    from plotly.graph_objects import layout

    return layout.Template(layout=_LOOK)


class Chart:
    """A plotly figure of panels; curves of one name share their entry in the legend, which is above the panels.

    A method's `at` counts the panels row by row from 0; `titles` are their headings in this order. `grid` are distances and
    shared axes as `plotly.subplots.make_subplots` has them.

    Examples
    --------
    >>> chart = Chart(columns=2, titles=["rod", "cup"])
    >>> for panel in (0, 1):
    ...     chart.scatter(panel, [0, 1], [0.0, 2.0], "press", "%{y} kN")
    >>> html = chart.dress(300, x="stroke [mm]", y="force [kN]").html("force")
    >>> [trace.showlegend for trace in chart.figure.data], 'id="chart-force"' in html
    ([True, False], True)
    """

    def __init__(
        self, columns: int = 1, rows: int = 1, legend: bool = True, titles: Sequence[str] = (), **grid: Any
    ) -> None:
        from plotly.graph_objects import Figure
        from plotly.subplots import make_subplots

        self.columns, self.rows, self.legend = columns, rows, legend
        self.single = rows == columns == 1 and not grid and not titles
        self.figure = (
            Figure()
            if self.single
            else make_subplots(rows, columns, subplot_titles=list(titles) or None, **grid)
        )
        self._named: set[str] = set()

    @classmethod
    def of_panels(cls, count: int, columns: int = 3, gap: float = 0.16, **more: Any) -> Chart:
        """Return a chart of `count` panels, at most so many in a row; `gap` is shared among the rows."""
        rows = -(-count // columns)
        return cls(min(columns, count), rows, vertical_spacing=gap / rows, **more)

    def place(self, at: int) -> dict[str, int]:
        """Return row and column of a panel as plotly counts them; nothing where there is only one."""
        return {} if self.single else {"row": at // self.columns + 1, "col": at % self.columns + 1}

    def scatter(
        self, at: int, x: Values, y: Values, name: str = "", hover: str = "", group: str = "", **look: Any
    ) -> None:
        """Draw a curve or dots; without `name` not in the legend, without `hover` silent under the pointer.

        `group`: what else the entry of the legend switches on and off; `look` as in `plotly.graph_objects.Scatter`.
        """
        silent = {"hovertemplate": hover} if hover else {"hoverinfo": "skip"}
        self.figure.add_scatter(x=x, y=y, **silent, **self._entry(name, group), **look, **self.place(at))

    def band(
        self,
        at: int,
        x: FloatArray,
        low: FloatArray,
        high: FloatArray,
        color: str,
        name: str = "",
        group: str = "",
    ) -> None:
        """Fill what lies between two curves."""
        self.scatter(
            at, np.concatenate([x, x[::-1]]), np.concatenate([high, low[::-1]]), name, group=group,
            fill="toself", fillcolor=color, line={"width": 0}, mode="lines",
        )  # fmt: skip

    def bars(self, at: int, x: Values, y: Values, name: str = "", hover: str = "", **look: Any) -> None:
        """Draw bars; `look` as in `plotly.graph_objects.Bar`."""
        self.figure.add_bar(x=x, y=y, hovertemplate=hover, **self._entry(name, ""), **look, **self.place(at))

    def _entry(self, name: str, group: str) -> dict[str, str | bool]:
        entry: dict[str, str | bool] = {"name": name} if name else {}
        if self.legend and not self.single:
            key = group or name
            entry |= {"legendgroup": key} if key else {}
            entry["showlegend"] = bool(name) and key not in self._named
            self._named |= {key} if name else set()
        elif self.legend and not name:
            entry["showlegend"] = False
        return entry

    def axes(self, at: int, x: str = "", y: str = "", **both: Any) -> None:
        """Name the axes of one panel; `both`: properties of either."""
        if x or both:
            self.figure.update_xaxes(**({"title_text": x} if x else {}), **both, **self.place(at))
        if y or both:
            self.figure.update_yaxes(**({"title_text": y} if y else {}), **both, **self.place(at))

    def dress(
        self,
        height: int,
        x: str | Sequence[str] = "",
        y: str | Sequence[str] = "",
        from_zero: bool = False,
        **layout: Any,
    ) -> Chart:
        """Give the chart the common look and return it; `height` in pixels, `layout` as in `plotly.graph_objects.Layout`.

        `x` is written below the lowest panel of each column, `y` beside the first panel of each row: one text for all, or one
        each. With `from_zero` vertical axes begin at zero.
        """
        below = [x] * self.columns if isinstance(x, str) else x
        for column, text in enumerate(below):
            self.axes((self.rows - 1) * self.columns + column, x=text)
        self.figure.update_layout(
            template=_template(),
            height=height,
            margin={"l": 62, "r": 14, "t": 48 if self.legend else 30, "b": 50},
            showlegend=self.legend,
        )
        for note in self.figure.layout.annotations:
            note.font.size = 13
            note.font.color = SOFT
        self.figure.update_layout(**layout)
        for row, text in enumerate([y] * self.rows if isinstance(y, str) else y):
            self.axes(row * self.columns, y=text)
        if from_zero:
            self.figure.update_yaxes(rangemode="tozero")
        return self

    def html(self, name: str) -> str:
        """Return the chart as HTML, without plotly's library, which a page holds once."""
        found: str = self.figure.to_html(
            full_html=False,
            include_plotlyjs=False,
            div_id=f"chart-{name}",
            config={"displayModeBar": False, "responsive": True},
        )
        return found


def limits(values: Iterable[FloatArray], flat: float = 0.0) -> list[float]:
    """Return limits of an axis that show all but the outermost thousandth of each, with a margin; `flat`: that of equal values."""
    known = [v for v in values if np.isfinite(v).any()]
    ends = np.array([np.nanquantile(v, [0.001, 0.999]) for v in known]) if known else np.array([[0.0, 1.0]])
    low, top = float(ends[:, 0].min()), float(ends[:, 1].max())
    margin = 0.05 * (top - low) or flat or 0.05 * abs(top) or 0.05
    return [low - margin, top + margin]


def figure(name: str, chart: Chart, caption: str, description: str) -> str:
    """Return the HTML of a chart with its caption (HTML); `description` is what a screen reader says.

    Examples
    --------
    >>> chart = Chart()
    >>> chart.scatter(0, [0, 1], [0.1, 0.1], hover="%{y}")
    >>> html = figure("mu", chart, "mu over distance", "A level line.")
    >>> 'aria-label="A level line."' in html, "<figcaption>mu over distance</figcaption>" in html
    (True, True)
    """
    return (
        f'<figure><div class="plot" role="img" aria-label="{escape(description)}">{chart.html(name)}</div>'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def figure_again(
    name: str, data: Sequence[Any], layout: dict[str, Any], caption: str, description: str
) -> str:
    """Return the HTML of a chart that was read from a page (`orchestrator.report.reading`), for another page.

    What plotly does not know is left out; its texts go through plotly, which shows no markup but its own few tags.

    Examples
    --------
    >>> chart = Chart()
    >>> chart.scatter(0, [0, 1], [0.1, 0.1], hover="%{y}")
    >>> drawn = chart.figure.to_plotly_json()
    >>> 'id="chart-again"' in figure_again("again", drawn["data"], drawn["layout"], "mu", "A level line.")
    True
    """
    from plotly.graph_objects import Figure

    chart = Chart()
    chart.figure = Figure({"data": list(data), "layout": layout}, skip_invalid=True)
    return figure(name, chart, caption, description)
