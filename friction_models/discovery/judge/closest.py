"""The effect that would help most where none is named."""

from __future__ import annotations

from dataclasses import dataclass

from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from .confirmation import EXPLAINED
from .error_budget import helps
from .judged import Judged
from .verdict import LEVEL

#: So many of the ranking may come closest.
FIRST = 3


@dataclass(frozen=True)
class Closest:
    """What one effect would do on tests that no fit saw; errors are RMS of mu."""

    name: str
    before: float  #: Error of the model.
    after: float  #: Error with the effect.
    reachable: float  #: The least that is known to be reachable.
    fault: bool  #: Whether it is a fault of the data.

    @property
    def explains(self) -> bool:
        """Whether it leaves no more than a name that explains may."""
        return self.after**2 - self.reachable**2 <= EXPLAINED * (self.before**2 - self.reachable**2)


def first_seen(found: SearchRound) -> list[Fit]:
    """Return the `FIRST` significant effects of the ranking that are no fault of the data."""
    return [f for f in found.ranking if f.effect.kind != "fault" and found.p_value(f) < LEVEL][:FIRST]


def closest_of(judged: Judged) -> Closest | None:
    """Return the effect of the column along which most is left, or the best of `first_seen`.

    None where effects are named, nothing is missing, or it would not help.
    """
    unseen, shares, ranking = judged.unseen, judged.confirmed.shares, judged.found.ranking
    if judged.verdict != "unknown_structure" or unseen is None or shares is None:
        return None
    along = [place["variables"] for place in judged.confirmed.where[:1]]
    of_column = [f for f in ranking if [*f.effect.metadata] in along][:1]
    seen = first_seen(judged.found)
    before = unseen.errors()
    errors = {f.name: unseen.errors([f.effect]) for f in of_column or seen}
    fit = min(of_column or seen, key=lambda f: errors[f.name].rms, default=None)
    if fit is None or not helps(before, errors[fit.name]):
        return None
    after = errors[fit.name].rms
    return Closest(fit.name, before.rms, after, min(shares.best**0.5, after), fit.effect.kind == "fault")
