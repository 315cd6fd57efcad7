"""Answers to the campaigns of two benchmarks of other authors: what the confidence is fitted to beside the prior, and judged by.

Each benchmark has cases for development and cases kept apart; the confidence is fitted to the first only.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypedDict

from friction_models.common import InputError, write_json
from friction_models.discovery import diagnose
from friction_models.discovery.answer.diagnosis import Diagnosis

from ..blind.build import build
from ..blind.cases import all_cases
from ..blind.judge import judge
from ..blind.record import said
from ..data import sources
from ..literature.answers import read, score
from ..literature.build import make
from ..literature.collection import cases
from ..literature.page import ids_apart


class Task(NamedTuple):
    """A campaign of another author: its name, whether it is kept apart, what diagnoses it, and whether an answer is right."""

    source: str
    name: str
    apart: bool
    ask: Callable[[], tuple[Diagnosis, bool | None]]


class Judged(TypedDict, total=False):
    """Whose campaign was answered, the verdict with the grounds of its confidence, and whether it is right.

    A table that was refused has no verdict; `right` is None there, and where no single answer is right.
    """

    source: str
    verdict: str
    grounds: dict[str, float]
    right: bool | None


def tasks() -> Iterator[Task]:
    """Yield the campaigns of the literature benchmark and of the blind benchmark."""
    apart = ids_apart()
    for case in cases():

        def of_literature(case: Any = case) -> tuple[Diagnosis, bool | None]:
            made = make(case)
            found = diagnose(made.data, tests=made.tests, model="linear")
            return found, score(case, read(found))["right"]

        yield Task("literature", case.id, case.id in apart, of_literature)
    for made_up in all_cases():

        def of_blind(made_up: Any = made_up) -> tuple[Diagnosis, bool | None]:
            built = build(made_up)
            found = diagnose(built.points, tests=built.tests, model=built.model)
            return found, judge(made_up, said(found), built.truth).right

        yield Task("blind", made_up.name, made_up.half == "b", of_blind)


def rows_of_others(folder: Path, apart: bool) -> list[Judged]:
    """Return verdict, grounds and rightness of the cases kept apart, or of the others; those that the same code gave are read.

    Tables that are refused, and cases without a single right answer, are left out.
    """
    kept = folder / "others" / sources("friction_models")
    kept.mkdir(parents=True, exist_ok=True)
    rows: list[Judged] = []
    for task in tasks():
        if task.apart != apart:
            continue
        path = kept / f"{task.source}-{task.name}.json"
        if not path.exists():
            write_json(path, _row(task))
        row = json.loads(path.read_text(encoding="utf-8"))
        if row["right"] is not None:
            rows.append(row)
    return rows


def _row(task: Task) -> Judged:
    try:
        found, right = task.ask()
    except InputError:
        return {"source": task.source, "right": None}
    return {
        "source": task.source,
        "verdict": found.verdict,
        "grounds": found.grounds,
        "right": None if right is None else bool(right),
    }
