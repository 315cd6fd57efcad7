"""One search for effects beside a base with given columns: noise floor, whitening, scan, significance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...loads import FloatArray
from ...models.tangent import polynomial_columns
from ..campaign.binned_tests import BinnedTests
from ..campaign.curves import on_scale
from ..noise.layout import Layout
from ..noise.noise_floor import NoiseFloor, Whitener, estimate, independent_columns
from .base_law import BaseLaw
from .candidates import Candidate
from .form_error import FormErrors
from .law_signs import physical_sets
from .scan import Fit, Prepared, Projector, prepare_candidate, rank
from .significance import (
    REPLICATES,
    SAME,
    TWINS,
    Freedom,
    Significance,
    Simulated,
    alike,
    confusion_set,
    null_noise,
    simulate,
)
from .sum_of_parts import fewer_loads_first, is_part, parts_first, shown_by_parts
from .unseen_loads import varied_first

#: Standard deviations from the rest of its test beyond which a bin is an outlier.
OUTLYING = 8.0
MOST_OUTLIERS = 0.02
#: Share of a column that must differ from test to test.
DIFFERS = 0.02
#: Share of the tests whose levels a flexible mean fits at most: the others show how they scatter.
MOST_SPENT = 0.75
#: What a test tells of slow noise along it, which effects resemble: its trend and its bend.
SLOW = 2
#: Correlation of what effects contribute to the data from which on they contribute the same.
EQUAL = 0.995


@dataclass
class SearchRound:
    """What one search found."""

    floor: NoiseFloor
    residual: FloatArray  #: Whitened bin means without the base, shape (m,).
    candidates: list[Prepared]
    #: The largest evidence first; an effect with a constant load does not lead while another one explains about as much.
    ranking: list[Fit]
    significance: Significance  #: From what all effects gain where nothing is missing.
    simulated: Simulated
    #: Whitening, and removal of the base after it.
    whiten: Whitener
    project: Projector
    columns: FloatArray  #: The base in the bins, shape (m, p).
    y: FloatArray  #: Bin means of mu without the fixed part of the base, shape (m,).
    count: FloatArray  #: Points in each bin, shape (m,).
    #: Degrees of freedom with which the scatter between tests, and noise along them, are estimated.
    freedom: Freedom
    by_parts: frozenset[str] = frozenset()  #: Effects that show nothing beyond a sum of simpler ones.
    #: Lower bound of the p-values: the one of the first search, before the floor allowed for the winner.
    least_p: float = 0.0

    @property
    def winner(self) -> Fit | None:
        """The best effect, if any can be tested."""
        return self.ranking[0] if self.ranking else None

    def p_value(self, fit: Fit) -> float:
        """Family-wise p-value of a fit."""
        return max(self.own_p_value(fit), self.least_p)

    def own_p_value(self, fit: Fit) -> float:
        """The same by this search alone."""
        return self.significance.p_value(fit.name, fit.gain)

    def confusion_set(self) -> list[str]:
        """Effects that cannot be told from the winner."""
        first = self.ranking[0]
        told = confusion_set(self.ranking, self.simulated)
        return [f.name for name in told for f in self.ranking if f.name == name and not self.just(first, f)]

    def just(self, part: Fit, whole: Fit) -> bool:
        """Return whether an effect contributes the same as another one that it contains, so that nothing speaks for it."""
        return whole.name in self.by_parts and is_part(part, whole) and alike(part, whole) > TWINS

    def plainness(self, fit: Fit) -> tuple[bool, int, int]:
        """Return what the plainest effect has least of: no fault, fewest numbers, listed first."""
        return plainness(fit, [p.name for p in self.candidates])

    def columns_with(self, fits: Sequence[Fit]) -> FloatArray:
        """Return the base and some effects in the bins, shape (m, p + effects)."""
        return np.column_stack([self.columns, *(f.binned for f in fits)])

    def beyond_base(self, values: FloatArray) -> FloatArray:
        """Return the part of a contribution to mu in the bins that the base, fitted as usual, cannot follow."""
        root = np.sqrt(self.count)[:, None]
        follow = np.linalg.lstsq(root * self.columns, root[:, 0] * values, rcond=1e-9)[0]
        return values - self.columns @ follow

    def change(self, fit: Fit) -> FloatArray:
        """Return the part of an effect that the base cannot follow, shape (m,)."""
        return self.beyond_base(fit.binned)


def flexible_mean(campaign: BinnedTests, base: FloatArray) -> FloatArray:
    """Return bin means of columns that follow more than the base [n, p]: second order and curves along each load.

    With few tests the interactions, then the curves are left out, so that scatter between tests stays visible. So are directions in which
    columns hardly go beyond the others: with three set points of a load its logarithm is a parabola, but for what the machine missed them by.
    """
    if campaign.smooth is None:
        campaign.smooth = [campaign.pieces.average(c) for c in _smooth_columns(campaign.pieces)]
    mean = campaign.average(base)
    # what lies along the tests only takes nothing of their levels
    most = max(MOST_SPENT * len(campaign.tests), _spent(campaign, mean))
    for columns in campaign.smooth:
        more = np.column_stack([mean, _beyond(columns, mean)])
        if _spent(campaign, more) <= most:
            mean = more
    return mean


def _beyond(columns: FloatArray, mean: FloatArray) -> FloatArray:
    """Return the directions in which columns, shape (m, k), differ from those of a mean by more than `DIFFERS` of themselves, shape (m, j)."""
    norms = np.linalg.norm(columns, axis=0)
    own = columns[:, norms > 0.0] / norms[norms > 0.0]
    u, size, _ = np.linalg.svd(Projector(mean)(own), full_matrices=False)
    return np.asarray(u[:, size > DIFFERS])


def _smooth_columns(campaign: BinnedTests) -> list[FloatArray]:
    """Return what a flexible mean follows at every point, what few tests need first."""
    tests = len(campaign.tests)
    z = polynomial_columns(campaign.loads, 1)
    within = campaign.distance[:, None] / max(float(campaign.distance.max()), 1e-300)
    columns = [np.column_stack([within, np.sqrt(within), np.exp(-within / 0.03), np.exp(-within / 0.1)])]
    if tests >= 8:
        columns.append(np.column_stack([z, z**2]))
        if campaign.varies("v_rel"):  # laws of speed run over decades
            columns.append(_log_speed(campaign))
    if tests >= 30:
        columns.append(polynomial_columns(campaign.loads, 2))
    if tests >= 60:
        columns.append(np.column_stack([np.maximum(z - q, 0.0) ** 2 for q in (-0.8, 0.8)]))
    return columns


def _spent(campaign: BinnedTests, columns: FloatArray) -> int:
    """Return how many numbers columns in the bins fit to the levels of the tests.

    Columns that hardly differ from test to test, as those of the distance, say nothing about the level of a test.
    """
    return int(independent_columns(_levels(campaign, columns), DIFFERS).shape[1])


def _levels(campaign: BinnedTests, columns: FloatArray) -> FloatArray:
    """Return means of columns in the bins over each test, shape (tests, k)."""
    return np.column_stack([campaign.of_tests(column) for column in columns.T])


def _log_speed(campaign: BinnedTests) -> FloatArray:
    """Return the speed at every point on the scale of its curves, centred and scaled, shape (n, 1)."""
    w = on_scale("v_rel", campaign.loads.v_rel)
    return ((w - w.mean()) / max(float(w.std()), 1e-12))[:, None]


def distrust_outliers(campaign: BinnedTests, base: BaseLaw) -> NoiseFloor | None:
    """Take the weight from bins that lie far off the other bins of their test (two passes).

    If more than one bin in fifty lies far off, all keep their weight: so many show structure, not outliers. Returns a first
    estimate of the noise floor; None where there are too few bins to judge.
    """
    y = campaign.average(campaign.mu - base.offset)
    mean = independent_columns(flexible_mean(campaign, base.columns))
    if len(y) < 3 * len(campaign.tests) or len(y) < 2 * mean.shape[1]:
        return None
    floor = None
    for _ in range(2):
        layout = Layout.of(campaign)
        floor = estimate(campaign, layout, y, mean, floor)
        whiten = Whitener(layout, floor, float(np.std(y)) or 1e-6)
        white = whiten(mean)
        residual = y - mean @ np.linalg.lstsq(white, whiten(y), rcond=1e-9)[0]
        far = np.abs(whiten.isolation(residual))
        known = campaign.distrusted if campaign.distrusted is not None else np.zeros(len(y), dtype=bool)
        flagged = known | (far > OUTLYING * max(1.4826 * float(np.median(far)), 1e-12))
        if flagged.sum() == known.sum() or flagged.mean() > MOST_OUTLIERS:
            break
        campaign.distrusted = flagged
    return floor


def search(
    campaign: BinnedTests,
    base: BaseLaw,
    terms: FloatArray | None,
    candidates: list[Candidate],
    seed: int,
    start: NoiseFloor | None = None,
    also_in_mean: FloatArray | None = None,
) -> SearchRound:
    """Scan all candidates beyond the base and further terms.

    `terms`, shape (m, k), are further columns in the bins that belong to the base by now (effects found, freed drivers);
    `start` is an earlier estimate of the floor. Columns `also_in_mean`, shape (m, k), serve the estimation of the floor alone
    (the winner of an earlier round).
    """
    layout = Layout.of(campaign)
    y = campaign.average(campaign.mu - base.offset)
    columns = campaign.average(base.columns)
    if terms is not None:
        columns = np.column_stack([columns, terms])
    mean = flexible_mean(campaign, base.columns)
    extra = [e for e in (terms, also_in_mean) if e is not None]
    mean = np.column_stack([mean, *extra])
    floor = estimate(campaign, layout, y, mean, start)
    freedom = _freedom(campaign, mean)
    scale = float(np.std(y)) or 1e-6
    whiten = Whitener(layout, floor, scale)
    project = Projector(whiten(columns))
    residual = project(whiten(y))
    prepared = [prepare_candidate(c, whiten, project) for c in candidates]
    for p in prepared:
        p.usable &= physical_sets(campaign, p, residual, whiten, columns, y)[:, None]
    prepared = [p for p in prepared if p.usable.any()]
    unexplained = residual if also_in_mean is None else Projector(project(whiten(also_in_mean)))(residual)
    rng = np.random.default_rng(seed)
    setting, level = campaign.setting[campaign.test], whiten(np.ones(len(y)))
    # settings with repeats are few, and each holds much of an effect, which random signs of it take for noise already
    fitted = None if freedom.shared else project.q
    noise = null_noise(unexplained, level, setting, freedom, rng, REPLICATES, fitted)
    simulated = simulate(prepared, project, noise)
    ranking = FormErrors(campaign, whiten, project).ranked(rank(prepared, residual), residual)
    by_parts = shown_by_parts(campaign, ranking, residual, whiten, project)
    listed = [c.effect.name for c in candidates]
    ranking = parts_first(simple_first(ranking), by_parts)
    ranking = varied_first(campaign, fewer_loads_first(campaign, ranking, residual, whiten, project))
    return SearchRound(
        floor=floor,
        residual=residual,
        candidates=prepared,
        ranking=plain_first(ranking, listed),
        significance=Significance(prepared, simulated, level, setting),
        simulated=simulated,
        whiten=whiten,
        project=project,
        columns=columns,
        y=y,
        count=campaign.count,
        freedom=freedom,
        by_parts=by_parts,
    )


def plainness(fit: Fit, listed: Sequence[str]) -> tuple[bool, int, int]:
    """Return what the plainest effect has least of: no fault, fewest numbers, `listed` first."""
    # what was seen beside others need not be listed
    place = listed.index(fit.name) if fit.name in listed else len(listed)
    return fit.effect.kind == "fault", fit.effect.degrees_of_freedom, place


def plain_first(ranking: list[Fit], listed: Sequence[str]) -> list[Fit]:
    """Let the plainest come first of effects that contribute the same and fit alike: no fault, fewest numbers, listed first.

    Which of them fits better by a hair changes with every test that is left out.
    """

    ordered, rest = list[Fit](), list(ranking)
    while rest:
        best = rest[0]
        near = (f for f in rest[1:] if f.evidence > (1.0 - SAME) * best.evidence > 0.0)
        lead = min([best, *(f for f in near if alike(best, f) > EQUAL)], key=lambda f: plainness(f, listed))
        ordered.append(lead)
        rest = [f for f in rest if f is not lead]
    return ordered


def simple_first(ranking: list[Fit]) -> list[Fit]:
    """Let an effect of present loads lead one with a memory of them that explains the same.

    An evidence within `SAME` of the first one may be a matter of formulas.
    """
    if not ranking or not ranking[0].effect.needs_state:
        return ranking
    for fit in ranking[1:]:
        if fit.evidence < (1.0 - SAME) * ranking[0].evidence:
            break
        if not fit.effect.needs_state and set(fit.effect.driver) <= set(ranking[0].effect.driver):
            return [fit, *(f for f in ranking if f is not fit)]
    return ranking


def _freedom(campaign: BinnedTests, mean: FloatArray) -> Freedom:
    """Return what a flexible mean leaves to estimate the scatter between tests, and slow noise along them."""
    between = len(campaign.tests) - _spent(campaign, mean)
    inside = mean - _levels(campaign, mean)[campaign.test]
    inside = inside[:, np.linalg.norm(inside, axis=0) > DIFFERS * np.linalg.norm(mean, axis=0)]
    bent = independent_columns(inside, DIFFERS).shape[1] if inside.shape[1] else 0
    along = int(np.minimum(np.bincount(campaign.test) - 1, SLOW).sum()) - bent
    shared = int(campaign.setting.max()) + 1 < len(campaign.tests)
    return Freedom(float(max(between, 2)), float(max(along, 2)), shared)
