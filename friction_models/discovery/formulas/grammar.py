"""Which terms are tried: curves over each load, over products and quotients of two, and products of two curves."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import combinations, permutations

from ...effects.empirical.curves import load_of
from ...effects.empirical.terms import (
    ALONE,
    DISTANCE,
    ON_LOGARITHM,
    OVER_SUMS,
    OVER_TWO,
    SLOPING,
    Term,
    parse_term,
)

#: Kinds of products of two curves; where they differ, each may be over either load.
PRODUCTS = (
    ("line", "line"),
    ("line", "step"),
    ("line", "bump"),
    ("line", "wave"),
    ("share", "rise"),
    ("share", "bump"),
    ("step", "step"),
    ("step", "bump"),
    ("rise", "rise"),
    ("rise", "fall"),
    ("fall", "fall"),
    ("bump", "bump"),
    ("wave", "wave"),
)


@cache
def terms(
    loads: tuple[str, ...], sloping: bool = False, logarithms: tuple[str, ...] = ("v_rel",)
) -> tuple[Term, ...]:
    """Return all terms over loads that vary, the simplest first.

    `sloping` terms keep their straight part, for a base without slopes; `logarithms` are loads whose logarithm is a quantity,
    too.

    Examples
    --------
    >>> [str(t) for t in terms(("T",))]
    ['power(T)', 'inverse(T)', 'logarithm(T)', 'saturation(T)', 'threshold(T)', 'bump(T)', 'wave(T)']
    >>> len(terms(("v_rel", "T", "sigma_n", "sd", "psi")))
    438
    """
    logs = [f"log_{name}" for name in logarithms if name in loads]
    found = [f"{form}({name})" for name in loads for form in ALONE if form != "ripple" or name == DISTANCE]
    found += [f"{form}({name})" for name in logs for form in ALONE if form in ON_LOGARITHM]
    for a, b in combinations(loads, 2):
        found += [f"{form}({a}{way}{b})" for form in OVER_TWO for way in "*/"]
    for a, b in _pairs([*loads, *logs], "bump", "bump"):
        found += [f"{form}({a}{way}{b})" for form in OVER_SUMS for way in "+-"]
    for one, two in PRODUCTS:
        found += [f"{one}({a})*{two}({b})" for a, b in _pairs([*loads, *logs], one, two)]
    return tuple(parse_term((SLOPING if sloping else "") + text) for text in found)


def _pairs(places: Sequence[str], one: str, two: str) -> list[tuple[str, str]]:
    """Return the quantities over which a product may run."""
    pairs = combinations(places, 2) if one == two else permutations(places, 2)

    def fits(form: str, name: str) -> bool:
        return not name.startswith("log_") or form in ON_LOGARITHM

    return [(a, b) for a, b in pairs if load_of(a) != load_of(b) and fits(one, a) and fits(two, b)]
