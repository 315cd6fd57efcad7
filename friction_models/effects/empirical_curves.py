"""One curve of an empirical term: its parameters, their scan values, its value and its formula."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..expressions.ops import Ops, Value
from ..loads.contract import QUANTITIES
from .base import ShapeParameter

#: A load below this share of its largest value counts as that share where its logarithm or power is taken.
LEAST = 0.01
#: Logarithm of what lies between; the scale of ``log_v_rel``.
DECADES = float(-np.log(LEAST))
#: Largest values below this count as this.
SMALL = 1e-6

Parameters = Mapping[str, Any]


@dataclass(frozen=True)
class Part:
    """One curve of a term.

    Attributes
    ----------
    form : str
        One of `ALONE` or `IN_PRODUCTS`.
    load : str
        A load, or ``log_v_rel``.
    way : {"", "*", "/"}
    other : str
        The second load of a product or quotient; empty without one.
    """

    form: str
    load: str
    way: str = ""
    other: str = ""

    def __str__(self) -> str:
        return f"{self.form}({self.load}{self.way}{self.other})"

    @property
    def logarithmic(self) -> bool:
        """Whether the curve runs over the logarithm of its quantity."""
        return bool(self.other) or self.load.startswith("log_")


def load_of(name: str) -> str:
    """Return the load of a quantity: ``log_v_rel`` is made of ``v_rel``.

    Examples
    --------
    >>> load_of("log_v_rel"), load_of("T")
    ('v_rel', 'T')
    """
    return name.removeprefix("log_")


# --- parameters ---------------------------------------------------------------------------------------


def centre(name: str, part: Part) -> ShapeParameter:
    """Return the parameter that says where a curve has its middle."""
    load = load_of(part.load)
    q = QUANTITIES[load]
    unit, start = ("1", 0.3) if part.other else (q.unit, q.nominal)
    return ShapeParameter(name, unit, f"place in {part.load}", 1e-9, 1e6, start, points=8)


def alone(part: Part) -> tuple[ShapeParameter, ...]:
    """Return the parameters of a curve that is a whole term."""
    unit = "1" if part.logarithmic else QUANTITIES[load_of(part.load)].unit
    width = ShapeParameter("w", unit, "width", 1e-9, 1e6, 0.3 if part.logarithmic else 50.0, points=3)
    exponent = ShapeParameter("n", "1", "exponent", 0.05, 6.0, 0.5, points=4)
    own = {
        "power": (exponent,),
        "inverse": (exponent,),
        "logarithm": (centre("c", part),),
        "saturation": (centre("c", part),),
        "threshold": (centre("c", part), width),
        "bump": (centre("c", part), width),
    }[part.form]
    if part.other:
        own += (ShapeParameter("k", "1", f"exponent of {part.other}", 0.2, 4.0, 1.0, points=3),)
    return own


def centres(part: Part, ranges: Mapping[str, tuple[float, float]], several: int) -> Sequence[float]:
    """Return scan values of the middle of a curve within the tested range."""
    if part.other:
        return tuple(np.geomspace(0.03, 0.8, several))
    low, high = ranges[load_of(part.load)]
    if part.logarithmic:
        return tuple(np.geomspace(max(low, LEAST * high) * 1.3, 0.85 * high, several))
    return tuple(np.maximum(np.linspace(low, high, several + 2)[1:-1], 1e-9))


def alone_grid(part: Part, ranges: Mapping[str, tuple[float, float]]) -> dict[str, Sequence[float]]:
    """Return scan values of the parameters of a curve that is a whole term."""
    low, high = ranges[load_of(part.load)]
    rise = high - low if not part.logarithmic else 1.0
    relative = (0.12, 0.4, 1.0) if part.logarithmic else (0.05, 0.1, 0.2)
    width = tuple(rise * r for r in relative)
    several = 7 if part.other else 12
    zero = 1.0 if part.load == "psi" else 0.0
    scale = tuple(np.geomspace(0.03, 1.0, 7) * max(high - zero, 1e-9))
    exponents = (0.3, 0.6, 1.0, 2.0) if part.other or part.form == "inverse" else (0.3, 0.6, 1.5, 2.0, 3.0)
    centre_and_width = {"c": centres(part, ranges, several), "w": width}
    every: dict[str, dict[str, Sequence[float]]] = {
        "power": {"n": exponents},
        "inverse": {"n": exponents},
        "logarithm": {"c": scale},
        "saturation": {"c": scale},
        "threshold": centre_and_width,
        "bump": centre_and_width,
    }
    found = every[part.form]
    return found | ({"k": (0.5, 1.0, 2.0)} if part.other else {})


# --- values -------------------------------------------------------------------------------------------


def _ratio(x: Ops, load: str, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return a load as a share of its largest value, never below `LEAST`."""
    zero = 1.0 if load == "psi" else 0.0
    return x.maximum((loads[load] - zero) / np.maximum(p[f"hi_{load}"] - zero, SMALL), LEAST)


