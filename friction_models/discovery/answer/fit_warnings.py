"""Warnings about fitted parameters: what of them is not known."""

from __future__ import annotations

import numpy as np

from ...estimation.campaign.binning import BinnedTests
from ...estimation.fit.parameters import FittedTerms
from ...estimation.search.zero_reading import share_of_mu

#: A fault of the data that makes more than this share of the measured mu of a test is worth a look at the rig.
LARGE_FAULT = 0.1


def about_the_fit(campaign: BinnedTests, fitted: FittedTerms) -> list[str]:
    """Return warnings about parameters at bounds, pairs that the data tie to each other, and sizes that are not known."""
    at_bounds = [
        f"{term.name}: the fit drives {name} to {term.shape[name]:.4g}, the bound of what is allowed: the law may have another form, and "
        "the intervals of its parameters hold for this value only"
        for term in fitted.terms
        for name in term.at_bounds
    ]
    tied = [
        f"the data tie {first} to {second} (correlation {value:+.2f}): each alone is poorly known"
        for first, second, value in fitted.correlations[:3]
    ]
    highest = float(np.max(campaign.average(campaign.mu)))
    opposed = [
        f"{term.name} contributes up to {largest:.2g}, more than the largest mu ({highest:.2g}): model and effect make up for each other "
        "there, and only their sum is known"
        for term in fitted.terms
        if (largest := float(np.max(np.abs(term.binned)))) > highest
    ]
    faults = [
        f"{term.name} makes up to {np.max(np.abs(term.binned)):.2g} of mu, and {100 * share:.0f} % of what one test measured: `refine` takes it off "
        "the measurements, so if it is no fault the law gets worse by that; check it on the rig first"
        for term in fitted.terms
        if term.effect.kind == "fault" and (share := share_of_mu(campaign, term.binned)) > LARGE_FAULT
    ]
    unsized = [
        f"{term.name}: the interval of {a.name} ({low:.2g} to {high:.2g}) holds both signs: that the effect is there is known, its size is not"
        for term in fitted.terms
        for a in term.effect.amplitudes
        if a.sign and a.name in term.intervals
        for low, high in [term.intervals[a.name]]
        if low < 0.0 < high
    ]
    return at_bounds + tied + opposed + faults + unsized
