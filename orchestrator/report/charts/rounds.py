"""The rounds of a refinement: how the error on unseen tests fell with each addition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from friction_models.common.markup import escape

from ..parts.chart import Chart
from ..parts.theme import AFTER, BEFORE, SOFT


def rounds_chart(history: Sequence[Mapping[str, Any]], floor: float | None = None) -> Chart:
    """Return the RMS error at the beginning and after each round of additions as a staircase, with its 95 % intervals.

    `history` is ``error_history_`` of a refined model, or what its card holds of it, at least one round; `floor` is the noise
    floor [mu], which no model explains.

    Examples
    --------
    >>> rounds = [{"added": ["stribeck"], "before": {"rmse": 0.007}, "after": {"rmse": 0.004}}]
    >>> [float(y) for y in rounds_chart(rounds).figure.data[0].y]
    [0.007, 0.004]
    """
    errors = [float(history[0]["before"]["rmse"]), *(float(entry["after"]["rmse"]) for entry in history)]
    names = ["at the start", *("+ " + " + ".join(map(str, entry["added"])) for entry in history)]
    places = list(range(len(errors)))
    intervals = [_interval(history[0], "before"), *(_interval(entry, "after") for entry in history)]
    bars: dict[str, Any] = {}
    if any(found is not None for found in intervals):
        ends = [found or (error, error) for found, error in zip(intervals, errors, strict=True)]
        bars["error_y"] = {
            "type": "data", "symmetric": False, "thickness": 1.4, "width": 5,
            "array": [max(high - error, 0.0) for error, (_, high) in zip(errors, ends, strict=True)],
            "arrayminus": [max(error - low, 0.0) for error, (low, _) in zip(errors, ends, strict=True)],
        }  # fmt: skip
    chart = Chart(legend=False)
    chart.scatter(
        0, places, errors, hover="%{text}: %{y:.5f}<extra></extra>", text=[escape(n) for n in names], mode="lines+markers+text",
        texttemplate="%{y:.4f}", textposition="top right", cliponaxis=False, line={"color": AFTER, "width": 2.6, "shape": "hv"},
        marker={"size": 9, "color": [BEFORE, *[AFTER] * len(history)]}, **bars,
    )  # fmt: skip
    if floor is not None:
        chart.figure.add_hline(y=floor, line={"color": SOFT, "width": 1.5, "dash": "dash"})
        chart.figure.add_annotation(
            x=1, xref="paper", xanchor="right", y=floor, yanchor="top", showarrow=False,
            text=f"noise floor {floor:.4f}",
        )  # fmt: skip
    chart.dress(280, y="RMS error of mu", from_zero=True, margin_t=26)
    chart.figure.update_xaxes(
        zeroline=False,
        tickvals=places,
        ticktext=[_in_lines(n) for n in names],
        range=[-0.3, max(places) + 0.6],
    )
    return chart


def _interval(entry: Mapping[str, Any], when: str) -> Sequence[float] | None:
    """Return the 95 % interval of the RMS error of a round; None where the round does not know it."""
    found: Sequence[float] | None = entry.get("intervals", {}).get(when, {}).get("rmse")
    return found


def _in_lines(name: str) -> str:
    """Return a name in lines that fit below a step also on a phone; plotly leaves out a label that does not fit.

    Examples
    --------
    >>> _in_lines("+ stribeck + empirical:power(v_rel*T)")
    '+ stribeck<br>+ empirical:<br>power(v_rel*T)'
    """
    return escape(name).replace(" + ", "<br>+ ").replace(":", ":<br>")
