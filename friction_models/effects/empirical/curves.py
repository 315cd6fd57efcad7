"""One curve of an empirical term: its parameters, their scan values, its value and its formula."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...expressions.ops import Ops, Value
from ...expressions.periodic import cosine
from ...loads.contract import QUANTITIES
from ..base import Parameters
from ..parameters import ShapeParameter

#: A load below this share of its largest value counts as that share where its logarithm or power is taken.
LEAST = 0.01
#: Beyond this share of the tested range a wave keeps its value: the term has faded there.
KEPT = 0.2
#: What a cosine that is a little longer than the tested range goes through, with twelve waves over the range at most.
MOST_TURNS = 32
#: Middles of curves lie at least so far above the least value that a load can have.
TINY = 1e-9
#: Largest values below this count as this.
SMALL = 1e-6

#: Ranges of the loads in the tests: lowest and highest value and, where known, the widest untested part of the range and of the
#: range of the logarithm, as shares.
Ranges = Mapping[str, tuple[float, ...]]
#: Curves of a product that have no parameters.
STRAIGHT = ("line", "share")


@dataclass(frozen=True)
class Part:
    """One curve of a term."""

    #: One of `ALONE` or `IN_PRODUCTS`.
    form: str
    #: A load, or its logarithm, ``log_v_rel``.
    load: str
    #: Sign and second load of a product, quotient, sum or difference; both empty without one.
    way: str = ""
    other: str = ""

    def __str__(self) -> str:
        return f"{self.form}({self.load}{self.way}{self.other})"

    @property
    def logarithmic(self) -> bool:
        """Whether the curve runs over the logarithm of its quantity."""
        return not self.added and (bool(self.other) or self.load.startswith("log_"))

    @property
    def added(self) -> bool:
        """Whether the curve runs over a sum or difference of two quantities."""
        return self.way in {"+", "-"}


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
    unit, least, start = ("1", 0.0, 0.3) if part.other else (q.unit, q.lower, q.nominal)
    return ShapeParameter(name, unit, f"place in {part.load}", least + TINY, 1e9, start)


def wave(part: Part, ending: str = "") -> tuple[ShapeParameter, ShapeParameter]:
    """Return length and phase of a wave."""
    unit = QUANTITIES[load_of(part.load)].unit
    return (
        ShapeParameter(f"l{ending}", unit, f"wave length in {part.load}", 1e-9, 1e9, 10.0, points=17),
        ShapeParameter(f"f{ending}", "1", "phase, as a share of a wave", 0.05, 0.95, 0.5, points=4),
    )


def alone(part: Part) -> tuple[ShapeParameter, ...]:
    """Return the parameters of a curve that is a whole term."""
    unit = "1" if part.logarithmic or part.added else QUANTITIES[load_of(part.load)].unit
    width = ShapeParameter("w", unit, "width", 1e-9, 1e9, 0.3 if unit == "1" else 50.0, points=3)
    exponent = ShapeParameter("n", "1", "exponent", 0.05, 6.0, 0.5, points=4)
    own: dict[str, tuple[ShapeParameter, ...]] = {
        "power": (exponent,),
        "inverse": (exponent,),
        "logarithm": (centre("c", part),),
        "saturation": (centre("c", part),),
        "threshold": (centre("c", part), width),
        "bump": (centre("c", part), width),
        "wave": wave(part),
        "ripple": (
            *wave(part),
            ShapeParameter("d", unit, "range over which it fades", 1e-9, 1e9, 20.0, points=2),
        ),
    }
    if part.other:
        what = "weight" if part.added else "exponent"
        other = ShapeParameter("k", "1", f"{what} of {part.other}", 0.05, 6.0, 1.0, points=3)
        return (*own[part.form], other)
    return own[part.form]


def in_product(part: Part, k: int) -> tuple[ShapeParameter, ...]:
    """Return the parameters of curve `k` of a product; they share their width ``w``."""
    if part.form == "wave":
        return wave(part, f"_{k}")
    return () if part.form in STRAIGHT else (centre(f"c_{k}", part),)


def centres(part: Part, ranges: Ranges, several: int) -> Sequence[float]:
    """Return scan values of the middle of a curve within the tested range."""
    if part.added:
        return tuple(np.linspace(0.15, 1.65, several))
    if part.other:
        return tuple(np.geomspace(0.03, 0.8, several))
    low, high, *_ = ranges[load_of(part.load)]
    if part.logarithmic:
        return tuple(np.geomspace(max(low, LEAST * high) * 1.3, 0.85 * high, several))
    return tuple(np.maximum(np.linspace(low, high, several + 2)[1:-1], centre("c", part).lower))


def wave_grid(
    part: Part, ranges: Ranges, waves: Sequence[float], ending: str = ""
) -> dict[str, Sequence[float]]:
    """Return scan values of a wave that goes so often over the tested range."""
    low, high, *_ = ranges[load_of(part.load)]
    return {f"l{ending}": tuple((high - low) / n for n in waves), f"f{ending}": (0.25, 0.375, 0.5, 0.625)}


def alone_grid(part: Part, ranges: Ranges) -> dict[str, Sequence[float]]:
    """Return scan values of the parameters of a curve that is a whole term."""
    low, high, *_ = ranges[load_of(part.load)]
    rise = 1.0 if part.logarithmic or part.added else high - low
    relative = (
        (0.12, 0.4, 1.0) if part.logarithmic else (0.06, 0.15, 0.35) if part.added else (0.05, 0.1, 0.2)
    )
    width = tuple(rise * r for r in relative)
    several = 7 if part.other else 12
    zero = 1.0 if part.load == "psi" else 0.0
    scale = tuple(np.geomspace(0.03, 1.0, 7) * max(high - zero, 1e-9))
    exponents = (0.3, 0.6, 1.0, 2.0) if part.other or part.form == "inverse" else (0.3, 0.6, 1.5, 2.0, 3.0)
    centre_and_width = {"c": centres(part, ranges, several), "w": width}
    waves = tuple(np.arange(1.0, 9.01, 0.5))
    every: dict[str, dict[str, Sequence[float]]] = {
        "power": {"n": exponents},
        "inverse": {"n": exponents},
        "logarithm": {"c": scale},
        "saturation": {"c": scale},
        "threshold": centre_and_width,
        "bump": centre_and_width,
    }
    if part.form == "wave":
        return wave_grid(part, ranges, waves)
    if part.form == "ripple":
        return wave_grid(part, ranges, waves) | {"d": (0.3 * (high - low), high - low)}
    found = every[part.form]
    return found | ({"k": (0.3, 0.8, 1.6) if part.added else (0.5, 1.0, 2.0)} if part.other else {})


def product_grid(part: Part, k: int, ranges: Ranges, several: int) -> dict[str, Sequence[float]]:
    """Return scan values of the parameters of curve `k` of a product, without the common width."""
    if part.form == "wave":
        return wave_grid(part, ranges, (0.75, 1.25, 1.75, 2.5), f"_{k}")
    return {} if part.form in STRAIGHT else {f"c_{k}": centres(part, ranges, several)}


def shown_width(part: Part, ranges: Ranges, share: bool) -> float:
    """Return the width of a bump as wide as the widest untested part of the range, as a `share` of the range or as it is; else 0.

    A narrower one can rise and fall where no test is.
    """
    if part.form != "bump" or part.other:
        return 0.0
    low, high, *untested = ranges[load_of(part.load)]
    if not untested:
        return 0.0
    whole = np.log(high / max(low, LEAST * high)) if part.logarithmic else high - low
    return float(untested[part.logarithmic] * (1.0 if share else whole))


# --- values -------------------------------------------------------------------------------------------


def _ratio(x: Ops, load: str, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return a load as a share of its largest value, never below `LEAST`; psi counts from 1 but for its logarithm."""
    zero = 1.0 if load == "psi" else 0.0
    load = load_of(load)
    return x.maximum((loads[load] - zero) / np.maximum(p[f"hi_{load}"] - zero, SMALL), LEAST)


