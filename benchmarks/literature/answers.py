"""Reading an answer of the diagnosis and scoring it against the truth of a case."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import permutations
from typing import Any, TypedDict

from . import names
from .case import Case
from .law import Law
from .registry import get


@dataclass
class Answer:
    """Answer in comparable names.

    Attributes
    ----------
    verdict : str
        Verdict of the diagnosis.
    effects : list of str
        What it would add, in its order.
    confusion : list of str
        What it cannot tell apart.
    confidence : float or None
        Confidence in the answer.
    """

    verdict: str
    effects: list[str] = field(default_factory=list)
    confusion: list[str] = field(default_factory=list)
    confidence: float | None = None


class Score(TypedDict):
    """What an answer is worth; None where it makes no sense for the kind of case.

    ``right`` is for the calibration: None where the case has no single right answer.
    """

    false_alarm: bool | None
    first: bool | None
    first_or_twin: bool | None
    in_set: bool | None
    in_set_or_twin: bool | None
    set_size: int | None
    exact: bool | None
    exact_or_twin: bool | None
    abstains: bool | None
    right: bool | None
    wrong_names: list[str]


def _flat(items: Any) -> list[str]:
    """Names from strings, ``a+b``, tuples, dictionaries or objects with a name."""
    if items is None:
        return []
    if isinstance(items, str):
        return [names.plain(part) for part in items.split("+")]
    if isinstance(items, dict):
        return _flat(items.get("effect") or items.get("name"))
    if isinstance(items, Iterable):
        found = [name for item in items for name in _flat(item)]
        return list(dict.fromkeys(found))
    return _flat(str(getattr(items, "name", items)))


def read(diagnosis: Any) -> Answer:
    """Answer from an object with ``verdict, effects, confidence, confusion_set``.

    Raises
    ------
    AttributeError
        If one of them is missing.
    """
    confidence = diagnosis.confidence
    return Answer(
        str(getattr(diagnosis.verdict, "value", diagnosis.verdict)),
        _flat(diagnosis.effects),
        _flat(diagnosis.confusion_set),
        None if confidence is None else float(confidence),
    )


def _match(effects: list[str], laws: list[Law], near: bool) -> bool:
    """Whether the effects name every law once and nothing else."""
    if len(effects) != len(laws):
        return False
    sets = [law.near() if near else law.right() for law in laws]
    return any(all(e in s for e, s in zip(effects, order, strict=True)) for order in permutations(sets))


def score(case: Case, answer: Answer) -> Score:
    """Score an answer.

    Parameters
    ----------
    case : Case
        The case with its truth.
    answer : Answer
        What the diagnosis said.
    """
    laws = [get(key) for key in case.laws]
    known = [law for law in laws if not law.outside]
    near: frozenset[str] = frozenset().union(*(law.near() for law in laws))
    accepted = answer.effects if answer.verdict in (*names.ACCEPTING, "data_problem") else []
    wrong = [e for e in accepted if e not in near]
    found: Score = {
        "false_alarm": None,
        "first": None,
        "first_or_twin": None,
        "in_set": None,
        "in_set_or_twin": None,
        "set_size": None,
        "exact": None,
        "exact_or_twin": None,
        "abstains": None,
        "right": None,
        "wrong_names": wrong,
    }
    naming = answer.verdict in (*names.ACCEPTING, "ambiguous", "data_problem")
    if case.kind == "null":
        calm = answer.verdict in ("nothing_missing", "out_of_domain")
        told_odd = case.recipe == "odd_tests" and answer.verdict == "data_problem" and not answer.effects
        found["false_alarm"] = not (calm or told_odd)
        found["right"] = answer.verdict == "nothing_missing" or told_odd
    if known and case.kind in ("single", "pair", "triple", "mixed"):
        first = (answer.effects or answer.confusion or [""])[0] if naming else ""
        pool = set(answer.effects) | set(answer.confusion) if naming else set()
        found["first"] = any(first in law.right() for law in known)
        found["first_or_twin"] = any(first in law.near() for law in known)
        found["in_set"] = all(pool & law.right() for law in known)
        found["in_set_or_twin"] = all(pool & law.near() for law in known)
        found["set_size"] = max(len(answer.confusion), len(answer.effects)) if naming else None
        found["exact"] = naming and _match(answer.effects, known, near=False)
        found["exact_or_twin"] = naming and _match(answer.effects, known, near=True)
        if case.kind == "mixed":
            found["abstains"] = _abstains(answer, wrong)
            found["right"] = found["abstains"]
        elif answer.verdict == "ambiguous":
            found["right"] = found["in_set_or_twin"]
        else:
            found["right"] = found["exact_or_twin"]
    if case.kind in ("outside", "hidden_group"):
        calm = answer.verdict in ("nothing_missing", "data_problem") and not answer.effects
        found["abstains"] = _abstains(answer, wrong) or (case.kind == "hidden_group" and calm)
        found["right"] = found["abstains"]
    if case.kind in ("thin", "foreign"):
        found["abstains"] = not wrong
    return found


def _abstains(answer: Answer, wrong: list[str]) -> bool:
    """Says that something unknown is there, or names a part of it and nothing wrong."""
    return answer.verdict == "unknown_structure" or (answer.verdict == "partly_explained" and not wrong)
