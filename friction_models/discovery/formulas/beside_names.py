"""Empirical terms beside what is named: where they predict unseen tests much better, the names are not the answer.

The flexible reference knows curves along each load and smooth products of them. A peak in one load whose place moves with another
one is neither; the grammar has terms of such forms.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...estimation.search.structure import places_of
from ..judge.confirmation import EXPLAINED, NOT_THE_ANSWER, Confirmation
from ..judge.error_budget import BELIEVED, ErrorShares, fall, interval_of, lead
from .missing import Missing
from .selection import STABLE, Selection


def beside_names(confirmed: Confirmation, missing: Missing) -> Confirmation:
    """Return an answer that names effects, or what is left of it where terms beside these predict unseen tests much better."""
    known = confirmed.shares
    # what the names leave is the most that terms can take
    if known is None or known.named <= NOT_THE_ANSWER * known.base or (found := _found(missing)) is None:
        return confirmed
    shares = _with_terms(known, found)
    if shares.left <= EXPLAINED or shares.best >= known.best:
        return confirmed
    unknown = shares.left > NOT_THE_ANSWER
    kept = [] if unknown else confirmed.chosen
    beyond = missing.unseen.residual([f.effect for f in kept]) - found.residual
    where = places_of(missing.campaign, beyond, [])
    if unknown:
        shares = replace(shares, named=shares.base)
        return Confirmation(
            "unknown_structure", shares=shares, where=where, beyond=beyond, repeats=confirmed.repeats
        )
    verdict = "partly_explained" if confirmed.verdict == "explained" else confirmed.verdict
    return replace(confirmed, verdict=verdict, shares=shares, where=where, beyond=beyond)


def _found(missing: Missing) -> Selection | None:
    """Return terms that predict unseen tests better than the names alone, for certain and in most resamples; None without any."""
    if (found := missing.stable_selection(STABLE)) is None:
        return None
    # the names with the shapes that all tests gave them, and refitted without each fold
    before = found.all.errors[0].total, missing.before
    sure = (lead(errors, found.errors.total, found.errors.setting)[1] for errors in before)
    return found if min(sure) > BELIEVED else None


def _with_terms(shares: ErrorShares, found: Selection) -> ErrorShares:
    """Return the budget with terms: they take the share of the error that they take where the names keep their shapes."""
    before, after = found.all.errors[0], found.errors
    best = shares.named * after.total / np.mean(before.total)
    return replace(
        shares,
        best=float(np.mean(best)),
        certainty=fall(before, after)[1],
        interval=interval_of(best),
        source="terms",
    )
