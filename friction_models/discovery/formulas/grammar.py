"""Which terms are tried: curves over each load, over products and quotients of two, and products of two curves."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import combinations, permutations

from ...effects.empirical_curves import load_of
from ...effects.empirical_terms import ALONE, ON_LOGARITHM, OVER_TWO, SLOPING, Term, parse_term

#: Kinds of products of two curves; where they differ, each may be over either load.
PRODUCTS = (("line", "line"), ("line", "step"), ("line", "bump"), ("step", "step"), ("bump", "bump"))


@cache
def terms(loads: tuple[str, ...], sloping: bool = False) -> tuple[Term, ...]:
    """Return all terms over some loads, the simplest first.

    Parameters
    ----------
    loads : tuple of str
        Those that vary.
    sloping : bool
        Whether the terms keep their straight part, for a base without slopes.

    Examples
    --------
    >>> [str(t) for t in terms(("T",))]
    ['power(T)', 'inverse(T)', 'logarithm(T)', 'saturation(T)', 'threshold(T)', 'bump(T)']
    >>> len(terms(("v_rel", "T", "sigma_n", "sd", "psi")))
    210
    """
    found = [f"{form}({name})" for name in loads for form in ALONE]
    if "v_rel" in loads:
        found += [f"{form}(log_v_rel)" for form in ALONE if form in ON_LOGARITHM]
    for a, b in combinations(loads, 2):
        found += [f"{form}({a}{way}{b})" for form in OVER_TWO for way in "*/"]
    places = [*loads, "log_v_rel"] if "v_rel" in loads else list(loads)
    for one, two in PRODUCTS:
        found += [f"{one}({a})*{two}({b})" for a, b in _pairs(places, one == two)]
    return tuple(parse_term((SLOPING if sloping else "") + text) for text in found)


def _pairs(places: Sequence[str], alike: bool) -> list[tuple[str, str]]:
    pairs = combinations(places, 2) if alike else permutations(places, 2)
    return [(a, b) for a, b in pairs if load_of(a) != load_of(b)]