def _log(x: Ops, part: Part, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return the logarithm of the quantity of a curve: of a load over its largest value, or of q."""
    value = x.log(_ratio(x, part.load, loads, p))
    if not part.other:
        return value
    other = p["k"] * x.log(_ratio(x, part.other, loads, p))
    return value + other if part.way == "*" else value - other


def _along(x: Ops, name: str, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return a load or its logarithm as 0 to 1 over the tested range."""
    load = load_of(name)
    if name.startswith("log_"):
        return 1.0 + x.log(_ratio(x, name, loads, p)) / _range_of_log(load, p)
    return (loads[load] - p[f"lo_{load}"]) / (p[f"hi_{load}"] - p[f"lo_{load}"])


def _added(x: Ops, part: Part, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return the sum, or difference, over which a curve runs; never negative within the tests."""
    other = _along(x, part.other, loads, p)
    return _along(x, part.load, loads, p) + p["k"] * (other if part.way == "+" else 1.0 - other)


def _away(x: Ops, part: Part, centre: str, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return how far the quantity is from the centre."""
    if part.added:
        return _added(x, part, loads, p) - p[centre]
    load = load_of(part.load)
    if not part.logarithmic:
        return loads[load] - p[centre]
    return _log(x, part, loads, p) - np.log(p[centre] if part.other else p[centre] / p[f"hi_{load}"])


def _range_of_log(load: str, p: Parameters) -> Any:
    """Return how far the logarithm of a load goes in the tests."""
    high = np.maximum(p[f"hi_{load}"], SMALL)
    return np.maximum(np.log(high / np.maximum(p[f"lo_{load}"], LEAST * high)), 1e-3)


def _wave(x: Ops, part: Part, ending: str, loads: Mapping[str, Value], p: Parameters) -> Value:
    low, high = p[f"lo_{part.load}"], p[f"hi_{part.load}"]
    beyond = KEPT * (high - low)
    held = x.minimum(x.maximum(loads[part.load], low - beyond), high + beyond)
    return cosine(x, (held - low) / p[f"l{ending}"] - p[f"f{ending}"], MOST_TURNS)


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
    if part.form == "wave":
        return _wave(x, part, "", loads, p)
    if part.form == "ripple":
        along = x.relu(loads[part.load] - p[f"lo_{part.load}"])
        return _wave(x, part, "", loads, p) * x.exp(-along / p["d"])
    u = x.relu(loads[part.load] - (1.0 if part.load == "psi" else 0.0)) / p["c"]
    return x.log(1.0 + u) if part.form == "logarithm" else 1.0 - x.exp(-u)


def factor(x: Ops, part: Part, k: int, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return a curve of a product of two at columns of loads; `k` is its number."""
    load = load_of(part.load)
    if part.form == "share":
        return _ratio(x, load, loads, p)
    if part.form == "wave":
        return _wave(x, part, f"_{k}", loads, p)
    width = _range_of_log(load, p) if part.logarithmic else p[f"hi_{load}"] - p[f"lo_{load}"]
    if part.form == "line":
        if part.logarithmic:
            return 1.0 + 2.0 / width * _log(x, part, loads, p)
        return (2.0 * loads[load] - p[f"lo_{load}"] - p[f"hi_{load}"]) / width
    z = _away(x, part, f"c_{k}", loads, p) / (p["w"] * width)
    if part.form == "bump":
        return x.exp(-0.5 * z * z)
    rise = x.tanh(z)
    return {"step": rise, "rise": 0.5 + 0.5 * rise, "fall": 0.5 - 0.5 * rise}[part.form]


# --- words --------------------------------------------------------------------------------------------


def curve_text(part: Part) -> str:
    """Return a curve that stands alone as a formula, over `q` where it has two loads."""
    zero = " - 1" if part.load == "psi" else ""
    u = f"({part.load}{zero})" if zero else part.load
    if part.form in {"logarithm", "saturation"}:
        return f"ln(1 + {u}/c)" if part.form == "logarithm" else f"1 - exp(-{u}/c)"
    if part.other:
        away, base = "(q - c)" if part.added else "ln(q/c)", "q"
    else:
        base = share_text(part.load, closed=True)
        away = f"ln({load_of(part.load)}/c)" if part.logarithmic else f"({part.load} - c)"
    if part.form in {"wave", "ripple"}:
        fading = f" exp(-({part.load} - lo_{part.load})/d)" if part.form == "ripple" else ""
        return wave_text(part) + fading
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


def quantity_text(part: Part) -> str:
    """Return what `q` is."""
    if part.added:
        other = _along_text(part.other)
        return f"{_along_text(part.load)} + k {other if part.way == '+' else f'(1 - {other})'}"
    other = share_text(part.other, closed=True)
    return f"{share_text(part.load)} {'' if part.way == '*' else '/ '}{other}^k"


def _along_text(name: str) -> str:
    load = load_of(name)
    if name.startswith("log_"):
        return f"(1 + ln({load}/hi_{load})/{_log_range_text(load)})"
    return f"({load} - lo_{load})/(hi_{load} - lo_{load})"


def _log_range_text(load: str) -> str:
    return f"ln(hi_{load}/max(lo_{load}, {LEAST:g} hi_{load}))"


def wave_text(part: Part, ending: str = "") -> str:
    """Return a wave as a formula."""
    return f"cos(2 pi (({part.load} - lo_{part.load})/l{ending} - f{ending}))"


def factor_text(part: Part, k: int) -> str:
    """Return a curve of a product of two as a formula; `k` is its number."""
    load = load_of(part.load)
    if part.form == "share":
        return share_text(load, closed=True)
    if part.form == "wave":
        return wave_text(part, f"_{k}")
    log_range = _log_range_text(load)
    if part.form == "line":
        if part.logarithmic:
            return f"(1 + 2 ln({load}/hi_{load})/{log_range})"
        return f"(2 {load} - lo_{load} - hi_{load})/(hi_{load} - lo_{load})"
    if part.logarithmic:
        z = f"ln({load}/c_{k})/({log_range} w)"
    else:
        z = f"({load} - c_{k})/(w (hi_{load} - lo_{load}))"
    return {
        "step": f"tanh({z})",
        "rise": f"(1 + tanh({z}))/2",
        "fall": f"(1 - tanh({z}))/2",
        "bump": f"exp(-({z})^2/2)",
    }[part.form]
