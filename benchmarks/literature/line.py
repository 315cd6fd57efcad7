"""A line of the results: a case, what is hidden in it, what was answered and what that is worth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import NotRequired, TypedDict, cast

from .answers import Score
from .build import Record
from .case import Case
from .refining import Refinement


class CaseRow(TypedDict):
    """The fields of a `Case`."""

    id: str
    kind: str
    laws: Sequence[str]
    recipe: str
    seed: int
    ratio: Sequence[float]
    domain: str
    style: str
    points: int
    n_heldout: int


class AnswerRow(TypedDict):
    """The fields of an `Answer`, and what its confidence rests on."""

    verdict: str
    effects: list[str]
    confusion: list[str]
    confidence: float | None
    grounds: dict[str, float]


class Line(TypedDict):
    """One case; ``status`` is ``ok``, ``refused``, ``crash``, ``timeout`` or ``judge_error``.

    Answer and score are there where it is ``ok``, the refinement where it can be judged; times are in s.
    """

    id: str
    case: CaseRow
    status: str
    truth: NotRequired[Record]
    answer: NotRequired[AnswerRow]
    score: NotRequired[Score]
    refinement: NotRequired[Refinement]
    error: NotRequired[str]
    where: NotRequired[str]
    t_make: NotRequired[float]
    t_diagnose: NotRequired[float]
    t_refine: NotRequired[float]


def begun(case: Case, status: str) -> Line:
    """Return the line of a case without an answer."""
    return {"id": case.id, "case": cast(CaseRow, asdict(case)), "status": status}
