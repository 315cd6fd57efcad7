"""Laws of single levels beside an answer: where the tests of a coating or batch follow one of their own, something is left.

The noise of few such tests hides it from the flexible reference, which has to find all products of loads and columns at once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.search.structure import places_of
from ...loads import FloatArray
from ..judge.confirmation import EXPLAINED, Confirmation
from ..judge.error_budget import fall, interval_of
from ..judge.unseen_tests import errors_of_tests
from .own_laws import own_law

#: Verdicts that may say that nothing is left, or not where.
ASKED = ("nothing_missing", "explained", "ambiguous", "partly_explained")


def beside_levels(confirmed: Confirmation, campaign: BinnedTests, residual: FloatArray) -> Confirmation:
    """Return an answer, or what is left of it where the tests of a level follow a law of their own.

    `residual`, shape (m,), is what a fit to all tests leaves in the bins.
    """
    shares = confirmed.shares
    told = confirmed.verdict == "partly_explained" and confirmed.where
    if shares is None or confirmed.verdict not in ASKED or told:
        return confirmed
    if (law := own_law(campaign, residual)) is None:
        return confirmed
    before, after = (errors_of_tests(campaign, r) for r in (residual, residual - law.predicted))
    gain, certain = fall(before, after)
    best = shares.named * after.total / float(np.mean(before.total))
    if gain <= 0.0:
        return confirmed
    if float(np.mean(best)) < shares.best:
        shares = replace(
            shares, best=float(np.mean(best)), certainty=certain, interval=interval_of(best), source="level"
        )
    verdict = confirmed.verdict
    if verdict == "nothing_missing":
        verdict = "unknown_structure"
    elif verdict == "explained" and shares.left > EXPLAINED:
        verdict = "partly_explained"
    where = confirmed.where or places_of(campaign, law.predicted, [law.column])
    said = f"the tests of {law.column} {law.level} change with {law.along} otherwise than all others"
    return replace(confirmed, verdict=verdict, shares=shares, where=where, beyond=law.predicted, own_law=said)
