"""The terms from which empirical effects are made: a small grammar over one or two loads.

A term is one curve, ``bump(T)`` or ``threshold(T*sigma_n)``, or a product of two curves, ``line(v_rel)*step(psi)``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..common import InputError
from ..expressions.ops import LoadColumns, Ops, Value
from ..loads import LOAD_NAMES
from ..loads.contract import QUANTITIES
from .base import ShapeParameter

#: Curves over one load, over a product or quotient of two, and in products of two curves.
ALONE = ("power", "inverse", "logarithm", "saturation", "threshold", "bump")
OVER_TWO = ("power", "inverse", "threshold", "bump")
IN_PRODUCTS = ("line", "step", "bump")
#: Curves that need no logarithm of their load.
ON_LOGARITHM = ("threshold", "bump", "line", "step")
#: A load below this share of its largest value counts as that share where its logarithm or power is taken.
LEAST = 0.01
#: Logarithm of what lies between; the scale of ``log_v_rel``.
DECADES = float(-np.log(LEAST))
SLOPING = "sloping_"

_PART = re.compile(r"([a-z]+)\(([A-Za-z_]+)(?:([*/])([A-Za-z_]+))?\)")

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


@dataclass(frozen=True)
class Term:
    """A term of the grammar.

    Attributes
    ----------
    parts : tuple of Part
        One curve or two, which are multiplied.
    sloping : bool
        Whether the straight part stays in the term; otherwise it is left to the model.

    Examples
    --------
    >>> term = parse_term("threshold(T*sigma_n)")
    >>> term.loads, [p.name for p in term.parameters], str(term)
    (('T', 'sigma_n'), ['c', 'w', 'k'], 'threshold(T*sigma_n)')
    >>> term.formula
    '1/(1 + exp(-ln(q/c)/w)), q = T/hi_T (sigma_n/hi_sigma_n)^k'
    """

    parts: tuple[Part, ...]
    sloping: bool = False

    def __str__(self) -> str:
        return (SLOPING if self.sloping else "") + "*".join(map(str, self.parts))

    @property
    def loads(self) -> tuple[str, ...]:
        """The loads it uses, in the order of the term."""
        names = [n for p in self.parts for n in (p.load, p.other) if n]
        return tuple(dict.fromkeys(load_of(n) for n in names))

    @property
    def family(self) -> str:
        """Loads and kind of curve: terms of one family draw nearly the same curves."""
        steady = {"power", "inverse", "logarithm", "saturation", "threshold"}
        kinds = ["rise" if p.form in steady else "product" if len(self.parts) > 1 else p.form for p in self.parts]
        return f"{kinds[0]} over {' and '.join(sorted(self.loads))}"

    @property
    def parameters(self) -> tuple[ShapeParameter, ...]:
        """What is fitted beside the amplitude."""
        if len(self.parts) == 1:
            return _alone(self.parts[0])
        centres = [
            _centre(f"c_{k}", p) for k, p in enumerate(self.parts, 1) if p.form != "line"
        ]
        width = ShapeParameter("w", "1", "width as a share of the range", 0.02, 3.0, 0.2, points=2)
        return (*centres, width) if centres else ()

    @property
    def formula(self) -> str:
        """The curve in words of formulas."""
        return _text(self)

    def value(self, x: Ops, loads: Mapping[str, Value], p: Parameters) -> Value:
        """Return the curve at columns of loads; `p` holds the parameters and the range of each load, ``lo_T``, ``hi_T``."""
        if len(self.parts) == 1:
            return _curve(x, self.parts[0], loads, p)
        first, second = (_factor(x, part, k, loads, p) for k, part in enumerate(self.parts, 1))
        return first * second

    def grids(self, ranges: Mapping[str, tuple[float, float]]) -> dict[str, Sequence[float]]:
        """Return scan values of the parameters for data with these ranges of the loads."""
        if len(self.parts) == 1:
            return _alone_grid(self.parts[0], ranges)
        several = 5 if all(p.form != "line" for p in self.parts) else 8
        found: dict[str, Sequence[float]] = {
            f"c_{k}": _centres(p, ranges, several) for k, p in enumerate(self.parts, 1) if p.form != "line"
        }
        return found | ({"w": (0.12, 0.3)} if found else {})


@cache
def parse_term(text: str) -> Term:
    """Return the term that a text describes.

    Raises
    ------
    InputError
        A text that is no term.

    Examples
    --------
    >>> parse_term("bump(T)").loads
    ('T',)
    >>> parse_term("line(v_rel)*step(psi)").loads
    ('v_rel', 'psi')
    >>> parse_term("hump(T)")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: empirical term 'hump(T)'; allowed: ..., of the loads v_rel, T, sigma_n, sd, psi
    """
    rest = text.removeprefix(SLOPING)
    parts = tuple(Part(*(m.groups(""))) for m in _PART.finditer(rest))
    term = Term(parts, rest != text)
    if str(term) == text and _sound(parts):
        return term
    raise InputError(
        f"empirical term {text!r:.80}; allowed: {', '.join(ALONE)} of a load, {', '.join(OVER_TWO)} of T*sigma_n or T/sigma_n, and "
        f"products of two of {', '.join(IN_PRODUCTS)}, of the loads {', '.join(LOAD_NAMES)}"
    )


def _sound(parts: Sequence[Part]) -> bool:
    if not 1 <= len(parts) <= 2:
        return False
    for p in parts:
        names = [n for n in (p.load, p.other) if n]
        known = all(n in LOAD_NAMES or (n == "log_v_rel" and not p.other) for n in names)
        forms = IN_PRODUCTS if len(parts) == 2 else OVER_TWO if p.other else ALONE
        if not known or p.form not in forms or (p.logarithmic and not p.other and p.form not in ON_LOGARITHM):
            return False
        if len(parts) == 2 and p.other:
            return False
    loads = [load_of(n) for p in parts for n in (p.load, p.other) if n]
    return len(set(loads)) == len(loads)


# --- parameters ---------------------------------------------------------------------------------------


def _centre(name: str, part: Part) -> ShapeParameter:
    load = load_of(part.load)
    q = QUANTITIES[load]
    unit, start = ("1", 0.3) if part.other else (q.unit, q.nominal)
    return ShapeParameter(name, unit, f"place in {part.load}", 1e-9, 1e6, start, points=8)


def _alone(part: Part) -> tuple[ShapeParameter, ...]:
    unit = "1" if part.logarithmic else QUANTITIES[load_of(part.load)].unit
    width = ShapeParameter("w", unit, "width", 1e-9, 1e6, 0.3 if part.logarithmic else 50.0, points=3)
    exponent = ShapeParameter("n", "1", "exponent", 0.05, 6.0, 0.5, points=4)
    own = {
        "power": (exponent,),
        "inverse": (exponent,),
        "logarithm": (_centre("c", part),),
        "saturation": (_centre("c", part),),
        "threshold": (_centre("c", part), width),
        "bump": (_centre("c", part), width),
    }[part.form]
    if part.other:
        own += (ShapeParameter("k", "1", f"exponent of {part.other}", 0.2, 4.0, 1.0, points=3),)
    return own


def _centres(part: Part, ranges: Mapping[str, tuple[float, float]], several: int) -> Sequence[float]:
    if part.other:
        return tuple(np.geomspace(0.03, 0.8, several))
    low, high = ranges[load_of(part.load)]
    if part.logarithmic:
        return tuple(np.geomspace(max(low, LEAST * high) * 1.3, 0.85 * high, several))
    return tuple(np.maximum(np.linspace(low, high, several + 2)[1:-1], 1e-9))


def _alone_grid(part: Part, ranges: Mapping[str, tuple[float, float]]) -> dict[str, Sequence[float]]:
    low, high = ranges[load_of(part.load)]
    rise = high - low if not part.logarithmic else 1.0
    relative = (0.12, 0.4, 1.0) if part.logarithmic else (0.05, 0.1, 0.2)
    width = tuple(rise * r for r in relative)
    several = 7 if part.other else 12
    zero = 1.0 if part.load == "psi" else 0.0
    scale = tuple(np.geomspace(0.03, 1.0, 7) * max(high - zero, 1e-9))
    exponents = (0.3, 0.6, 1.0, 2.0) if part.other or part.form == "inverse" else (0.3, 0.6, 1.5, 2.0, 3.0)
    found: dict[str, Sequence[float]] = {
        "power": {"n": exponents},
        "inverse": {"n": exponents},
        "logarithm": {"c": scale},
        "saturation": {"c": scale},
        "threshold": {"c": _centres(part, ranges, several), "w": width},
        "bump": {"c": _centres(part, ranges, several), "w": width},
    }[part.form]
    return found | ({"k": (0.5, 1.0, 2.0)} if part.other else {})


# --- values -------------------------------------------------------------------------------------------


def _ratio(x: Ops, load: str, loads: Mapping[str, Value], p: Parameters) -> Value:
    """Return a load as a share of its largest value, never below `LEAST`."""
    zero = 1.0 if load == "psi" else 0.0
    return x.maximum((loads[load] - zero) / (p[f"hi_{load}"] - zero), LEAST)


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


def _curve(x: Ops, part: Part, loads: Mapping[str, Value], p: Parameters) -> Value:
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


def _factor(x: Ops, part: Part, k: int, loads: Mapping[str, Value], p: Parameters) -> Value:
    load = load_of(part.load)
    width = p[f"hi_{load}"] - p[f"lo_{load}"]
    if part.form == "line":
        if part.logarithmic:
            return 1.0 + 2.0 / DECADES * _log(x, part, loads, p)
        return (2.0 * loads[load] - p[f"lo_{load}"] - p[f"hi_{load}"]) / width
    z = _away(x, part, f"c_{k}", loads, p) / (p["w"] * (DECADES if part.logarithmic else width))
    return x.tanh(z) if part.form == "step" else x.exp(-0.5 * z * z)


# --- words --------------------------------------------------------------------------------------------


def _text(term: Term) -> str:
    if len(term.parts) == 2:
        return " ".join(_factor_text(part, k) for k, part in enumerate(term.parts, 1))
    part = term.parts[0]
    zero = " - 1" if part.load == "psi" else ""
    u = f"({part.load}{zero})" if zero else part.load
    if part.form in {"logarithm", "saturation"}:
        return f"ln(1 + {u}/c)" if part.form == "logarithm" else f"1 - exp(-{u}/c)"
    if part.other:
        q = f", q = {_share(part.load)} {'' if part.way == '*' else '/ '}{_share(part.other, True)}^k"
        away, base = "ln(q/c)", "q"
    else:
        q, base = "", _share(part.load, True)
        away = f"ln({load_of(part.load)}/c)" if part.logarithmic else f"({part.load} - c)"
    shape = {
        "power": f"{base}^n",
        "inverse": f"{base}^(-n)",
        "threshold": f"1/(1 + exp(-{away}/w))",
        "bump": f"exp(-({away}/w)^2/2)",
    }[part.form]
    return shape + q


def _share(load: str, closed: bool = False) -> str:
    text = "(psi - 1)/(hi_psi - 1)" if load == "psi" else f"{load}/hi_{load}"
    return f"({text})" if closed else text


def _factor_text(part: Part, k: int) -> str:
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
