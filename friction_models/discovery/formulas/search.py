"""Which empirical terms are offered where structure is left that no effect of the catalogue explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.stats import t as student

from ...effects.empirical import numbered
from ...effects.empirical_terms import Term
from ...estimation.campaign.binning import Campaign
from ...estimation.noise.noise_floor import Whitener
from ...loads import LOAD_NAMES, FloatArray
from ..error_budget import lead
from .fit import Fitted, Weigh, fit
from .grammar import terms
from .offers import FormulaOffer
from .scan import Bins, Scan, Scanned

#: Fewest tests from which terms are chosen.
LEAST_TESTS = 8
#: Most terms that are offered.
MOST = 3
#: An offer removes this share of what is missing at least, by this many standard errors over the tests.
LEAST_SHARE, CERTAIN = 0.2, 2.0
#: Further offers remove this share of what the first one removes, and come first in this share of the resamples.
COMPARABLE, LEAST_STABLE = 0.7, 0.15
#: Terms that remove this share of what the best one removes are ordered by their stability.
NEAR = 0.9
#: A simpler term is taken if the better one leads by less than this many standard errors and this share of its gain.
NO_LEAD, NO_GAIN = 1.0, 0.03
#: A second term is sought if the first one leaves this share, and taken if it removes this share more and is this stable.
LEFT, SECOND, SECOND_STABLE = 0.2, 0.08, 0.2


@dataclass
class Missing:
    """What is missing, as unseen tests show it.

    Attributes
    ----------
    campaign : Campaign
        As it was searched.
    columns : ndarray, shape (m, p)
        The model and what is named, in the bins.
    y : ndarray, shape (m,)
        Bin means of mu without the fixed part of the model.
    whiten : Whitener
    fold_of_test : ndarray of int, shape (tests,)
    before : ndarray, shape (tests,)
        Mean squared error of each unseen test of the model with what is named.
    best : float
        Mean squared error of the best prediction that is known.
    seed : int
    sloping : bool
        Whether the model has no slopes, so that terms keep theirs.
    """

    campaign: Campaign
    columns: FloatArray
    y: FloatArray
    whiten: Whitener
    fold_of_test: npt.NDArray[np.intp]
    before: FloatArray
    best: float
    seed: int = 0
    sloping: bool = False

    @property
    def size(self) -> float:
        """What can be predicted and is not."""
        return float(np.mean(self.before)) - self.best


def offers(missing: Missing) -> list[FormulaOffer]:
    """Return up to three empirical terms that lower the error on unseen tests, the best first.

    Parameters
    ----------
    missing : Missing
    """
    if len(missing.before) < LEAST_TESTS or not missing.size > 0.0:
        return []
    campaign = missing.campaign
    names = tuple(n for n in LOAD_NAMES if n not in campaign.absent and campaign.varies(n))
    tried = terms(names, missing.sloping)
    bins = Bins(campaign, missing.columns, missing.y)
    found = Scan(bins, missing.whiten, missing.fold_of_test, missing.seed)(tried)
    weigh, single = _fitted(missing, bins, _different(found, float(np.mean(missing.before))))
    alone = sorted(
        ((_offer(missing, f, _stability(found, s.term)), f, s) for f, s in single), key=lambda o: -o[0].share
    )
    alone = [o for o in alone if o[0].share > 0.0]
    if not alone:
        return []
    # of terms that predict about as well the one comes first that does so in most resamples
    near = [o for o in alone if o[0].share > NEAR * alone[0][0].share]
    near.sort(key=lambda o: -o[0].stability)
    first = near[0]
    others = [o[0] for o in alone if o is not first]
    others = [o for o in others if o.share > COMPARABLE * first[0].share]
    pair = _with_second(missing, bins, weigh, tried, *first)
    answer = [*([pair] if pair else []), first[0], *others]
    return [
        o for o in answer if o.share > LEAST_SHARE and o.interval[0] > 0.0 and o.stability >= LEAST_STABLE
    ][:MOST]


def _different(found: Sequence[Scanned], before: float) -> list[Scanned]:
    """Return the best term, and others with other loads or another kind of curve that are hardly worse."""
    chosen: list[Scanned] = []
    for s in found:
        if chosen and lead(s.squares, chosen[0].squares)[1] > CERTAIN:
            break
        if s.term.family not in {c.term.family for c in chosen}:
            chosen.append(_simplest(s, found, before))
        if len(chosen) == MOST:
            break
    return chosen


def _simplest(first: Scanned, found: Sequence[Scanned], before: float) -> Scanned:
    """Return the term of the same family with the fewest parameters that predicts as well."""
    alike = [
        s
        for s in found
        if s.term.family == first.term.family
        and lead(s.squares, first.squares)[1] < NO_LEAD
        and s.error - first.error < NO_GAIN * (before - first.error)
    ]
    return min([first, *alike], key=lambda s: s.effect.degrees_of_freedom)


def _fitted(
    missing: Missing, bins: Bins, chosen: Sequence[Scanned]
) -> tuple[Weigh, list[tuple[Fitted, Scanned]]]:
    """Fit the terms, with the weights of the noise or with those of the points, whichever predicts unseen tests better."""
    weigh: Weigh = missing.whiten
    done: list[tuple[Fitted, Scanned]] = []
    for s in chosen:
        fitted = fit(bins, weigh, missing.fold_of_test, [s.effect], [s.shape])
        if not done:
            plain = fit(bins, _by_points(missing.campaign), missing.fold_of_test, [s.effect], fitted.shapes)
            if plain.error < fitted.error:
                weigh, fitted = _by_points(missing.campaign), plain
        done.append((fitted, s))
    return weigh, done


def _by_points(campaign: Campaign) -> Weigh:
    root = np.sqrt(campaign.count)
    return lambda values: values * (root if values.ndim == 1 else root[:, None])


def _stability(found: Sequence[Scanned], term: Term) -> float:
    """Return in which share of the resamples a term of the family predicts the tests that were not drawn best."""
    first = np.argmin(np.array([s.resampled for s in found]), axis=0)
    return float(np.mean([found[k].term.family == term.family for k in first]))


def _with_second(
    missing: Missing,
    bins: Bins,
    weigh: Weigh,
    tried: Sequence[Term],
    alone: FormulaOffer,
    fitted: Fitted,
    first: Scanned,
) -> FormulaOffer | None:
    """Return the first term with a second one, if that removes clearly more."""
    if fitted.error - missing.best < LEFT * missing.size:
        return None
    known = np.column_stack([missing.columns, bins.evaluate(fitted.effects[0], fitted.shapes[0])])
    beside = Bins(missing.campaign, known, missing.y)
    others = [t for t in tried if t != first.term]
    found = Scan(beside, missing.whiten, missing.fold_of_test, missing.seed)(others)
    if not found:
        return None
    second = _simplest(found[0], found, fitted.error)
    both = fit(
        bins, weigh, missing.fold_of_test, [*fitted.effects, second.effect], [*fitted.shapes, second.shape]
    )
    gain, certain = lead(fitted.squares, both.squares)
    stable = min(alone.stability, _stability(found, second.term))
    if certain < CERTAIN or gain < SECOND * missing.size or stable < SECOND_STABLE:
        return None
    return _offer(missing, both, stable)


def _offer(missing: Missing, fitted: Fitted, stability: float) -> FormulaOffer:
    """Return a fitted term with what it removes of the missing error."""
    tests = len(missing.before)
    gain, certain = lead(missing.before, fitted.squares)
    half = float(student.ppf(0.975, tests - 1)) * abs(gain) / max(abs(certain), 1e-300)
    low, share, high = (min(v / missing.size, 1.0) for v in (gain - half, gain, gain + half))
    numbers = [
        numbered(e, {"a": float(a), **s})
        for e, s, a in zip(fitted.effects, fitted.shapes, fitted.amplitudes, strict=True)
    ]
    return FormulaOffer(
        name=" and ".join(e.name for e in fitted.effects),
        equation="; ".join(numbers),
        share=share,
        interval=(low, high),
        stability=stability,
        effects=fitted.effects,
    )
