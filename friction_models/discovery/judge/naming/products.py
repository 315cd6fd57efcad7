"""A law of several loads beside the plain product of two of them: which of them unseen tests prefer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from ....estimation.search.importance import LEAST_SHARE
from ....estimation.search.scan import Fit
from ..beside_reference import effects_of
from ..error_budget import fall
from ..unseen_tests import UnseenTests
from .names import BETTER, CERTAIN
from .straight_fits import StraightFits

#: A product that leaves less than this share of what an effect changes is the same as the effect in these tests.
SAME_FORM = 0.01


@dataclass(frozen=True)
class Products:
    """Tries the plain product of two loads in place of a law of several.

    Friction that rises where both loads are high and where both are low is none of these laws, but the foot of one, beside
    slopes of the model that cancel most of it, draws that product, too.
    """

    unseen: UnseenTests
    straight: StraightFits

    def better(self, kept: Sequence[Fit]) -> set[str]:
        """Return the names in whose place unseen tests clearly prefer a product."""
        return {f.name for f in kept if self._best(kept, f)[0] > CERTAIN}

    def as_good(self, kept: Sequence[Fit]) -> dict[str, tuple[str, str]]:
        """Return the names in whose place a product predicts unseen tests better, if not for certain, and its loads.

        In the place of several names it need not be better: it is the simpler answer. Nor where it draws the same in these tests: two
        levels of each load show no other form.
        """
        found = {}
        for fit in kept:
            certain, loads = self._best(kept, fit)
            apart = [f for f in kept if {*loads}.isdisjoint(f.effect.driver)]
            same = bool(loads[0]) and self.straight.left_by_product(fit, loads) < SAME_FORM
            several = len(apart) < len(kept) - 1
            if certain >= BETTER or same or (several and self._best([fit, *apart], fit, than=kept)[0] > 0.0):
                found[fit.name] = loads
        return found

    def _best(
        self, kept: Sequence[Fit], fit: Fit, than: Sequence[Fit] | None = None
    ) -> tuple[float, tuple[str, str]]:
        """Return by how many standard errors unseen tests prefer the best product of loads of an effect, and these loads.

        To the effect with the shapes of the search, and refitted: what the one does badly, the other may do well. Others stay beside
        the product; it is compared with all names of `than`, by default with these.
        """
        loads = [d for d in dict.fromkeys(fit.effect.driver) if d in self.unseen.campaign.varied]
        if fit.effect.needs_state or len(loads) < 2:
            return 0.0, ("", "")
        beside = [f for f in kept if f is not fit]
        named = kept if than is None else than
        others = [f for f in named if f is not fit]
        forms = self.straight.errors_of_form(fit, others), self.unseen.errors(effects_of(named))
        pairs = {pair: self.straight.errors_of_product(pair, beside) for pair in combinations(loads, 2)}
        best = min(pairs, key=lambda pair: pairs[pair].rms)
        falls = [fall(form, pairs[best]) for form in forms]
        matters = all(gain > LEAST_SHARE * form.rms**2 for (gain, _), form in zip(falls, forms, strict=True))
        return min(certain for _, certain in falls) if matters else 0.0, best
