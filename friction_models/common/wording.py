"""Numbers of things and kinds of values in plain words, for messages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from .errors import shown


def counted(number: int, noun: str) -> str:
    """Return how many there are of what.

    Examples
    --------
    >>> counted(1, "test"), counted(3, "point")
    ('1 test', '3 points')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"


def first_names(names: Sequence[str]) -> str:
    """Return the first names of a list, each on one line and not too long.

    Examples
    --------
    >>> first_names(["S03", "S17"]), first_names(list("abcdef"))
    ('S03, S17', 'a, b, c, d, e ...')
    """
    return ", ".join(shown(name, 40) for name in names[:5]) + (" ..." if len(names) > 5 else "")


def listed(names: Iterable[str]) -> str:
    """Return names as one lists them in a sentence.

    Examples
    --------
    >>> listed(["v_rel"]), listed(["v_rel", "T"]), listed(["v_rel", "T", "psi"])
    ('v_rel', 'v_rel and T', 'v_rel, T and psi')
    """
    *others, last = list(names) or [""]
    return f"{', '.join(others)} and {last}" if others else last


def kind_of(value: object) -> str:
    """Return what a value read from JSON or YAML is, in words.

    Examples
    --------
    >>> kind_of(None), kind_of([1, 2]), kind_of("mm"), kind_of(3.0)
    ('nothing', 'a list', 'a text', 'a number')
    """
    if value is None or value == "":
        return "nothing"
    if isinstance(value, bool):
        return "yes or no"
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, list | tuple):
        return "a list"
    return {str: "a text", int: "a number", float: "a number"}.get(type(value), type(value).__name__)
