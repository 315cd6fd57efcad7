"""What explains where no effect does as the search has it: sums, two laws along the distance, one that noise of few tests hides."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ....effects.base import Effect
from ....estimation.search.scan import Fit
from ....estimation.search.unseen_loads import own_load
from ..beside_reference import effects_of
from ..confirmation import EXPLAINED
from ..error_budget import helps
from ..verdict import LEVEL
from .names import ALONE, CLEAR, MOST_NAMED, RIVALS, Names, falls
from .rivals import APART

#: Effects from which a sum is grown before structure is called unknown.
LEADS = 3
#: Two effects along the distance leave less than this share of what can be predicted.
HARDLY_LEFT = 0.07
#: And less than this share of what one of them leaves.
LESS_LEFT = 0.6
#: More than this share of what is left is most of it: it lies along the load of the only name, which has another form, or along one column.
MOST_OF_THE_REST = 0.6
#: The first search, whose noise holds the effect, must say at least this; unseen tests must then be this certain.
MAYBE, CONFIRMED = 0.2, 1.7
#: What leaves less than this share of the squared error on unseen tests need not be as significant.
MOST = 0.5


@dataclass(frozen=True)
class Instead:
    """Tries what may explain in the place of names that do not."""

    names: Names

    def several(self, first: Fit) -> list[Fit]:
        """Return several effects that explain together: led by the first one, else two led by the one that fits best as it is."""
        grown = self.names.needed(self.names.grown([first], 2))
        if len(grown) > 1 and self.names.explain(grown):
            return grown
        # effects with memory take long to fit, and hold simpler ones
        plain = [f for f in self.names.found.ranking if not f.effect.needs_state]
        best = max(plain, key=lambda f: f.gain, default=first)
        if best.name == first.name or not self.names.adds([], best):
            return []
        grown = self.names.needed(self.names.grown([best], 2, most=2))
        return grown if len(grown) > 1 and self.names.explain(grown) else []

    def together(self) -> list[Fit]:
        """Return effects of different loads that explain together, each missed where it is left out, if there are some.

        What others leave between tests hides each of them: none lowers the error for certain before all are there.
        """
        leads: dict[str, Fit] = {}
        for fit in self.names.found.ranking[: 2 * RIVALS]:
            load = own_load(fit.effect)
            if fit.effect.kind != "fault" and not (load and fit.effect.needs_state):
                leads.setdefault(load[0] if load else fit.name, fit)
        sums: dict[frozenset[str], list[Fit]] = {}
        for lead in [*leads.values()][:LEADS]:
            fits = self._sum(lead)
            sums.setdefault(frozenset(f.name for f in fits), fits)
        fits = min(sums.values(), key=lambda fits: self.names.straight.errors(fits).rms, default=[])
        alone = self.names.beside.shares([])
        # refits take long: with the shapes of the search, which saw all tests, what explains leaves as little
        if (
            len(fits) < 2
            or self.names.straight.errors(fits).rms ** 2 - alone.best > EXPLAINED * alone.missing
        ):
            return []
        needed = self.names.needed(fits) if self.names.explain(fits) else []
        return needed if len(needed) > 1 and self.names.explain(needed) else []

    def alone(self) -> list[Fit]:
        """Return the effect of the first ones of the ranking that explains by itself what unseen tests show and the search does not.

        The noise of few tests holds what is missing: beside three loads at three levels each, nine tests leave two numbers for it.
        """
        tried = [f for f in self.names.found.ranking[: RIVALS + 1] if f.effect.kind != "fault"]
        errors = {f.name: self.names.unseen.errors(effects_of([f])) for f in tried}
        best = min(tried, key=lambda f: errors[f.name].rms, default=None)
        if best is None or not falls(self.names.beside.without_names, errors[best.name], APART):
            return []
        return [best] if self.names.explain([best]) else []

    def along_the_distance(self) -> list[Fit]:
        """Return two effects along the distance that leave next to nothing, one falling and one rising, each missed for certain, if there are some.

        Friction falls while surfaces run in and rises when they wear, in the same tests: each alone bends otherwise than what is
        there, and free curves along the distance would hide one beside the other. Along a load, two such laws would be a window.
        """
        plain = [f for f in self.names.found.ranking[: RIVALS + 1] if along_the_distance(f.effect)]
        pairs = map(list, combinations(plain, 2))
        # refitted: shapes of the search are those of effects that stand alone
        pair = min(pairs, key=lambda fits: self.names.unseen.errors(effects_of(fits)).rms, default=[])
        if not pair or (left := self.names.beside.shares(pair).left) > HARDLY_LEFT:
            return []
        if left > LESS_LEFT * min(self.names.beside.shares([fit]).left for fit in pair):
            return []  # the second one only mends the form of the first
        after = self.names.unseen.errors(effects_of(pair))
        if any(self.names.missed([fit], after) < ALONE for fit in pair):
            return []
        # of two that both fall, one only mends the form of the other
        one, other = (t.binned for t in self.names.unseen.fitted(effects_of(pair)).terms)
        return pair if float(np.cov(one, other)[0, 1]) < 0.0 else []

    def levels(self) -> list[Fit]:
        """Return the effect of a column of the test table that makes most of what is left, if unseen tests confirm it."""
        found = [p["variables"] for p in self.names.beside.places([]) if p["share"] > MOST_OF_THE_REST]
        fits = [
            f for f in self.names.found.ranking if [*f.effect.metadata] in found and f.effect.kind != "fault"
        ]
        before = self.names.beside.without_names
        return [f for f in fits[:1] if falls(before, self.names.unseen.errors(effects_of([f])), CONFIRMED)]

    def overlooked(self) -> Fit | None:
        """Return an effect that is significant once the noise is judged beside it, and that unseen tests confirm clearly."""
        if self.names.found.least_p >= MAYBE:
            return None
        before = self.names.beside.without_names
        for fit in self.names.found.ranking[:2]:
            if (p := self.names.found.own_p_value(fit)) >= LEVEL:
                continue
            after = self.names.unseen.errors(effects_of([fit]))
            if (p < CLEAR or after.rms**2 < MOST * before.rms**2) and falls(before, after, CONFIRMED):
                return fit
        return None

    def _sum(self, lead: Fit) -> list[Fit]:
        """Return an effect with the best ones of other loads, while they lower the error with the shapes of the search."""
        fits = [lead]
        while len(fits) < MOST_NAMED:
            loads = {d for f in fits if own_load(f.effect) for d in f.effect.driver}
            other = [
                f
                for f in self.names.further(fits)
                if f.effect.kind != "fault" and loads.isdisjoint(f.effect.driver)
            ]
            best = min(other, key=lambda f: self.names.straight.errors([*fits, f]).rms, default=None)
            if best is None or not helps(
                self.names.straight.errors(fits), self.names.straight.errors([*fits, best])
            ):
                break
            fits.append(best)
        return fits


def along_the_distance(effect: Effect) -> bool:
    """Return whether an effect is a curve along the distance, without memory."""
    return effect.driver == ("sd",) and not effect.needs_state
