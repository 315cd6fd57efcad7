"""A law of several loads beside two laws of one load each: which of them unseen tests prefer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

from ....estimation.search.importance import LEAST_SHARE
from ....estimation.search.scan import Fit
from ..beside_reference import effects_of
from ..error_budget import fall
from .names import BETTER, CERTAIN, Names
from .rivals import APART


@dataclass(frozen=True)
class TwoLoads:
    """Tries two laws of one load each in place of one of several loads.

    A product of two laws rises and falls with both loads, as their sum does: the scan, which adds one effect at a time, finds the
    product first even where the sum is true.
    """

    names: Names

    def parted(self, kept: list[Fit]) -> list[Fit]:
        """Return the names with a law of several loads exchanged for two of one load that unseen tests clearly prefer.

        One of one load, beside a name for the others, needs less: it is no longer an answer than the law of several.
        """
        for fit in kept:
            for instead in self._instead(kept, fit):
                needed = CERTAIN if len(instead) > len(kept) else BETTER
                if self._certainty(kept, instead) > needed:
                    return self.names.needed(instead)
        return kept

    def as_good(self, kept: Sequence[Fit]) -> dict[str, tuple[str, ...]]:
        """Return the names in whose place two laws of one load each predict unseen tests no worse, and these two."""
        known = {f.name for f in kept}
        best = {
            fit.name: min(
                self._instead(kept, fit), key=lambda fits: self.names.straight.errors(fits).rms, default=[]
            )
            for fit in kept
        }
        return {
            name: tuple(f.name for f in instead if f.name not in known)
            for name, instead in best.items()
            if instead and self._certainty(kept, instead) > 0.0
        }

    def not_of_all(self, kept: Sequence[Fit]) -> set[str]:
        """Return the names that need several loads, of which unseen tests miss one no more than its mean, though no effect is that law of the others.

        Friction that rises with pressure is no breakdown of hot films, though one that hardly feels the temperature rises as well.
        """
        return {f.name for f in kept if any(self._needless(kept, f, load) for load in self._needed(f))}

    def _needless(self, kept: Sequence[Fit], fit: Fit, load: str) -> bool:
        """Return whether a name predicts unseen tests as well without a load, and better than all effects of its other loads do."""
        straight, beside = self.names.straight, [f for f in kept if f is not fit]
        held = straight.errors_with_held(fit, load, beside)
        if fall(held, straight.errors_of_form(fit, beside))[1] >= BETTER:
            return False
        left = {*self._loads(fit)} - {load}
        others = (
            f
            for f in self.names.found.ranking
            if f.effect.kind == "physics" and (own := {*self._loads(f)}) and own <= left
        )
        return all(fall(straight.errors_of_form(f, beside), held)[1] >= APART for f in others)

    def _needed(self, fit: Fit) -> list[str]:
        """Return the loads that an effect needs, where these are several, and that vary here."""
        needs = fit.effect.needs or ()
        return [d for d in self._loads(fit) if d in needs] if len(needs) > 1 else []

    def _instead(self, kept: Sequence[Fit], fit: Fit) -> list[list[Fit]]:
        """Return the names with the best laws of one load in place of one of several: one, if another name is of such a load, and two."""
        loads = self._loads(fit)
        if len(loads) < 2 or fit.effect.needs_state:
            return []
        known = {f.name for f in kept}
        others = [f for f in kept if f is not fit]
        of_load = [
            [f for f in self.names.found.ranking if f.name not in known and self._is_simple(f, load)]
            for load in loads
        ]
        half_stands = any(self._is_simple(f, load) for f in others for load in loads)
        one = [[f, *others] for fits in of_load for f in fits] if half_stands else []
        # the larger one first: both take the place of one name
        two = [
            [*sorted(pair, key=lambda f: -f.gain), *others]
            for some, more in combinations(of_load, 2)
            for pair in product(some, more)
        ]
        # with the shapes of the search, which are quick to try; the best ones are then refitted
        best = (
            min(sets, key=lambda fits: self.names.straight.errors(fits).rms, default=[])
            for sets in (one, two)
        )
        return [fits for fits in best if fits]

    def _certainty(self, kept: Sequence[Fit], instead: Sequence[Fit]) -> float:
        """Return the standard errors by which unseen tests prefer other names; 0 where they do not, or by too little to matter."""
        own, other = (self.names.unseen.errors(effects_of(fits)) for fits in (kept, instead))
        gain, certain = fall(own, other)
        return certain if gain > LEAST_SHARE * own.rms**2 else 0.0

    def _is_simple(self, fit: Fit, load: str) -> bool:
        """Return whether an effect is physics of one load that varies, without memory."""
        return self._loads(fit) == [load] and fit.effect.kind == "physics" and not fit.effect.needs_state

    def _loads(self, fit: Fit) -> list[str]:
        """Return the loads that drive an effect and vary here."""
        varied = self.names.unseen.campaign.varied
        return [d for d in dict.fromkeys(fit.effect.driver) if d in varied]
