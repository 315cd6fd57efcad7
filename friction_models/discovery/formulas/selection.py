"""Forward selection of terms by the prediction of unseen tests; and the same once more without each fold, to judge it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ...effects import empirical_effect
from ...effects.empirical.terms import Term
from ...estimation.noise.noise_floor import Whitener
from ...loads import FloatArray
from ..judge.error_budget import lead
from ..judge.unseen_tests import ErrorsByTest, errors_of_tests
from .bins import Bins
from .scan import ChosenTests, Column, Scan, Tried, folds_left_out

#: Most terms that are added to one another.
MOST_TERMS = 3
#: Resamples of whole tests.
RESAMPLES = 12
#: Share of them in which a term must come first to be a stable one.
STABLE = 0.5
#: A term lowers the error by this many standard errors over the tests, and by this share of it; a further one by this
#: share of what the terms before it took.
CERTAIN, LEAST_GAIN, FURTHER_GAIN = 2.0, 0.03, 0.06
#: It may be this certain along the tests instead.
ALONG = 3.0
#: A simpler term is taken if the better one leads by less than this many standard errors and this share of its gain.
NO_LEAD, NO_GAIN = 1.0, 0.02


@dataclass(eq=False)
class Group:
    """Tests for which terms are looked for, and what was chosen."""

    weight: FloatArray  #: 1 for its tests, shape (tests,).
    chosen: list[Column] = field(default_factory=list)
    #: Of each test by fits to others, without a term, with the first one, and so on.
    errors: list[ErrorsByTest] = field(default_factory=list)

    @property
    def own(self) -> npt.NDArray[np.bool_]:
        """Which tests are its."""
        return self.weight > 0.0

    def error(self, errors: ErrorsByTest) -> float:
        """Return the mean squared error over its tests."""
        return float(np.mean(errors.total[self.own]))

    def lead(self, worse: ErrorsByTest, better: ErrorsByTest) -> tuple[float, float]:
        """Return by how much an error is smaller over its tests, and by how many standard errors."""
        return lead(worse.total[self.own], better.total[self.own])

    def helps(self, before: ErrorsByTest, after: ErrorsByTest) -> bool:
        """Return whether an error is smaller for certain, in all or along the tests; of fewer tests less is asked."""
        certain = self.lead(before, after)[1]
        along = lead(before.within[self.own], after.within[self.own])[1]
        asked = float(np.sqrt(np.mean(self.own)))
        return certain > asked * CERTAIN or (certain > 0.0 and along > asked * ALONG)


@dataclass(frozen=True)
class Ranked:
    """A term of one round for all tests."""

    column: Column
    errors: ErrorsByTest  #: Of each test by fits to others.
    #: Share of resamples of whole tests in which a term of the same loads and kind of curve predicts the tests that were not
    #: drawn best.
    stability: float

    @property
    def term(self) -> Term:
        """The term."""
        return self.column.term


@dataclass(frozen=True)
class Selection:
    """What was chosen, and how well the choice itself predicts."""

    all: Group  #: With all tests.
    rounds: list[list[Ranked]]  #: Terms of each round that were tried, the smallest error first.
    stability: list[float]  #: Of each chosen term.
    residual: FloatArray  #: What terms that were chosen and fitted without the tests of a fold leave of mu in its bins, shape (m,).
    errors: ErrorsByTest  #: Of each test by these.


def select(
    bins: Bins,
    whiten: Whitener,
    fold: npt.NDArray[np.intp],
    terms: Sequence[Term],
    seed: int,
    least_stable: float = 0.0,
) -> Selection:
    """Add terms one after the other while unseen tests are predicted better.

    `fold`, shape (tests,), is that of each test, `seed` that of the resamples. A term that comes first in fewer of them than
    `least_stable` is the last one.
    """
    tests = len(fold)
    draws = np.random.default_rng([seed, 7]).integers(tests, size=(RESAMPLES, tests))
    resamples = [ChosenTests(np.bincount(d, minlength=tests).astype(float), 0) for d in draws]
    folds = np.unique(fold)
    groups = [Group(np.ones(tests)), *(Group((fold != k).astype(float)) for k in folds)]
    rounds: list[list[Ranked]] = []
    stability: list[float] = []
    active = groups
    while groups[0] in active and len(rounds) < MOST_TERMS and min(stability, default=1.0) >= least_stable:
        fits = [ChosenTests(g.weight, k) for k, g in enumerate(active)]
        inner = []
        for k, g in enumerate(active):
            inner.append(range(len(fits), len(fits) + len(folds_left_out(g.weight, fold, k))))
            fits += folds_left_out(g.weight, fold, k)
        drawn = range(len(fits), len(fits) + RESAMPLES)
        scan = Scan(bins, whiten, [g.chosen for g in active], [*fits, *resamples])
        promising, terms = scan.promising(terms)
        tried = [scan.one(t) for t in promising]
        rounds.append(_ranked(scan, tried, inner[0], drawn))
        going = []
        for k, g in enumerate(active):
            if not g.errors:
                g.errors.append(scan.errors(inner[k], [scan.without(f) for f in inner[k]]))
            found = [
                (t.columns[k], scan.errors(inner[k], [t.residuals[f] for f in inner[k]]))
                for t in tried
                if t.columns[k] is not None
            ]
            if _add(g, [(c, s) for c, s in found if c is not None]):
                going.append(g)
        if groups[0] in going:
            stability.append(_stability_of(rounds[-1], groups[0].chosen[-1].term))
        active = going
    residual = np.empty(len(bins.y))
    for k, g in zip(folds, groups[1:], strict=True):
        held = fold[bins.campaign.test] == k
        residual[held] = _left(bins, whiten, g)[held]
    return Selection(groups[0], rounds, stability, residual, errors_of_tests(bins.campaign, residual))


def _add(group: Group, found: Sequence[tuple[Column, ErrorsByTest]]) -> bool:
    """Add the term that predicts unseen tests best; return whether one does better than none."""
    held = {c.term for c in group.chosen}
    found = [f for f in found if f[0].term not in held]
    if not found:
        return False
    before = group.errors[-1]
    best = min(found, key=lambda f: group.error(f[1]))
    gain = group.lead(before, best[1])[0]
    taken = group.error(group.errors[0]) - group.error(before)
    if not group.helps(before, best[1]) or gain < max(LEAST_GAIN * group.error(before), FURTHER_GAIN * taken):
        return False
    alike = [
        f
        for f in found
        if group.lead(f[1], best[1])[1] < NO_LEAD
        and group.error(f[1]) - group.error(best[1]) < NO_GAIN * gain
    ]
    column, errors = min([best, *alike], key=lambda f: _freedom(f[0].term))
    group.chosen.append(column)
    group.errors.append(errors)
    return True


def _freedom(term: Term) -> int:
    return empirical_effect(str(term))().degrees_of_freedom


def _ranked(scan: Scan, tried: Sequence[Tried], inner: range, drawn: range) -> list[Ranked]:
    """Return the terms of a round for all tests, the smallest error on unseen tests first."""
    if not tried:
        return []
    left = np.array([[np.nanmean(scan.errors([f], [t.residuals[f]]).total) for f in drawn] for t in tried])
    first = [tried[k].term.family for k in np.argmin(left, axis=0)]
    found = [
        Ranked(
            c, scan.errors(inner, [t.residuals[f] for f in inner]), first.count(t.term.family) / len(first)
        )
        for t in tried
        if (c := t.columns[0]) is not None
    ]
    return sorted(found, key=lambda r: float(np.mean(r.errors.total)))


def _stability_of(ranked: Sequence[Ranked], term: Term) -> float:
    return next(r.stability for r in ranked if r.term == term)


def _left(bins: Bins, whiten: Whitener, group: Group) -> FloatArray:
    """Return what the chosen terms, fitted to the tests of a group, leave of mu in all bins."""
    matrix = np.column_stack([bins.columns, *(c.values for c in group.chosen)])
    rows = group.weight[bins.campaign.test] > 0.0
    norms = np.linalg.norm(matrix, axis=0)
    b = np.linalg.lstsq(whiten(matrix / norms)[rows], whiten(bins.y)[rows], rcond=1e-9)[0]
    return np.asarray(bins.y - matrix / norms @ b)
