"""Which empirical terms are offered where structure is left that no effect of the catalogue explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import stdtrit

from ...common.wording import listed
from ...effects import empirical_effect
from ...effects.empirical.effect import numbered
from ...loads import FloatArray
from ..judge.error_budget import lead
from .fit import fit
from .missing import Missing
from .offers import FormulaOffer
from .pictures import term_curves
from .scan import Column
from .selection import CERTAIN, STABLE, Ranked, Selection

#: Most terms, or sums of terms, that are offered.
MOST = 3
#: An offer removes this share of what is missing at least.
LEAST_SHARE = 0.2
#: A stable term that lowers the error by so many standard errors where it is only fitted anew is offered also if the choice went astray
#: without some tests: these may be the only ones that show a peak.
CLEAR = 3.0
#: Further offers remove this share of what the first term removes, and come first in this share of the resamples.
COMPARABLE, LEAST_STABLE = 0.7, 0.15


def offers(missing: Missing, best: float) -> list[FormulaOffer]:
    """Return up to three empirical terms, or sums of them, that lower the error on unseen tests, the best first.

    `best` is the mean squared error of the best prediction that is known.
    """
    if (found := missing.selection) is None:
        return []
    # what was chosen from many looks too good on the tests it was chosen on: this is by how much
    flattered = found.errors.total - found.all.errors[-1].total
    best = min(best, float(np.mean(found.errors.total)))
    made = [_offer(missing, best, found.all.chosen, found.errors.total, min(found.stability))]
    if len(found.all.chosen) > 1:
        first = found.all.errors[1].total + flattered
        made.append(_offer(missing, best, found.all.chosen[:1], first, found.stability[0]))
    made += [
        _offer(missing, best, [r.column], r.errors.total + flattered, r.stability) for r in _others(found)
    ]
    clear = lead(found.all.errors[0].total, found.all.errors[1].total)[1] > CLEAR
    plain = len(found.all.chosen) == 1 and found.stability[0] >= STABLE and clear
    sure = [o for k, o in enumerate(made) if o.interval[0] > 0.0 or (plain and k == 0)]
    return [o for o in sure if o.share > LEAST_SHARE][:MOST]


def not_offered(missing: Missing) -> list[str]:
    """Return a remark on the terms that come nearest, where none lowers the error on unseen tests for certain."""
    if (found := missing.selection) is None:
        return []
    before, after = (float(np.sqrt(np.mean(e))) for e in (missing.before, found.errors.total))
    names = listed(empirical_effect(str(c.term))().name for c in found.all.chosen)
    if after >= before:
        return []
    return [
        f"no empirical term is offered: {names} would fit best, but chosen anew without the tests that are predicted, this lowers the error there from "
        f"{before:.4f} to {after:.4f}, which may be chance"
    ]


def _others(found: Selection) -> list[Ranked]:
    """Return terms with other loads or another kind of curve that are hardly worse than the first one."""
    without, first = (e.total for e in found.all.errors[:2])
    families = {found.all.chosen[0].term.family}
    chosen: list[Ranked] = []
    for r in found.rounds[0]:
        near = np.mean(without - r.errors.total) > COMPARABLE * np.mean(without - first)
        if r.term.family in families or not near or lead(r.errors.total, first)[1] > CERTAIN:
            continue
        families.add(r.term.family)
        if r.stability >= LEAST_STABLE:
            chosen.append(r)
    return chosen


def _offer(
    missing: Missing, best: float, columns: Sequence[Column], squares: FloatArray, stability: float
) -> FormulaOffer:
    """Return terms with what they take from the error of unseen tests.

    `squares`, shape (tests,), are mean squared errors of each test by terms that were chosen without it.
    """
    bins, effects = missing.bins, [empirical_effect(str(c.term))() for c in columns]
    start = [
        {n: float(g[0]) for n, g in e.grids(bins.spans).items()} | c.shape for e, c in zip(effects, columns)
    ]
    fitted = fit(bins, missing.whiten, effects, start)
    before = float(np.mean(missing.before))
    after = float(np.mean(squares))
    size = before - best
    gain, certain = lead(missing.before, squares)
    half = float(stdtrit(len(squares) - 1, 0.975)) * abs(gain) / max(abs(certain), 1e-300)
    low, share, high = (min(v / max(size, 1e-300), 1.0) for v in (gain - half, gain, gain + half))
    numbers = [
        numbered(e, {"a": float(a), **s})
        for e, s, a in zip(effects, fitted.shapes, fitted.amplitudes, strict=True)
    ]
    return FormulaOffer(
        name=listed(e.name for e in effects),
        equation="; ".join(numbers),
        share=share,
        interval=(low, high),
        stability=stability,
        effects=tuple(effects),
        rms=(before**0.5, after**0.5),
        shapes=tuple(fitted.shapes),
        curves=tuple(term_curves(bins, missing.whiten, effects, fitted)),
    )
