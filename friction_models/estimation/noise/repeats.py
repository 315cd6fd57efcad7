"""Tests that repeat others: the scatter that no model of the loads can explain, without any model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, fdtri

from ...loads import FloatArray
from ..campaign.binned_tests import BinnedTests
from ..campaign.metadata import MOST_LEVELS, MOST_METADATA, is_text
from ..campaign.settings import SAME_SETTING, Indexes, in_units, same_pairs
from .noise_floor import RepeatsNumbers, independent_columns

#: Fewest differences between repeats from which a scatter is estimated.
LEAST_FREEDOM = 3
#: With fewer than this of the same metadata, tests at the same loads count as repeats beside different ones: about what levels of
#: these make of them, where as many differences are left then, too.
ENOUGH_FREEDOM = 8
#: Differences for each level, so that few levels are no scatter where there are fewer than that.
FOR_EACH_LEVEL = 2
#: Repeats that share some metadata agree better than those that share none, where chance makes them do so this rarely.
AGREE_BETTER = 0.001
#: Fewest settings, and draws, for the question whether settings differ by more than repeats do.
LEAST_SETTINGS, DRAWS = 3, 999
#: With less than this probability by chance they do.
LACK_OF_FIT = 0.01


@dataclass(frozen=True)
class Repeats:
    """How far tests at the same settings lie apart."""

    #: Settings that were tested more than once, and the tests there.
    settings: int
    tests: int
    #: Standard deviation in mu of the averages about the mean of their setting: between tests and along them.
    scatter: float
    interval: tuple[float, float]  #: 95 % interval of it (chi-square).
    #: That settings differ as much as they do by chance, if all tests were repeats of one another; 1 for few settings.
    p_value: float
    #: Whether the loads of a setting agree as well as a machine meets a set point; a ladder of small steps has settings, too.
    exact: bool = True

    @property
    def lacks_fit(self) -> bool:
        """Whether settings differ by more than their repeats do."""
        return self.p_value < LACK_OF_FIT

    def agrees_with(self, scatter: float) -> bool:
        """Return whether another estimate of the scatter lies in the interval."""
        return self.interval[0] <= scatter <= self.interval[1]

    def to_dict(self) -> RepeatsNumbers:
        """Return what files and reports hold of it."""
        return {
            "settings": self.settings,
            "tests": self.tests,
            "scatter": self.scatter,
            "interval": list(self.interval),
            "p_value": self.p_value,
            "exact": self.exact,
        }


def repeats_of(campaign: BinnedTests, residual: FloatArray, seed: int = 0) -> Repeats | None:
    """Return the scatter of repeats, or None where too few tests repeat others.

    `residual`, shape (m,), is what a model leaves of mu in the bins: small differences of the loads between repeats are taken
    out by it. The p-value compares what the settings explain beside levels of metadata with what they do of tests dealt at random
    to settings of the same sizes (permutation test for lack of fit).
    """
    found = _found(campaign, residual)
    if found is None:
        return None
    low, high = (found.square * found.freedom / float(chdtri(found.freedom, q)) for q in (0.025, 0.975))
    return Repeats(
        len(found.groups),
        sum(map(len, found.groups)),
        float(np.sqrt(found.square)),
        (float(np.sqrt(low)), float(np.sqrt(high))),
        _by_chance(campaign.of_tests(residual), found.own, found.groups, seed),
        _exact(campaign, found.groups),
    )


@dataclass(frozen=True)
class _Groups:
    """Tests that repeat one another."""

    groups: list[Indexes]
    own: FloatArray  #: Levels of metadata that may differ within a group, as of `_levels`.
    square: float  #: Squared scatter in mu.
    freedom: int  #: Differences from which it is known.


def _found(campaign: BinnedTests, residual: FloatArray) -> _Groups | None:
    """Return groups of repeats; None where there are too few.

    Where too few tests share all metadata, these may differ. But a number that counts the repeats says nothing, and a batch may: if
    repeats that share some of it agree much better, these are the repeats.
    """
    same = metadata_of_tests(campaign)
    groups = same_settings(campaign, same)
    if not same or _freedom(groups) >= ENOUGH_FREEDOM:
        return _about_levels(campaign, residual, groups, [])
    whatever = _about_levels(campaign, residual, same_settings(campaign), same)
    if len(same) > MOST_METADATA:
        return whatever
    across: list[FloatArray] = []
    while same and _freedom(groups) < ENOUGH_FREEDOM:
        less = [[c for c in same if c is not column] for column in same]
        tried = [same_settings(campaign, c) for c in less]
        best = int(np.argmin([_largest_square(campaign, residual, g) for g in tried]))
        across.append(same[best])
        same, groups = less[best], tried[best]
    sharing = _about_levels(campaign, residual, groups, across) if same else None
    if whatever is None or sharing is None:
        return whatever
    ratio = sharing.square / max(whatever.square, 1e-300)
    return sharing if ratio < fdtri(sharing.freedom, whatever.freedom, AGREE_BETTER) else whatever


def _about_levels(
    campaign: BinnedTests, residual: FloatArray, groups: list[Indexes], across: list[FloatArray]
) -> _Groups | None:
    """Return groups with their scatter about what levels of metadata that differ `across` a group make of them; None for too few."""
    freedom = _freedom(groups)
    if freedom < LEAST_FREEDOM:
        return None
    own = np.empty((len(campaign.tests), 0))
    # what is the same in each group belongs to its setting, as a set temperature does
    across = [c for c in across if any(np.ptp(c[g]) > 0.0 for g in groups)]
    if across:
        levels = _levels(campaign, across)
        offsets, spent = _of_levels(levels, campaign.of_tests(residual), groups)
        # on other days or of other batches: what is not the same for each level of them is scatter, or all of it if they are many
        if freedom - spent >= min(ENOUGH_FREEDOM, max(FOR_EACH_LEVEL * spent, LEAST_FREEDOM)):
            own, residual, freedom = levels, residual - offsets[campaign.test], freedom - spent
    square = sum(_square_apart(campaign, residual, g) for g in groups) / freedom
    return _Groups(groups, own, square, freedom)


def _exact(campaign: BinnedTests, groups: list[Indexes]) -> bool:
    """Return whether the loads of each group agree as set points do, whatever their range."""
    met = [in_units(name, level, share=0.0) for name, level in campaign.levels.items()]
    return all(np.ptp(level[group]) <= 2.0 for level in met for group in groups)


def _freedom(groups: list[Indexes]) -> int:
    """Return the number of differences between repeats."""
    return sum(len(g) - 1 for g in groups)


def _largest_square(campaign: BinnedTests, residual: FloatArray, groups: list[Indexes]) -> float:
    """Return the upper end of the 95 % interval of the squared scatter of repeats; infinite without any."""
    if not (freedom := _freedom(groups)):
        return np.inf
    return sum(_square_apart(campaign, residual, g) for g in groups) / float(chdtri(freedom, 0.975))


def same_settings(campaign: BinnedTests, metadata: Sequence[FloatArray] = ()) -> list[Indexes]:
    """Return groups of tests with the same mean loads and the same `metadata`, at least two in each."""
    columns = [*(in_units(n, level) for n, level in campaign.levels.items()), *metadata]
    tests = len(campaign.tests)
    near = same_pairs(columns, tests)
    order = np.lexsort(np.array(columns)[::-1]) if columns else np.arange(tests)
    left = near.sum(axis=1) > 1
    groups: list[Indexes] = []
    for k in order:
        if left[k] and len(own := order[(near[k] & left)[order]]) > 1:
            groups.append(own)
            left[own] = False
    return groups


def metadata_of_tests(campaign: BinnedTests) -> list[FloatArray]:
    """Return metadata of the tests in units of what counts as the same, shape (tests,) each."""
    columns = []
    for name in sorted(campaign.system):
        values = campaign.of_tests(campaign.metadata(name))
        if is_text(campaign.loads, name):
            columns.append(values / 1e-9)  # another level is another setting
        elif len(np.unique(values)) <= MOST_LEVELS * len(values):  # else measured anew in each test
            columns.append(values / max(SAME_SETTING * float(np.ptp(values)), 1e-9))
    return columns


def _levels(campaign: BinnedTests, metadata: list[FloatArray]) -> FloatArray:
    """Return which tests have which level of metadata, but for the first of each column, shape (tests, levels)."""
    levels = [column[:, None] == np.unique(column)[None, 1:] for column in metadata]
    return np.column_stack([np.empty((len(campaign.tests), 0)), *levels])


def _of_levels(own: FloatArray, level: FloatArray, groups: list[Indexes]) -> tuple[FloatArray, int]:
    """Return what levels of metadata make of the tests beside their settings, shape (tests,), and how many differences that takes.

    Levels and settings add up (analysis of variance without interaction). `own` as of `_levels`, `level` of each test.
    """
    tests = np.concatenate(groups)
    setting = np.repeat(np.arange(len(groups)), list(map(len, groups)))
    about = own[tests] - np.array([own[g].mean(axis=0) for g in groups])[setting]
    level = level[tests]
    apart = level - np.array([level[setting == k].mean() for k in range(len(groups))])[setting]
    found, _, rank, _ = np.linalg.lstsq(about, apart, rcond=1e-9)
    return own @ found, int(rank)


def _square_apart(campaign: BinnedTests, residual: FloatArray, group: Indexes) -> float:
    """Return the sum over tests of the mean squared distance from the mean of their setting along the test."""
    curves = [residual[campaign.test == k] for k in group]
    weights = [campaign.count[campaign.test == k] for k in group]
    slots = min(map(len, curves))
    apart = np.array([c[:slots] for c in curves])
    weight = np.array([w[:slots] for w in weights])
    about = apart - np.average(apart, axis=0, weights=weight)
    return float(np.sum(np.average(about**2, axis=1, weights=weight)))


def _by_chance(level: FloatArray, own: FloatArray, groups: list[Indexes], seed: int) -> float:
    """Return the share of deals in which the settings explain as much of the tests beside levels of metadata, `own`.

    What the levels explain is taken out first, and the rest is dealt (Freedman, Lane, J. Bus. Econ. Stat. 1 (1983) 292).
    """
    if len(groups) < LEAST_SETTINGS:
        return 1.0
    dealt = np.concatenate(groups)
    sizes = list(map(len, groups))
    without = independent_columns(np.column_stack([np.ones(len(dealt)), own[dealt]]))
    setting = np.repeat(np.eye(len(groups)), sizes, axis=0)
    beside = independent_columns(np.column_stack([without, setting]))
    left = level[dealt] - without @ (without.T @ level[dealt])

    def explained(values: FloatArray) -> float:
        with_settings = float(np.sum((beside.T @ values) ** 2))
        rest = max(float(values @ values) - with_settings, 1e-300)
        return (with_settings - float(np.sum((without.T @ values) ** 2))) / rest

    rng = np.random.default_rng(seed)
    measured = explained(left)
    reached = sum(explained(rng.permutation(left)) >= measured for _ in range(DRAWS))
    return (1 + reached) / (DRAWS + 1)
