"""Empirical terms for one diagnosis: only for the verdicts that leave structure unexplained."""

from __future__ import annotations

import numpy as np

from ..estimation.campaign.binning import Campaign
from .assembly import Judged
from .formulas.offers import FormulaOffer
from .formulas.search import Missing, offers

#: Verdicts for which terms are sought.
UNEXPLAINED = ("unknown_structure", "partly_explained")


def formulas_for(verdict: str, campaign: Campaign, judged: Judged, seed: int) -> list[FormulaOffer]:
    """Return the terms that are offered beside what is named; none for other verdicts or with too few tests."""
    shares, unseen, found = judged.confirmed.shares, judged.unseen, judged.found
    if verdict not in UNEXPLAINED or shares is None or unseen is None:
        return []
    before = unseen.errors([f.effect for f in judged.chosen]).total
    missing = Missing(
        campaign=campaign,
        columns=np.column_stack([found.columns, *(f.columns for f in judged.chosen)]),
        y=found.y,
        whiten=found.whiten,
        fold_of_test=unseen.fold_of_test,
        before=before,
        best=shares.best,
        seed=seed,
        sloping=found.columns.shape[1] == 1,
    )
    return offers(missing)
