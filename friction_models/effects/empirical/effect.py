"""Empirical terms as effects, ``empirical:bump(T)``: a curve that describes tests and has no law behind it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar

import numpy as np

from ...common.wording import listed
from ...expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ...loads import LOAD_NAMES, FloatArray
from ...loads.contract import QUANTITIES
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter, Spans
from .terms import Term, parse_term

PREFIX = "empirical:"
#: Share of the tested range beyond it within which a term fades to nothing.
FADE = 0.1
#: Places along each load at which the straight part of a term is found.
PLACES = {1: 33, 2: 12}
#: Standard errors against a bump that is narrower by a factor e than the widest untested part of its load.
NARROW = 1.0
_OPS = NumpyOps()


class Empirical(Effect):
    """A term of the grammar of `empirical_terms`; `empirical_effect` makes the class of one term.

    It adds ``a fade (f - trend)``. ``trend`` is the straight line (or plane) through the curve f over the tested ranges: that part
    belongs to the model. ``fade`` is 1 within the tested range of every load, of f or not, and falls to 0 within a tenth of the range
    beyond it. So the model is its base outside of what was tested. A name that starts with ``sloping_`` keeps the slope of the
    curve in the term and leaves only the mean to the model: that is for a constant base.
    """

    term: ClassVar[Term]
    citation = "none: an empirical term, chosen by the prediction of unseen tests"
    amplitudes = (Amplitude("a", "1", "strength of the empirical term", 0, 0.01),)

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self.name, self.fixed)

    def grids(self, spans: Spans) -> dict[str, FloatArray]:
        """Return the scan values, and as the edges of the fade the ranges of the data."""
        ranges = {n: _range(spans, n) for n in LOAD_NAMES}
        found = {n: np.asarray(v, dtype=np.float64) for n, v in self.term.grids(ranges).items()}
        for name, (low, high, *_) in ranges.items():
            found |= {f"lo_{name}": np.array([low]), f"hi_{name}": np.array([high])}
        return {n: np.array([self.fixed[n]]) if n in self.fixed else v for n, v in found.items()}

    def limits(self, shape: ShapeParameter, values: FloatArray) -> tuple[float, float]:
        """Return as for any effect; the middle of a curve stays within the tests, where they show it."""
        low, high = super().limits(shape, values)
        if shape.name.startswith("f"):
            return shape.lower, shape.upper
        if shape.name == "w" and len(self.term.parts) > 1:
            return shape.lower, high
        if shape.name.startswith("l"):
            return 0.7 * float(values.min()), 1.5 * float(values.max())
        if not shape.name.startswith("c"):
            return low, high
        least, most = float(values.min()), float(values.max())
        step = (most - least) / max(len(values) - 1, 1)
        below, above = least - 0.3 * abs(least), most + 0.2 * abs(most)
        return max(low, least - 0.9 * step, below), min(high, most + 0.9 * step, above)

    def doubt(self, shape: Mapping[str, float], spans: Spans) -> float:
        """Return by how many e-folds bumps are narrower than the widest untested part of their load."""
        ranges = {n: _range(spans, n) for n in self.term.loads}
        return NARROW * sum(
            max(np.log(w / shape["w"]), 0.0) for w in self.term.shown_widths(ranges) if w > 0.0
        )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        loads = {n: getattr(L, n) for n in self.term.loads}
        mean, slopes = self._trend(p)
        value = self.term.value(x, loads, p) - mean
        for name, slope in slopes.items():
            value = value - slope * _place(loads[name], name, p)
        for name in LOAD_NAMES:
            if f"lo_{name}" in p:
                value = value * _fade(x, getattr(L, name), name, p)
        return (value,)

    def _trend(self, p: Parameters) -> tuple[Any, dict[str, Any]]:
        """Return mean and slopes of the curve over the tested ranges, each load as -1 to 1."""
        names = self.term.loads
        along = np.linspace(-1.0, 1.0, PLACES[len(names)])
        mesh = [m.ravel()[:, None] for m in np.meshgrid(*([along] * len(names)), indexing="ij")]
        nodes = {
            n: 0.5 * (p[f"lo_{n}"] + p[f"hi_{n}"]) + 0.5 * (p[f"hi_{n}"] - p[f"lo_{n}"]) * m
            for n, m in zip(names, mesh, strict=True)
        }
        value = self.term.value(_OPS, nodes, p)
        one = all(np.size(v) == 1 for v in p.values())
        slopes = {}
        if not self.term.sloping:
            for n, m in zip(names, mesh, strict=True):
                slope = np.sum(m * value, axis=0, keepdims=True) / np.sum(m * m)
                slopes[n] = float(slope[0, 0]) if one else slope
        mean = np.mean(value, axis=0, keepdims=True)
        return float(mean[0, 0]) if one else mean, slopes


def _range(spans: Spans, name: str) -> tuple[float, ...]:
    """Return the tested range of a load, where it does not vary a little around it, and its widest untested parts."""
    low, high, *untested = spans.get(f"range of {name}", spans.get(name, (0.0, QUANTITIES[name].nominal)))
    return (low, high if high > low else low + max(1e-3, 1e-3 * abs(low)), *untested)


def _place(column: Value, name: str, p: Parameters) -> Value:
    """Return a load as -1 to 1 over its tested range."""
    low, high = p[f"lo_{name}"], p[f"hi_{name}"]
    return (column - 0.5 * (low + high)) * (2.0 / (high - low))


def _fade(x: Ops, column: Value, name: str, p: Parameters) -> Value:
    """Return 1 in the tested range of a load, and a smooth fall to 0 within `FADE` of the range beyond."""
    beyond = x.relu(x.abs(_place(column, name, p)) - 1.0)
    s = x.minimum(beyond * (0.5 / FADE), 1.0)
    return 1.0 - s * s * (3.0 - 2.0 * s)


@cache
def empirical_effect(term: str) -> type[Empirical]:
    """Return the effect of a term; the same class each time.

    Raises
    ------
    InputError
        A text that is no term.

    Examples
    --------
    A bump in temperature, at its middle, at the edge of what was tested, and far beyond:

    >>> from friction_models.effects import empirical_effect
    >>> effect = empirical_effect("bump(T)")(c=150.0, w=30.0, lo_T=20.0, hi_T=300.0)
    >>> effect.equation
    'mu += a fade(loads) [exp(-((T - c)/w)^2/2) - trend]'
    >>> effect.at(T=[150, 300, 400]).round(2).tolist()
    [[0.74], [-0.21], [-0.0]]
    """
    made = parse_term(term)
    names = made.loads
    edges = []
    for n in LOAD_NAMES:
        q = QUANTITIES[n]
        edges += [
            ShapeParameter(
                f"lo_{n}", q.unit, f"least {n} in the tests", q.lower, q.upper, _start(n)[0], points=1
            ),
            ShapeParameter(
                f"hi_{n}", q.unit, f"largest {n} in the tests", q.lower, q.upper, _start(n)[1], points=1
            ),
        ]
    over = listed(names)
    declared = {
        "term": made,
        "name": PREFIX + term,
        "title": f"empirical term, no law: {term}",
        "label": f"Empirical term {term}",
        "sentence": f"an empirical term over {over} describes what the tests show, without a law behind it",
        "equation": f"mu += a fade(loads) [{made.formula} - {'mean' if made.sloping else 'trend'}]"
        + (f", {made.where}" if made.where else ""),
        "latex": _latex(made),
        "where_it_shows": f"over {over}, within the tested range of all loads; beyond it, the term fades to nothing",
        "driver": names,
        "needs": names,
        "shapes": (*made.parameters, *edges),
        "__doc__": f"The empirical term {term}; see `Empirical`.",
        "__module__": __name__,
    }
    return type("Empirical", (Empirical,), declared)


def numbered(effect: Effect, values: Mapping[str, float]) -> str:
    """Return the equation of an effect with numbers in the place of its parameters.

    Examples
    --------
    >>> numbered(empirical_effect("bump(T)")(), {"a": 0.012, "c": 150.0, "w": 30.0})
    'mu += 0.012 fade(loads) [exp(-((T - 150)/30)^2/2) - trend]'
    """
    names = sorted(values, key=len, reverse=True)
    if not names:
        return effect.equation
    pattern = re.compile(r"(?<![A-Za-z_0-9])(" + "|".join(map(re.escape, names)) + r")(?![A-Za-z_0-9])")
    return pattern.sub(lambda m: f"{values[m[1]]:.4g}", effect.equation)


def _start(name: str) -> tuple[float, float]:
    low = {"T": 20.0, "psi": 1.0}.get(name, 0.0)
    return low, low + max(2.0 * (QUANTITIES[name].nominal - low), 1.0)


def _latex(term: Term) -> str:
    shown = "*".join(map(str, term.parts)).replace("_", r"\_")
    return rf"\mu \mathrel{{+}}= a\,w\left[\mathrm{{{shown}}} - \mathrm{{trend}}\right]"


def _made(name: str, fixed: Mapping[str, float]) -> Empirical:
    return empirical_effect(name.removeprefix(PREFIX))(**fixed)
