"""What a law of friction is in this benchmark, and the list that the files of laws fill."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.blind.campaign import Array, Campaign, Rng

Term = Callable[[Campaign, Array, Rng], Array]


@dataclass(frozen=True)
class Law:
    """A contribution to mu at its usual strength; `term` gets the campaign and the friction without the law.

    Attributes
    ----------
    names : frozenset of str
        Effects of the catalogue that are this mechanism. Empty: outside the catalogue.
    partial : frozenset of str
        Effects that are a true part of the law: not wrong beside "something remains", never right as the whole.
    metadata : tuple of str
        Columns of the test table that the law needs.
    """

    key: str
    source: str
    term: Term
    names: frozenset[str]
    partial: frozenset[str]
    metadata: tuple[str, ...] = ()


LAWS: dict[str, Law] = {}


def law(source: str, names: str = "", partial: str = "", metadata: str = "") -> Callable[[Term], Term]:
    """Enter a function as a law; names are separated by blanks."""

    def enter(term: Term) -> Term:
        key = term.__name__
        LAWS[key] = Law(
            key, source, term, frozenset(names.split()), frozenset(partial.split()), tuple(metadata.split())
        )
        return term

    return enter