def _log(x: Ops, part: Part, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return the logarithm of the quantity of a curve: of a load over its largest value, or of q."""
    value = x.log(_ratio(x, load_of(part.load), loads, p))
    if not part.other:
        return value
    other = p["k"] * x.log(_ratio(x, part.other, loads, p))
    return value + other if part.way == "*" else value - other


def _away(x: Ops, part: Part, centre: str, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return how far the quantity is from the centre."""
    load = load_of(part.load)
    if not part.logarithmic:
        return loads[load] - p[centre]
    return _log(x, part, loads, p) - np.log(p[centre] if part.other else p[centre] / p[f"hi_{load}"])


def curve(x: Ops, part: Part, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return a curve that is a whole term at columns of loads."""
    if part.form in {"power", "inverse"}:
        sign = 1.0 if part.form == "power" else -1.0
        return x.exp(sign * p["n"] * _log(x, part, loads, p))
    if part.form == "threshold":
        return x.sigmoid(_away(x, part, "c", loads, p) / p["w"])
    if part.form == "bump":
        z = _away(x, part, "c", loads, p) / p["w"]
        return x.exp(-0.5 * z * z)
    u = x.relu(loads[part.load] - (1.0 if part.load == "psi" else 0.0)) / p["c"]
    return x.log(1.0 + u) if part.form == "logarithm" else 1.0 - x.exp(-u)


def factor(x: Ops, part: Part, k: int, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return a curve of a product of two at columns of loads; `k` is its number."""
    load = load_of(part.load)
    width = p[f"hi_{load}"] - p[f"lo_{load}"]
    if part.form == "line":
        if part.logarithmic:
            return 1.0 + 2.0 / DECADES * _log(x, part, loads, p)
        return (2.0 * loads[load] - p[f"lo_{load}"] - p[f"hi_{load}"]) / width
    z = _away(x, part, f"c_{k}", loads, p) / (p["w"] * (DECADES if part.logarithmic else width))
    return x.tanh(z) if part.form == "step" else x.exp(-0.5 * z * z)


# --- words --------------------------------------------------------------------------------------------


def curve_text(part: Part) -> str:
    """Return a curve that stands alone as a formula, over `q` where it has two loads."""
    zero = " - 1" if part.load == "psi" else ""
    u = f"({part.load}{zero})" if zero else part.load
    if part.form in {"logarithm", "saturation"}:
        return f"ln(1 + {u}/c)" if part.form == "logarithm" else f"1 - exp(-{u}/c)"
    if part.other:
        away, base = "ln(q/c)", "q"
    else:
        base = share_text(part.load, closed=True)
        away = f"ln({load_of(part.load)}/c)" if part.logarithmic else f"({part.load} - c)"
    return {
        "power": f"{base}^n",
        "inverse": f"{base}^(-n)",
        "threshold": f"1/(1 + exp(-{away}/w))",
        "bump": f"exp(-({away}/w)^2/2)",
    }[part.form]


def share_text(load: str, closed: bool = False) -> str:
    """Return a load over its largest value in the tests, in brackets where `closed`."""
    text = "(psi - 1)/(hi_psi - 1)" if load == "psi" else f"{load}/hi_{load}"
    return f"({text})" if closed else text


def factor_text(part: Part, k: int) -> str:
    """Return a curve of a product of two as a formula; `k` is its number."""
    load = load_of(part.load)
    if part.form == "line":
        if part.logarithmic:
            return f"(1 + {2.0 / DECADES:.4g} ln({load}/hi_{load}))"
        return f"(2 {load} - lo_{load} - hi_{load})/(hi_{load} - lo_{load})"
    if part.logarithmic:
        z = f"ln({load}/c_{k})/({DECADES:.4g} w)"
    else:
        z = f"({load} - c_{k})/(w (hi_{load} - lo_{load}))"
    return f"tanh({z})" if part.form == "step" else f"exp(-({z})^2/2)"
