"""Response curves: mu against each load, the others at the centre of the domain; with memory, after sliding there."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ..loads import LOAD_NAMES, LOADS, QUANTITIES, FloatArray

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from .law import FrictionLaw

POINTS = 121
#: Steps on the way of a model that remembers: states change smoothly, and over the steps the loads are those of the end.
STEPS = 40
_SD = LOAD_NAMES.index("sd")
#: Random points of the other loads, for the band.
SCATTER = 48
#: Ranges to draw for a law that was never trained (the reference plan of the sliding compression test).
REFERENCE = {"v_rel": (0, 500), "T": (20, 400), "sigma_n": (300, 2750), "sd": (0, 60), "psi": (1, 20)}
MARGIN = 0.12
LINE, BAND, OUTSIDE = "#0b5a8a", "rgba(11, 90, 138, 0.14)", "rgba(120, 120, 120, 0.10)"


def response_curves(model: FrictionLaw) -> go.Figure:
    """Return a plotly figure with one panel a load.

    The line holds the other loads at the centre of the trained domain; the band spans the 5th to the
    95th percentile of mu when they vary over the domain; dotted lines are the bounds of the prediction interval,
    where the model has one. Grey marks what lies outside the domain.
    """
    from plotly.subplots import make_subplots

    low, high = drawn_range(model)
    centre = 0.5 * (low + high)
    absent = model.domain.absent
    titles = [f"{q.name} [{q.unit}]" + (" (not measured)" if q.name in absent else "") for q in LOADS]
    figure = make_subplots(rows=2, cols=3, subplot_titles=titles, shared_yaxes="all", vertical_spacing=0.14)
    # One fixed sample keeps the figure the same at every call.
    others = low + (high - low) * np.random.default_rng(0).random((SCATTER, len(LOADS)))
    for j, quantity in enumerate(LOADS):
        row, col = divmod(j, 3)
        margin = MARGIN * (high[j] - low[j]) if model.domain.upper[j] < quantity.upper else 0.0
        x = np.linspace(max(low[j] - margin, quantity.lower), min(high[j] + margin, quantity.upper), POINTS)
        place = {"row": row + 1, "col": col + 1}
        draw = partial(figure.add_scatter, x=x, mode="lines", **place)
        bottom, top = band(model, others, j, x)
        draw(y=bottom, line_width=0, hoverinfo="skip", showlegend=False)
        draw(
            y=top,
            line_width=0,
            fill="tonexty",
            fillcolor=BAND,
            hoverinfo="skip",
            name="other loads anywhere in the domain (5 to 95 %)",
            showlegend=j == 0,
        )
        if model.interval is not None:
            for side, bound in zip(("lower", "upper"), model.predict_interval(along(centre, j, x))):
                draw(
                    y=bound,
                    line={"color": LINE, "width": 1.2, "dash": "dot"},
                    name=f"{100.0 * model.interval.level:g} % of the points of new tests, at the centre",
                    legendgroup="interval",
                    showlegend=j == 0 and side == "lower",
                    hovertemplate=f"{side} bound %{{y:.4f}}<extra></extra>",
                )
        draw(
            y=after_sliding(model, along(centre, j, x)),
            line={"color": LINE, "width": 2.5},
            name="other loads at the centre of the domain",
            showlegend=j == 0,
            hovertemplate=f"{quantity.name} = %{{x:.4g}} {quantity.unit}<br>mu = %{{y:.4f}}<extra></extra>",
        )
        for a, b in ((x[0], low[j]), (high[j], x[-1])):
            if b > a:
                figure.add_vrect(x0=a, x1=b, fillcolor=OUTSIDE, line_width=0, layer="below", **place)
    figure.update_yaxes(rangemode="tozero", title_text="mu", col=1)
    figure.update_yaxes(rangemode="tozero")
    shown = model.formula_text()
    if remembers(model):
        shown += f"; after sliding {centre[_SD]:.3g} {QUANTITIES['sd'].unit} from fresh contact, over sd after that distance"
    figure.update_layout(
        title={"text": f"{model.name}<br><sub>{shown if len(shown) < 150 else shown[:147] + '...'}</sub>"},
        template="plotly_white",
        height=620,
        legend={"x": 0.70, "y": 0.30, "title": {"text": "Grey: outside the trained domain"}},
        margin={"t": 110, "b": 40},
    )
    return figure


def drawn_range(model: FrictionLaw) -> tuple[FloatArray, FloatArray]:
    """Return the limits to draw: the domain, or the reference plan where it is as wide as physics allows."""
    limits = [
        REFERENCE[q.name] if (low, high) == (q.lower, q.upper) else (low, high)
        for q, low, high in zip(LOADS, model.domain.lower, model.domain.upper)
    ]
    low = np.array([a for a, _ in limits], dtype=np.float64)
    high = np.array([b for _, b in limits], dtype=np.float64)
    # A load that never varied still gets an axis.
    return low, np.where(high > low, high, low + 0.1 * np.maximum(np.abs(low), 1.0))


def along(point: FloatArray, j: int, values: FloatArray) -> FloatArray:
    """Return loads of shape (n, 5): `point` everywhere, load `j` taking `values`."""
    loads = np.tile(point, (len(values), 1))
    loads[:, j] = values
    return loads


def band(model: FrictionLaw, others: FloatArray, j: int, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the 5th and 95th percentile of mu over `others` at each value of load `j`."""
    loads = np.repeat(others, len(values), axis=0)
    loads[:, j] = np.tile(values, len(others))
    curves = after_sliding(model, loads).reshape(len(others), len(values))
    low, high = np.percentile(curves, [5, 95], axis=0)
    return low, high


def remembers(model: Any) -> bool:
    """Whether a model has states that change while it slides."""
    return bool(getattr(model, "states", ())) and hasattr(model, "predict_frame")


def after_sliding(model: Any, loads: FloatArray) -> FloatArray:
    """Return mu, shape (n,), at loads of shape (n, 5), each reached from fresh contact by sliding its `sd` at its other loads.

    For a model without memory that is ``model.predict(loads)``.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> after_sliding(ConstantFriction(0.08), np.array([[50.0, 20.0, 500.0, 30.0, 1.0]])).tolist()
    [0.08]
    """
    if not remembers(model):
        return np.asarray(model.predict(loads), dtype=float)
    way = np.repeat(loads, STEPS + 1, axis=0)
    way[:, _SD] *= np.tile(np.linspace(0.0, 1.0, STEPS + 1), len(loads))
    frame = pd.DataFrame(way, columns=list(LOAD_NAMES))
    # Each point is the last one of a test of its own.
    frame["test_id"] = np.repeat([f"p{k}" for k in range(len(loads))], STEPS + 1)
    return np.asarray(model.predict_frame(frame), dtype=float)[STEPS :: STEPS + 1]
