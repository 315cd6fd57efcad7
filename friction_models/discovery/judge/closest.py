"""The effect that would help most where none is named."""

from __future__ import annotations

from dataclasses import dataclass

from .confirmation import EXPLAINED
from .error_budget import helps
from .judged import Judged
from .verdict import LEVEL


@dataclass(frozen=True)
class Closest:
    """What one effect would do on tests that no fit saw; errors are RMS of mu."""

    name: str
    before: float  #: Error of the model.
    after: float  #: Error with the effect.
    reachable: float  #: The least that is known to be reachable.
    fault: bool  #: Whether it is a fault of the data.

    @property
    def takes(self) -> float:
        """Share of the squared error that is known to be avoidable."""
        return (self.before**2 - self.after**2) / (self.before**2 - self.reachable**2)

    @property
    def explains(self) -> bool:
        """Whether it leaves no more than a name that explains may."""
        return self.takes >= 1.0 - EXPLAINED


def closest_of(judged: Judged) -> Closest | None:
    """Return the effect of the column along which most is left, or the first of the ranking that is no fault of the data.

    None where effects are named, nothing is missing, or it would not help.
    """
    unseen, shares, ranking = judged.unseen, judged.confirmed.shares, judged.found.ranking
    along = [place["variables"] for place in judged.confirmed.where[:1]]
    of_column = next((f for f in ranking if [*f.effect.metadata] in along), None)
    seen = (f for f in ranking if f.effect.kind != "fault" and judged.found.p_value(f) < LEVEL)
    first = of_column or next(seen, None)
    if judged.verdict != "unknown_structure" or unseen is None or shares is None or first is None:
        return None
    before, after = unseen.errors(), unseen.errors([first.effect])
    if not helps(before, after):
        return None
    reachable = min(shares.best**0.5, after.rms)
    return Closest(first.name, before.rms, after.rms, reachable, first.effect.kind == "fault")
