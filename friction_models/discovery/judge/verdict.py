"""The verdict of the scan: one of a closed set, from significance, size, rivals and what is left over.

Unseen tests may change it (`unseen_tests_judge.py`), and so may the level of a model as it is (`assembly.py`); they alone say `partly_explained`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...estimation.search.importance import LEAST_SHARE
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...estimation.search.structure import Misfit, Structure

#: Family-wise level at which an effect counts as present.
LEVEL = 0.05
#: The same for a second effect, sought beside the first one's loads freed as curves.
SECOND_LEVEL = 0.0125
#: An effect must explain this share of all structure, else something else is missing.
EXPLAINS = 0.8
#: The same for effects with memory: laws of memory differ more in their formulas than laws of the loads.
EXPLAINS_MEMORY = 0.69
#: The same along its own loads, where less noise blurs the answer: more than this left, and its form is another one.
BENT = 0.17
BENT_MEMORY = 0.31
#: Whitened squared misfit that is needed to judge a form.
SEEN = 30.0
#: Structure beside an effect matters from this share of the effect's own part on.
BESIDE = 0.25
#: Level for structure beyond the catalogue.
STRUCTURE_LEVEL = 0.01


@dataclass(frozen=True)
class Evidence:
    """What the verdict is drawn from."""

    found: SearchRound
    winner: Fit | None
    p_value: float
    share: float  #: Share of the squared error that the winner carries.
    confusion_set: list[str]
    misfit: Misfit  #: Along the winner's own loads, beyond its form.
    structure: Structure  #: Beyond base and winner (beyond the base where no effect stands out).
    structure_share: float  #: Share of the squared error in it.
    outside: float  #: Share of the points outside the model's domain.

    @property
    def present(self) -> bool:
        """Whether the winner is significant and large enough to matter."""
        return self.winner is not None and self.p_value < LEVEL and self.share > LEAST_SHARE

    @property
    def bent(self) -> bool:
        """Whether the residual bends along the loads of the winner: what is missing has another form."""
        winner, excess = self.winner, self.misfit.excess
        if winner is None or not self.present or self.misfit.p_value >= STRUCTURE_LEVEL or excess <= SEEN:
            return False
        memory = winner.effect.needs_state
        return excess / (winner.gain + excess) > (BENT_MEMORY if memory else BENT)

    @property
    def unexplained(self) -> bool:
        """Whether structure is left that matters."""
        winner = self.winner
        named = winner is not None and self.present
        memory = winner is not None and winner.effect.needs_state
        if self.bent:
            return True
        matters = min(LEAST_SHARE, BESIDE * self.share) if named else LEAST_SHARE
        if self.structure.p_value >= STRUCTURE_LEVEL or self.structure_share <= matters:
            return False
        if winner is None or not named:
            return True
        share = winner.gain / (winner.gain + self.structure.excess)
        return share < (EXPLAINS_MEMORY if memory else EXPLAINS)


def decide(evidence: Evidence, kinds: Mapping[str, str]) -> str:
    """Return the verdict; `kinds` holds the kind of each effect (`physics`, `system`, `fault`).

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> found = SimpleNamespace(outside=0.0, unexplained=False, present=True, confusion_set=["stribeck", "viscous"])
    >>> decide(found, {"stribeck": "physics", "viscous": "physics"})
    'ambiguous'
    """
    if evidence.outside > 0.5:
        return "out_of_domain"
    if evidence.unexplained:
        return "unknown_structure"
    if not evidence.present:
        return "nothing_missing"
    return named_verdict(evidence.confusion_set, kinds)


def named_verdict(confusion: Sequence[str], kinds: Mapping[str, str]) -> str:
    """Return the verdict where an effect is there, which cannot be told from the others of `confusion`.

    Examples
    --------
    >>> named_verdict(["force_zero"], {"force_zero": "fault"})
    'data_problem'
    """
    if confusion and all(kinds[n] == "fault" for n in confusion):
        return "data_problem"
    return "ambiguous" if len(confusion) > 1 else "explained"
