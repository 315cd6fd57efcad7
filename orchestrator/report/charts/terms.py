"""What empirical terms would add to mu, with intervals."""

from __future__ import annotations

from collections.abc import Sequence

from friction_models.common.markup import escape
from friction_models.discovery.formulas.pictures import TermCurve
from friction_models.loads.contract import with_unit

from ..parts.chart import Chart
from ..parts.theme import COLORS


def term_chart(curves: Sequence[TermCurve]) -> Chart:
    """Return a chart with a panel for each term; a term of two loads has a curve for each level of the second one."""
    names = list(dict.fromkeys(c.term for c in curves))
    own = [[c for c in curves if c.term == name] for name in names]
    titles = [name.removeprefix("empirical:") for name in names]
    chart = Chart(len(names), titles=titles, horizontal_spacing=0.08)
    for panel, drawn in enumerate(own):
        for color, curve in zip(COLORS, drawn, strict=False):
            shade = f"rgba({int(color[1:3], 16)},{int(color[3:5], 16)},{int(color[5:7], 16)},0.18)"
            name = escape(curve.at or "term")
            chart.band(panel, curve.x, curve.low, curve.high, shade, group=name)
            said = f"{curve.load} %{{x:.4g}}<br>adds %{{y:+.4f}}<extra>{name}</extra>"
            chart.scatter(panel, curve.x, curve.y, name, said, mode="lines", line={"color": color})
    return chart.dress(300, x=[with_unit(c[0].load) for c in own], y="added to mu")
