"""What is asked of a table and what was answered: the entries of ``answers.yaml``, and the kept files."""

from __future__ import annotations

from typing import Literal, NotRequired, TypedDict

#: Lists of answers that are not wrong, the better one first.
LISTS: tuple[Literal["acceptable", "debatable"], ...] = ("acceptable", "debatable")


class Answer(TypedDict, total=False):
    """What the diagnosis says of a table: ``status`` is ``answered``, ``refused`` or ``crashed``.

    ``said`` is always there, ``where`` after a crash, the rest with an answer.
    """

    status: str
    said: str
    where: str
    verdict: str
    effects: list[str]
    confusion_set: list[str]
    confidence: float
    warnings: list[str]
    budget: dict[str, float]
    mean_square: float
    plain_mean_square: float
    seconds: float


class Entry(TypedDict):
    """One answer of a list: `grade.matches` says when it is met; a wrong one has names and a reason."""

    verdict: str
    all_of: NotRequired[list[str]]
    any_of: NotRequired[list[str]]
    only_from: NotRequired[list[str]]
    names: NotRequired[list[str]]
    because: NotRequired[str]


class Lists(TypedDict):
    """By what an answer is graded."""

    acceptable: list[Entry]
    debatable: list[Entry]
    wrong: list[Entry]


class Call(TypedDict):
    """Which function of `tables` makes the table."""

    function: str
    arguments: dict[str, str | float]


class Wanted(Lists):
    """What is expected of a set."""

    call: Call
    because: list[str]
    confidence_at_most: NotRequired[float]
    must_warn: NotRequired[str]


class Result(TypedDict):
    """A set with its answer and grade, and its answers after each change."""

    name: str
    call: Call
    description: str
    tests: int
    points: int
    answer: Answer
    grade: str
    changed: dict[str, Answer]
