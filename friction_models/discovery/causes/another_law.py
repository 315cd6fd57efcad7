"""Names that draw another law than theirs."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.fit.parameters import FittedTerm, FittedTerms
from ...estimation.search.law_signs import imitates, turns


def draws_another_law(campaign: BinnedTests, fitted: FittedTerms, sharper: Collection[str]) -> bool:
    """Return whether a name, or rivals of it, draws another law along its load by cancelling slopes of the base; not one that is `sharper`,
    unless it is the only name of its load and mu as a whole turns.

    Where several names are left, which of them is right may be open; that mu as a whole goes the other way is not.
    """
    if not fitted.terms:
        return False
    base = fitted.base(campaign)
    return any(
        (term.name not in sharper and imitates(campaign, term.effect, base, term.binned, sure=True))
        or (_alone(term, fitted.terms) and turns(campaign, term.effect, base, term.binned))
        for term in fitted.terms
    )


def _alone(term: FittedTerm, terms: Sequence[FittedTerm]) -> bool:
    """Return whether no other effect shares a load with one."""
    own = {*term.effect.driver}
    return all(own.isdisjoint(other.effect.driver) for other in terms if other is not term)
