"""Names that only draw another law: beside the model's own slopes, beside one another, with fewer loads than they need, or their product."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ....estimation.campaign.binned_tests import BinnedTests
from ....estimation.search.law_signs import imitates
from ....estimation.search.scan import Fit
from ..beside_reference import effects_of
from ..error_budget import fall
from ..unseen_tests import UnseenTests
from .names import CERTAIN
from .products import Products
from .rivals import APART
from .straight_fits import StraightFits
from .two_loads import TwoLoads


@dataclass(frozen=True)
class OtherLaws:
    """Asks unseen tests whether names are more than what they draw."""

    campaign: BinnedTests
    unseen: UnseenTests
    straight: StraightFits
    two_loads: TwoLoads
    products: Products

    def among(self, kept: list[Fit], sure: bool) -> set[str]:
        """Return names that only draw another law: parts of a difference, or of several loads where fewer or their product do."""
        return self.cancelling(kept, sure) | self.two_loads.not_of_all(kept) | self.products.better(kept)

    def cancelling(self, kept: list[Fit], sure: bool) -> set[str]:
        """Return names that are no more than a part of a difference: only that is seen, a curve that they are not.

        Of several over one load, of which one rises and the other falls, none has a size that is known to differ from zero. Or one
        draws another law, by cancelling slopes of the model along its load, which counts sooner where the answer is `sure` of its name.
        """
        fitted = self.unseen.fitted(effects_of(kept))
        loads = [{*f.effect.driver} for f in kept]
        sharing = {
            f.name
            for k, f in enumerate(kept)
            if f.effect.kind != "fault" and any(loads[k] & other for j, other in enumerate(loads) if j != k)
        }
        unknown = {t.name for t in fitted.terms if not t.sized} & sharing
        drawn = {f.name for f, beside in self._imitating(kept, sure) if self._is_a_bend(f, beside)}
        return drawn | (unknown if len(unknown) > 1 else set())

    def sharper(self, kept: Sequence[Fit]) -> frozenset[str]:
        """Return the names that cancel slopes of the model, but that unseen tests prefer to all plain bends: their form turns mu."""
        found = set[str]()
        for fit, beside in self._imitating(kept, sure=True):
            parabola, bend = self._against_bends(fit, beside)
            if parabola > CERTAIN and bend > 0.0:
                found.add(fit.name)
        return frozenset(found)

    def _imitating(self, kept: Sequence[Fit], sure: bool) -> Iterator[tuple[Fit, list[Fit]]]:
        """Yield the names that may draw another law along their load, by cancelling slopes of the model, each with the others."""
        if not kept:
            return
        fitted = self.unseen.fitted(effects_of(kept))
        base = fitted.base(self.campaign)
        for fit, term in zip(kept, fitted.terms, strict=True):
            if imitates(self.campaign, fit.effect, base, term.binned, sure):
                yield fit, [f for f in kept if f is not fit]

    def _against_bends(self, fit: Fit, beside: Sequence[Fit]) -> tuple[float, float]:
        """Return by how many standard errors unseen tests prefer an effect to a parabola along its load, and to any plain bend."""
        form = self.straight.errors_of_form(fit, beside)
        parabola, bend = (
            fall(errors, form)[1] for errors in self.straight.errors_of_bends(fit.effect.driver[0], beside)
        )
        return parabola, bend

    def _is_a_bend(self, fit: Fit, beside: Sequence[Fit]) -> bool:
        """Return whether unseen tests prefer a plain bend to an effect that turns mu: another law, which the effect only imitates."""
        parabola, bend = self._against_bends(fit, beside)
        return parabola < 0.0 or bend < -APART
