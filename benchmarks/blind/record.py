"""What the file of a case holds: the truth, the answer of the diagnosis, and how long it took."""

from __future__ import annotations

from typing import TYPE_CHECKING, NotRequired, TypedDict

if TYPE_CHECKING:
    from benchmarks.blind.truth import Truth
    from friction_models.discovery import Diagnosis
    from friction_models.discovery.answer.findings import ErrorBudget, RankedEffect
    from friction_models.estimation.noise.noise_floor import NoiseFloorNumbers
    from friction_models.estimation.search.structure import StructurePlace


class Answer(TypedDict):
    """What was said; the judge reads the first five only."""

    verdict: str
    effects: list[str]
    confusion_set: list[str]
    confidence: float
    sentence: str
    where: NotRequired[list[StructurePlace]]
    error_budget: NotRequired[ErrorBudget]
    noise_floor: NotRequired[NoiseFloorNumbers]
    warnings: NotRequired[list[str]]
    ranking: NotRequired[list[RankedEffect]]
    grounds: NotRequired[dict[str, float]]


class Record(TypedDict):
    """A case that was diagnosed; a case that crashed or took too long has no truth."""

    name: str
    truth: Truth | None
    answer: Answer
    seconds: float


def said(found: Diagnosis) -> Answer:
    """Return what a diagnosis said, with the best of its ranking."""
    return {
        "verdict": found.verdict,
        "effects": found.effects,
        "confusion_set": found.confusion_set,
        "confidence": found.confidence,
        "sentence": found.sentence,
        "where": found.where,
        "error_budget": found.error_budget,
        "noise_floor": found.noise_floor,
        "warnings": found.warnings,
        "ranking": found.ranking[:6],
        "grounds": found.grounds,
    }


def no_answer(verdict: str, sentence: str) -> Answer:
    """Return what stands for an answer that did not come: it counts as sure, and wrong."""
    return {"verdict": verdict, "effects": [], "confusion_set": [], "confidence": 1.0, "sentence": sentence}
