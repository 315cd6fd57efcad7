"""Grade one answer of a diagnosis against ``answers.yaml``: acceptable, debatable or wrong."""

from __future__ import annotations

from .answers import LISTS, Answer, Entry, Lists


def names_of(answer: Answer) -> set[str]:
    """Effects that an answer stands for: what it adds, and for ``ambiguous`` also what it cannot tell apart."""
    names = set(answer.get("effects") or [])
    if answer["verdict"] == "ambiguous":
        names |= set(answer.get("confusion_set") or [])
    return names


def matches(answer: Answer, entry: Entry) -> bool:
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


def grade(answer: Answer, expected: Lists) -> str:
    """Grade an answer (``verdict``, ``effects``, ``confusion_set``): what is on no list is wrong.

    Parameters
    ----------
    answer : Answer
        An answer with a verdict.
    expected : Lists
        One entry of ``sets`` in ``answers.yaml``.

    Returns
    -------
    str
        ``acceptable``, ``debatable`` or ``wrong``.
    """
    for word in LISTS:
        if any(matches(answer, entry) for entry in expected[word]):
            return word
    return "wrong"
