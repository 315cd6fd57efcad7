"""Grade one answer of a diagnosis against ``answers.yaml``: acceptable, debatable or wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def names_of(answer: Mapping[str, Any]) -> set[str]:
    """Effects that an answer stands for: what it adds, and for ``ambiguous`` also what it cannot tell apart."""
    names = set(answer.get("effects") or [])
    if answer["verdict"] == "ambiguous":
        names |= set(answer.get("confusion_set") or [])
    return names


def matches(answer: Mapping[str, Any], entry: Mapping[str, Any]) -> bool:
    """Tell whether an answer meets one entry.

    ``verdict`` must agree; every name of ``all_of`` and one of ``any_of`` must be there; with ``only_from`` the answer has
    no other names (not asked of ``ambiguous``, whose confusion set may be wide).
    """
    names = names_of(answer)
    if answer["verdict"] != entry["verdict"]:
        return False
    if not set(entry.get("all_of", [])) <= names:
        return False
    if "any_of" in entry and not set(entry["any_of"]) & names:
        return False
    return answer["verdict"] == "ambiguous" or "only_from" not in entry or names <= set(entry["only_from"])


def grade(answer: Mapping[str, Any], expected: Mapping[str, Sequence[Mapping[str, Any]]]) -> str:
    """Grade an answer (``verdict``, ``effects``, ``confusion_set``): what is on no list is wrong.

    Parameters
    ----------
    answer
        The dictionary that ``diagnose --json`` writes.
    expected
        One entry of ``sets`` in ``answers.yaml``.

    Returns
    -------
    str
        ``acceptable``, ``debatable`` or ``wrong``.
    """
    for word in ("acceptable", "debatable"):
        if any(matches(answer, entry) for entry in expected.get(word, [])):
            return word
    return "wrong"
