"""Charts of a diagnosis: budget, ranking, residual over two loads, the share of mu of each effect, empirical terms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from friction_models.common.markup import escape
from friction_models.discovery import Diagnosis
from friction_models.discovery.answer.figures_data import LoadMap, effect_curve
from friction_models.discovery.formulas.pictures import TermCurve
from friction_models.loads import FloatArray
from friction_models.loads.contract import with_unit

from ..parts.chart import Chart
from ..parts.theme import AFTER, BEFORE, COLORS, CONSTANT, INK, SIGNED, SOFT

#: From too much friction in the model (blue) over nothing to too little (red); safe for colour-blind readers.
_MOST_DOTS = 1500


def predicted_mu(found: Diagnosis) -> dict[str, FloatArray]:
    """Return mu of the model at the averages of the tests, ``before`` and, where an effect is named, ``after``."""
    shown = ["before", "after"] if found.effects else ["before"]
    return {part: (found.averages["mu"] - found.averages[part]).to_numpy() for part in shown}


def budget_chart(floor: float, explained: float, missing: float, named: bool) -> Chart:
    """Return the error budget before and after as bars of the mean square error, relative to that before."""
    total = floor**2 + explained**2 + missing**2 or 1.0
    rows = ["after", "before"] if named else ["now"]
    parts = [
        ("noise floor (cannot be removed)", CONSTANT, floor, floor),
        ("explained by what is named", AFTER, explained, 0.0),
        ("still missing", BEFORE, missing, missing),
    ]
    chart = Chart()
    for label, color, before, after in parts if named else [parts[0], parts[2]]:
        shares = [100 * value**2 / total for value in (after, before)[-len(rows) :]]
        chart.bars(
            0, shares, rows, label, f"{label} %{{x:.1f}} %<extra>%{{y}}</extra>", orientation="h", marker={"color": color},
            text=[f"{v:.0f} %" if v >= 5 else "" for v in shares], textposition="inside", insidetextanchor="middle",
            textfont={"color": INK if color == CONSTANT else "white", "size": 14},
        )  # fmt: skip
    chart.dress(
        118 + 46 * len(rows), x="share of the mean square error before",
        # Room on the right for half of "100 %": plotly leaves out a label that would be cut.
        barmode="stack", bargap=0.22, margin={"l": 58, "t": 44, "b": 40, "r": 34}, legend_traceorder="normal",
    )  # fmt: skip
    chart.figure.update_xaxes(range=[0, 100], ticksuffix=" %")
    chart.figure.update_yaxes(ticks="", showgrid=False, tickfont={"color": SOFT, "size": 13})
    return chart


#: The gain that chance may give is drawn within this factor of the largest gain.
REACH = 3.0


def ranking_chart(gains: Sequence[tuple[str, float, str]], threshold: float | None = None) -> Chart:
    """Return the gain of each effect (name, gain, colour) and the gain that chance alone may give (dashed line)."""
    shown = gains[:12][::-1]
    chart = Chart(legend=False)
    chart.bars(
        0, [max(gain, 0.0) for _, gain, _ in shown], [name for name, _, _ in shown],
        hover="%{y}: gain %{x:.1f}<extra></extra>", orientation="h", marker={"color": [c for _, _, c in shown]},
    )  # fmt: skip
    # a line far to the right of all bars would leave no room for them
    if threshold is not None and 0.0 < threshold <= REACH * max((gain for _, gain, _ in shown), default=0.0):
        chart.figure.add_vline(x=threshold, line={"color": SOFT, "width": 1.5, "dash": "dash"})
        chart.figure.add_annotation(
            x=threshold, y=0, yref="paper", yanchor="bottom", xanchor="left", showarrow=False,
            text=" largest by chance",
        )  # fmt: skip
    chart.dress(70 + 27 * max(len(shown), 2), x="gain", bargap=0.32, margin_t=10)
    chart.figure.update_xaxes(showgrid=True)
    chart.figure.update_yaxes(showgrid=False, ticks="", tickfont={"color": SOFT, "size": 13})
    return chart


def map_chart(found: LoadMap, parts: Sequence[str]) -> Chart:
    """Return the mean residual over two loads, one panel a part (``before``, ``after``); empty cells stay blank."""
    chart = Chart(len(parts), legend=False, titles=parts, shared_yaxes=True, horizontal_spacing=0.03)
    largest = float(np.nanmax(np.abs(found.mean[parts[0]]))) or 1.0
    x, y = np.meshgrid(found.x_measured, found.y_measured)
    cells = np.dstack([found.tests, x, y])
    for panel, part in enumerate(parts):
        chart.figure.add_heatmap(
            x=found.x_edges, y=found.y_edges, z=found.mean[part], customdata=cells,
            colorscale=SIGNED, zmin=-largest, zmax=largest, zmid=0.0, hoverongaps=False, xgap=1, ygap=1,
            colorbar={"title": {"text": "measured &#8722; model (mu)", "side": "right"}, "thickness": 12, "len": 1.0,
                      "outlinewidth": 0, "tickformat": "+.3f"},
            showscale=panel == len(parts) - 1, **chart.place(panel),
            hovertemplate=f"{found.x} %{{customdata[1]:.4g}}, {found.y} %{{customdata[2]:.4g}}<br>%{{z:+.4f}} from %{{customdata[0]}} tests<extra></extra>",
        )  # fmt: skip
    chart.dress(380, x=with_unit(found.x), y=with_unit(found.y), margin_t=44)
    chart.figure.update_yaxes(showgrid=False, zeroline=False)
    chart.figure.update_xaxes(zeroline=False)
    return chart


def effect_chart(found: Diagnosis) -> Chart | None:
    """Return the share of mu of each effect over each of its drivers: dots in the tests, a line by its formula."""
    averages = found.averages
    panels = [
        (name, d) for name, effect in found.named.items() for d in effect.driver if d in averages.columns
    ]
    if not panels:
        return None
    chart = Chart(len(panels), horizontal_spacing=0.3 / (len(panels) + 2))
    step = max(1, len(averages) // _MOST_DOTS)
    for panel, (name, driver) in enumerate(panels):
        values = {k: float(v["value"]) for k, v in found.parameters[name]["values"].items()}
        said = f"{driver} %{{x:.4g}}<br>%{{y:+.4f}}<extra>{escape(name)}</extra>"
        chart.scatter(
            panel, averages[driver][::step], averages[f"effect {name}"][::step], "in the tests", said, "dots",
            mode="markers", marker={"size": 4, "color": CONSTANT, "opacity": 0.5},
        )  # fmt: skip
        curve = effect_curve(found.named[name], values, averages, driver)
        if curve is not None:
            chart.scatter(
                panel, *curve, "by its formula, other loads at their median", said, "line",
                mode="lines", line={"color": AFTER, "width": 2.6},
            )  # fmt: skip
        chart.axes(panel, with_unit(driver), f"{escape(name)}: share of mu")
    return chart.dress(330)


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
