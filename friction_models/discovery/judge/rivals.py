"""Effects that these tests cannot tell from what is named, and which of the names leads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...estimation.campaign.binning import BinnedTests
from ...estimation.search.rivalry import rivalry
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...estimation.search.unseen_loads import AS_GOOD
from .error_budget import fall
from .unseen_tests import StraightFits

#: An effect must beat what could stand in its place by so many standard errors on unseen tests.
APART = 1.7
#: Share of the gain of the first effect below which another one is no rival.
WORTH = 0.25
#: A rival of at least this share of the gain of the first effect stays where the tests do not prefer the first by so many
#: standard errors, formulas being as wrong as the leads of single tests show.
AS_LIKELY, AGREED = 0.5, 1.0

#: Searches for further effects beside those given; the best first.
Further = Callable[[Sequence[Fit]], list[Fit]]


@dataclass(frozen=True)
class Rivals:
    """Compares what is named with what could stand in its place."""

    campaign: BinnedTests
    found: SearchRound
    straight: StraightFits
    further: Further

    def of(self, kept: Sequence[Fit], missing: float) -> dict[str, list[str]]:
        """Return for each name the effects that would leave hardly more in its place, or that some tests prefer to it.

        The winner of the scan is named first. A lead below what is `missing`, though it can be predicted, may be a matter of formulas.
        """
        if not kept:
            return {}
        first, *others = kept
        names = {f.name for f in kept}
        own = self.straight.errors(kept)
        tried = [
            f
            for f in self.found.ranking
            if f.gain > WORTH * first.gain and f.name not in names and not self.found.just(first, f)
        ]
        found: dict[str, list[str]] = {f.name: [] for f in kept}
        for f in tried:
            instead = [f, *others]
            as_good = missing > 0.0 and (self.straight.errors(instead).rms ** 2 - own.rms**2 < missing)
            if as_good or (f.gain > AS_LIKELY * first.gain and not self._led(kept, instead)):
                found[first.name].append(f.name)
        for named in others:
            beside = [f for f in kept if f is not named]
            found[named.name] = [
                f.name
                for f in self.further(beside)
                if f.name not in names and not self._apart(kept, [*beside, f], beside, named, f)
            ]
        return found

    def _led(self, kept: Sequence[Fit], instead: Sequence[Fit]) -> bool:
        """Return whether the tests prefer some effects to others that differ in the first.

        With one mean a test, unseen tests are judged by all that the data hold, and have to prefer them as well.
        """
        lone = (kept[0], instead[0]) if len(kept) == 1 else ()
        if self.campaign.averaged and not self._apart(kept, instead, [], *lone):
            return False
        return rivalry(self.campaign, self.found, kept, instead).certainty >= AGREED

    def _apart(self, kept: Sequence[Fit], instead: Sequence[Fit], beside: Sequence[Fit], *forms: Fit) -> bool:
        """Return whether unseen tests prefer some effects to others; of averages also where they had no part in the choice of shapes.

        The `forms` are the named effect and its rival, that stand `beside` the same others.
        """
        if fall(self.straight.errors(instead), self.straight.errors(kept))[1] < APART:
            return False
        if not forms or not self.campaign.averaged:
            return True
        own, other = (self.straight.errors_of_form(f, beside) for f in forms)
        return fall(other, own)[1] >= APART

    def largest_first(self, kept: list[Fit]) -> list[Fit]:
        """Return the effects led by one that carries far more of the error on unseen tests than the first, if there is one."""
        if len(kept) < 2:
            return kept
        left = [self.straight.errors([g for g in kept if g is not f]).rms ** 2 for f in kept]
        carried = np.array(left) - self.straight.errors(kept).rms ** 2
        most = int(np.argmax(carried))
        if carried[0] > AS_GOOD * carried[most]:
            return kept
        return [kept[most], *(f for f in kept if f is not kept[most])]


def told(kept: Sequence[Fit], rivals: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Return the rivals of the first name; then further names, each with its own, where it has some."""
    first, *others = [f.name for f in kept] or [""]
    return (*rivals.get(first, ()), *(n for name in others if rivals[name] for n in (name, *rivals[name])))
