"""Charts of an attribution: deviation of the force along the stroke, and fingerprints of its causes."""

from __future__ import annotations

import numpy as np

from ...attribution.result import Attribution
from ..parts.chart import Chart
from ..parts.theme import AFTER, BEFORE, CONSTANT, OTHER, PRESS_BAND

_COLORS = (AFTER, BEFORE, OTHER, "#2f6da8", "#8a6d1d", CONSTANT)
#: Fingerprints that are drawn.
_DRAWN = 6


def _panels(found: Attribution) -> Chart:
    titles = [str(c["level"]) for c in found.curves]
    rows = -(-len(titles) // 3)
    gap = 0.34 * rows / (rows + 1)
    return Chart.of_panels(len(titles), gap=gap, titles=titles, horizontal_spacing=0.07)


def _dressed(chart: Chart, count: int, y: str) -> Chart:
    for panel in range(count):
        chart.axes(panel, x="stroke [mm]")
    return chart.dress(110 + 260 * chart.rows, y=y, margin_t=74)


def deviation_chart(found: Attribution) -> Chart:
    """Return measured minus simulated force over stroke, before and with what is named, a panel a level."""
    chart = _panels(found)
    for panel, curve in enumerate(found.curves):
        stroke, wide = curve["stroke"], 2.0 * curve["scatter"]
        chart.band(panel, stroke, -wide, wide, PRESS_BAND, "scatter to expect", "scatter")
        lines = {"before": (curve["measured"] - curve["simulated"], BEFORE)}
        if found.confusion_set:
            lines["after"] = curve["after"], AFTER
        for name, (values, color) in lines.items():
            said = f"%{{x:.2f}} mm<br>%{{y:+.2f}} kN<extra>{name}</extra>"
            chart.scatter(
                panel, stroke, values, name, said, mode="lines", line={"color": color, "width": 2.2}
            )
    return _dressed(chart, len(found.curves), "measured &#8722; simulated [kN]")


def fingerprint_chart(found: Attribution) -> Chart:
    """Return how each of the best causes changes the force, scaled to the same largest change, a panel a level."""
    chart = _panels(found)
    names = [f.cause for f in found.ranking[:_DRAWN]]
    keys = [k for n in names for k in found.curves[0]["fingerprints"] if k.partition(".")[0] == n]
    for key, color in zip(keys, _COLORS, strict=False):
        largest = max(float(np.abs(c["fingerprints"][key]).max()) for c in found.curves) or 1.0
        for panel, curve in enumerate(found.curves):
            values = curve["fingerprints"][key] / largest
            said = f"%{{x:.2f}} mm<br>%{{y:+.2f}}<extra>{key}</extra>"
            chart.scatter(
                panel, curve["stroke"], values, key, said, mode="lines", line={"color": color, "width": 2}
            )
    return _dressed(chart, len(found.curves), "change (largest = 1)")
