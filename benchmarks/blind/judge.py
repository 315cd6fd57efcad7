"""Judges one answer against the truth of its case."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.blind.cases import Case
from benchmarks.blind.record import Answer
from benchmarks.blind.truth import LawTruth, Truth

NAMING = ("explained", "ambiguous", "partly_explained", "data_problem")


@dataclass(frozen=True)
class Judged:
    """What an answer is worth; see README.md for the rules."""

    case: Case
    verdict: str
    effects: tuple[str, ...]
    rivals: tuple[str, ...]
    confidence: float
    sentence: str
    truth: Truth
    right: bool
    first: bool
    in_set: bool
    exact: bool
    wrong_names: tuple[str, ...]
    imitated: bool

    @property
    def visible(self) -> bool:
        """Whether an oracle sees at least one law."""
        return not self.truth["nothing"]

    @property
    def twin(self) -> bool:
        """Whether a hidden law has an inherent twin on this plan."""
        return any(law["twins"] for law in self.truth["laws"])


def _accepted(law: LawTruth) -> set[str]:
    return {*law["names"], *law["twins"]}


def judge(case: Case, said: Answer, known: Truth | None) -> Judged:
    """Judge one answer; nothing is known of a case that was not built."""
    truth: Truth = known or {"laws": [], "merged": {}, "nothing": case.kind == "null"}
    verdict, laws = said["verdict"], truth["laws"]
    effects = tuple(said["effects"] or ()) if verdict in NAMING else ()
    rivals = tuple(said["confusion_set"] or ()) if verdict in NAMING else ()
    visible = [law for law in laws if law["visible"]]
    outside = case.kind == "outside"
    allowed: set[str] = set().union(*(_accepted(law) for law in laws)) if laws else set()
    partial: set[str] = set().union(*(law["partial"] for law in laws)) if laws else set()
    merged = set(truth["merged"])
    wrong = tuple(
        e
        for e in effects
        if e not in allowed | merged | (partial if verdict == "partly_explained" else set())
    )
    two = truth.get("imitation") or {"hidden": False, "effects": []}
    imitated = bool(two["hidden"] and effects) and set(effects) <= set(two["effects"])
    if imitated:
        wrong = ()
    all_found = bool(effects) and all(_accepted(law) & set(effects) for law in visible)
    one_for_all = len(effects) == 1 and bool(merged & set(effects))
    exact = not wrong and (all_found or one_for_all)
    listed = set(effects) | set(rivals)
    nothing_right = truth["nothing"]
    if verdict == "nothing_missing":
        right = nothing_right
    elif verdict == "explained":
        right = exact and bool(laws)
    elif verdict == "partly_explained":
        right = (
            bool(effects) and not wrong and (outside or any(_accepted(law) & set(effects) for law in laws))
        )
    elif verdict == "ambiguous":
        right = bool(laws) and (all((_accepted(law) | merged) & listed for law in (visible or laws)))
    elif verdict == "unknown_structure":
        right = outside and not nothing_right
    elif verdict == "data_problem":
        spoilt = not effects and case.noise in ("spikes", "odd_tests")
        right = exact and bool(laws) if effects else spoilt
    else:
        right = False
    right = right or imitated
    first = bool(effects) and any(effects[0] in _accepted(law) for law in laws)
    in_set = bool(laws) and all(set(law["names"]) & listed for law in (visible or laws))
    return Judged(
        case,
        verdict,
        effects,
        rivals,
        float(said["confidence"] or 0.0),
        said["sentence"],
        truth,
        right,
        first,
        in_set,
        exact,
        wrong,
        imitated,
    )
