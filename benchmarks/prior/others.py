"""Answers to the campaigns of two benchmarks of other authors: what the confidence is fitted to beside the prior, and judged by.

Each benchmark has cases for development and cases kept apart; the confidence is fitted to the first only.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypedDict

from ..blind import runner
from ..blind.cases import all_cases
from ..blind.judge import judge
from ..blind.record import Record
from ..data import sources
from ..literature import cases, kept_file
from ..literature.judge import run
from ..literature.page import ids_apart
from ..literature.table import load

#: Processes and seconds a case of the blind benchmark.
WORKERS, LIMIT = 1, 240.0


class Judged(TypedDict):
    """Whose campaign was answered, the verdict, how sure it is and by what, and whether it is right."""

    source: str
    verdict: str
    confidence: float
    grounds: dict[str, float]
    right: bool


def row_of(source: str, answer: Mapping[str, Any], right: bool) -> Judged:
    """Return what the confidence is fitted to, and judged by, of an answer as its file keeps it."""
    return {
        "source": source,
        "verdict": answer["verdict"],
        "confidence": answer["confidence"],
        "grounds": answer["grounds"],
        "right": right,
    }


def rows_of_others(folder: Path, apart: bool) -> list[Judged]:
    """Return verdict, grounds and rightness of the cases kept apart, or of the others; those that the same code gave are read.

    Tables that are refused or have no answer, and cases without a single right answer, are left out.
    """
    return [*_literature(folder, apart), *_blind(folder, apart)]


def _literature(folder: Path, apart: bool) -> Iterator[Judged]:
    place, kept_apart = kept_file(folder / "literature"), ids_apart()
    place.parent.mkdir(parents=True, exist_ok=True)
    run([case for case in cases() if (case.id in kept_apart) == apart], place)
    for line in load([place]):
        if (line["id"] in kept_apart) == apart and line["status"] == "ok":
            answer, right = line["answer"], line["score"]["right"]
            if right is not None:
                yield row_of("literature", answer, right)


def _blind(folder: Path, apart: bool) -> Iterator[Judged]:
    place = folder / "blind" / sources("friction_models")
    chosen = [case for case in all_cases() if (case.half == "b") == apart]
    runner.run(chosen, place, WORKERS, LIMIT)
    for case in chosen:
        kept: Record = json.loads(runner.file_of(case, place).read_text(encoding="utf-8"))
        answer = kept["answer"]
        if answer.get("grounds") is not None:
            yield row_of("blind", answer, judge(case, answer, kept["truth"]).right)
