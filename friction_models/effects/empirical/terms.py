"""The terms from which empirical effects are made: a small grammar over one or two loads.

A term is one curve, ``bump(T)`` or ``threshold(T*sigma_n)``, or a product of two curves, ``line(v_rel)*step(psi)``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from ...common import InputError
from ...common.errors import nearest
from ...common.wording import listed
from ...expressions.ops import Ops, Value
from ...loads import LOAD_NAMES
from ..parameters import ShapeParameter
from .curves import (
    STRAIGHT,
    Parameters,
    Part,
    Ranges,
    alone,
    alone_grid,
    curve,
    curve_text,
    factor,
    factor_text,
    in_product,
    load_of,
    product_grid,
    quantity_text,
    shown_width,
)

#: Curves over one load, over a product or quotient of two, and in products of two curves.
ALONE = ("power", "inverse", "logarithm", "saturation", "threshold", "bump", "wave", "ripple")
OVER_TWO = ("power", "inverse", "threshold", "bump")
OVER_SUMS = ("threshold", "bump")
IN_PRODUCTS = ("line", "share", "step", "rise", "fall", "bump", "wave")
#: Curves that may run over the logarithm of their load, and loads whose logarithm may be taken.
ON_LOGARITHM = ("threshold", "bump", "line", "step", "rise", "fall")
LOGARITHMS = ("v_rel", "sigma_n", "psi")
SLOPING = "sloping_"
#: The load over which a wave may die away.
DISTANCE = "sd"

_PART = re.compile(r"([a-z]+)\(([A-Za-z_]+)(?:([*/+-])([A-Za-z_]+))?\)")


@dataclass(frozen=True)
class Term:
    """A term of the grammar.

    Examples
    --------
    >>> term = parse_term("threshold(T*sigma_n)")
    >>> term.loads, [p.name for p in term.parameters], str(term)
    (('T', 'sigma_n'), ['c', 'w', 'k'], 'threshold(T*sigma_n)')
    >>> term.formula
    '1/(1 + exp(-ln(q/c)/w))'
    >>> term.where
    'q = T/hi_T (sigma_n/hi_sigma_n)^k'
    """

    #: One curve or two, which are multiplied.
    parts: tuple[Part, ...]
    #: Whether the straight part stays in the term; otherwise it is left to the model.
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
        kinds = [
            "rise" if p.form in steady else "product" if len(self.parts) > 1 else p.form for p in self.parts
        ]
        return f"{kinds[0]} over {listed(sorted(self.loads))}"

    @property
    def parameters(self) -> tuple[ShapeParameter, ...]:
        """What is fitted beside the amplitude."""
        if len(self.parts) == 1:
            return alone(self.parts[0])
        own = [s for k, p in enumerate(self.parts, 1) for s in in_product(p, k)]
        width = ShapeParameter("w", "1", "width as a share of the range", 0.02, 3.0, 0.2, points=2)
        return (*own, width) if self._wide else tuple(own)

    @property
    def _wide(self) -> bool:
        """Whether a curve of a product has a width."""
        return any(p.form not in {"line", "share", "wave"} for p in self.parts)

    @property
    def formula(self) -> str:
        """The curve, over `q` where it runs over a product or quotient."""
        return (
            " ".join(factor_text(part, k) for k, part in enumerate(self.parts, 1))
            if len(self.parts) > 1
            else curve_text(self.parts[0])
        )

    @property
    def where(self) -> str:
        """What `q` is; empty where there is none."""
        return f"q = {quantity_text(self.parts[0])}" if self.parts[0].other else ""

    def value(self, x: Ops, loads: Mapping[str, Value], p: Parameters) -> Value:
        """Return the curve at columns of loads; `p` holds the parameters and the range of each load, ``lo_T``, ``hi_T``."""
        if len(self.parts) == 1:
            return curve(x, self.parts[0], loads, p)
        first, second = (factor(x, part, k, loads, p) for k, part in enumerate(self.parts, 1))
        return first * second

    def grids(self, ranges: Ranges) -> dict[str, Sequence[float]]:
        """Return scan values of the parameters for data with these ranges of the loads."""
        if len(self.parts) == 1:
            return alone_grid(self.parts[0], ranges)
        several = 5 if all(p.form not in STRAIGHT for p in self.parts) else 8
        found: dict[str, Sequence[float]] = {}
        for k, p in enumerate(self.parts, 1):
            found |= product_grid(p, k, ranges, several)
        return found | ({"w": (0.12, 0.3)} if self._wide else {})

    def shown_widths(self, ranges: Ranges) -> list[float]:
        """Return how wide bumps must be to be seen in data with these ranges of the loads, in the unit of ``w``; 0 for other curves."""
        return [shown_width(p, ranges, len(self.parts) > 1) for p in self.parts]


@cache
def parse_term(text: str) -> Term:
    """Return the term that a text describes; raises InputError where it is none.

    Examples
    --------
    >>> parse_term("bump(T)").loads
    ('T',)
    >>> parse_term("line(v_rel)*step(psi)").loads
    ('v_rel', 'psi')
    >>> parse_term("hump(T)")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: empirical term 'hump(T)'; allowed: ..., of the loads v_rel, T, sigma_n, sd, psi; ripple of sd only
    >>> parse_term("bump(sigma)")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: empirical term 'bump(sigma)': no load 'sigma' (did you mean 'sigma_n'?); allowed: ...
    """
    rest = text.removeprefix(SLOPING)
    parts = tuple(Part(*(m.groups(""))) for m in _PART.finditer(rest))
    term = Term(parts, rest != text)
    if str(term) == text and _sound(parts):
        return term
    raise InputError(
        f"empirical term {text!r:.80}{_wrong(parts)}; allowed: {', '.join(ALONE)} of a load, {', '.join(OVER_TWO)} of T*sigma_n or T/sigma_n, "
        f"{', '.join(OVER_SUMS)} of T+sigma_n or T-sigma_n, and "
        f"products of two of {', '.join(IN_PRODUCTS)}, of the loads {', '.join(LOAD_NAMES)}; ripple of {DISTANCE} only"
    )


def _wrong(parts: Sequence[Part]) -> str:
    """Return what of a term is wrong where one name is; empty where its build is."""
    allowed = [*LOAD_NAMES, *(f"log_{n}" for n in LOGARITHMS)]
    for p in parts:
        for name in (n for n in (p.load, p.other) if n):
            if name not in allowed:
                near = nearest(name, allowed)
                return f": no load {name!r} ({f'did you mean {near!r}?' if near else ', '.join(LOAD_NAMES)})"
        if p.form == "ripple" and p.load != DISTANCE:
            return f": ripple runs over the distance {DISTANCE} only, not over {p.load}"
    return ""


def _sound(parts: Sequence[Part]) -> bool:
    if not 1 <= len(parts) <= 2:
        return False
    for p in parts:
        names = [n for n in (p.load, p.other) if n]
        logarithm = (p.added or not p.other) and p.form in ON_LOGARITHM
        known = all(
            n in LOAD_NAMES or (logarithm and load_of(n) in LOGARITHMS and n == f"log_{load_of(n)}")
            for n in names
        )
        two = OVER_SUMS if p.added else OVER_TWO
        forms = IN_PRODUCTS if len(parts) == 2 else two if p.other else ALONE
        if not known or p.form not in forms or (p.form == "ripple" and p.load != DISTANCE):
            return False
        if len(parts) == 2 and p.other:
            return False
    loads = [load_of(n) for p in parts for n in (p.load, p.other) if n]
    return len(set(loads)) == len(loads)
