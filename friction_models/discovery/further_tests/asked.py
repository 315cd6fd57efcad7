"""What an answer leaves open: the questions that further tests are to settle, and how probable each answer is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...estimation.search.scan import Fit
from ...estimation.search.zero_reading import ZERO
from ..judge.confirmation import NAMED
from ..judge.judged import Judged, alternatives
from .questions import Answer, Question

#: Weight of "none of the catalogue" beside that of all its effects, and where something is left beside what is named.
NONE, NONE_BESIDE_PARTS = 0.1, 0.25


def answer_of(verdict: str, sure: float) -> Answer:
    """Return how probable an answer is, as further tests see it."""
    if verdict in NAMED:
        return Answer(sure, NONE_BESIDE_PARTS if verdict == "partly_explained" else NONE)
    if verdict == "unknown_structure":
        return Answer(None, sure)
    return Answer(None, NONE, 1.0 - sure)


def questions_of(judged: Judged, confusion: Sequence[str], unread: bool = False) -> list[Question]:
    """Return what further tests are to tell apart: alternatives only, each name from its own rivals, beside the other names.

    An offset of the force that is `unread` has rivals in the effects of pressure.
    """
    chosen = judged.chosen
    if len(chosen) < 2 or judged.beside is None:
        rivals = _to_separate(judged, confusion)
        alike = {*(confusion or judged.evidence.confusion_set)}
        return [Question(judged.found, rivals, len({f.name for f in rivals} & alike))]
    groups = alternatives([f.name for f in chosen], confusion)
    found = []
    for group in [g for g in groups if len(g) > 1 or (unread and g[0] == ZERO)] or groups[:1]:
        given = [f for f in chosen if f.name != group[0]]
        elsewhere = {n for g in groups if g is not group for n in g}
        beside = judged.beside(given)
        beside = replace(beside, ranking=[f for f in beside.ranking if f.name not in elsewhere])
        rivals = [f for n in group for f in beside.ranking if f.name == n]
        asked = unread and group[0] == ZERO  # also where nothing else explains anything
        others = [f for f in beside.ranking if f.name not in group and (asked or f.gain > 0.0)]
        asked_of = rivals if len(rivals) > 1 else [*rivals, *others[:1]]
        found.append(Question(beside, asked_of, len(rivals), given))
    return found


def _to_separate(judged: Judged, confusion: Sequence[str]) -> list[Fit]:
    """Return the effects that the next tests are to tell apart: rivals, or what is named and the next best."""
    ranking, chosen = judged.found.ranking, judged.chosen
    rivals = [f for n in confusion or judged.evidence.confusion_set for f in ranking if f.name == n]
    rivals = rivals or chosen[:1]
    if len(rivals) == 1 and len(confusion) < 2:
        rivals += [f for f in ranking if f.name != rivals[0].name and f.gain > 0][:1]
    if not rivals and judged.verdict == "unknown_structure":
        rivals = [f for f in ranking[:1] if f.gain > 0]
    return rivals
