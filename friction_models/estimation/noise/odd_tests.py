"""Single tests that lie far off what all others say: a wrong specimen, a slipped gauge, a mixed-up record."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit
from scipy.stats import kruskal, spearmanr

from ...common.wording import first_names
from ...loads import FloatArray
from ...loads.splits import Mask
from ..campaign.binned_tests import BinnedTests
from ..campaign.binning import part_of
from ..campaign.curves import on_scale
from ..campaign.metadata import MOST_LEVELS, is_text
from ..campaign.settings import WARMS, Indexes, in_units, same_pairs
from .layout import Layout
from .noise_floor import NoiseFloor, estimate
from .one_region import region_of
from .reference import Reference

#: Probability that a test of a campaign without odd ones lies as far off by chance as an odd one must.
BY_CHANCE = 0.01
#: A median tells a scale as well as this share of so many squares would (normal distribution).
EFFICIENCY = 0.37
#: If more than this share of the tests is odd, and more than two of 20, they stay: it may be the law that is odd there. They are told
#: up to the second share; beyond that, it is no matter of tests.
MOST_ODD, MOST_TOLD = 0.06, 0.2
TWO_OF = 20
#: Of so few tests, two that are wrong bend the curves until a sound one looks odd in their place: the search begins without as many as are told.
FEW = 60
#: With fewer tests no one can say which of them is odd.
LEAST_TESTS = 12
#: A test farther beyond the others than this share of the range of a load is out of their reach; nearer, it is only the less certain
#: what they say (`Reference.surprise`).
BEYOND = 0.15
#: Fits without the tests that the one before found far off, at most.
ROUNDS = 6
#: Standard deviations by which the scatter of a test and of those around it must agree to depend on the loads.
BY_THEIR_LOADS = 1.0
#: So do levels of metadata where they differ in scatter with this p-value (Kruskal, Wallis, J. Am. Stat. Assoc. 47 (1952) 583).
BY_THEIR_LEVEL = 0.15
#: With fewer tests, a level of metadata has no scatter of its own; that around a test is seen in so many nearest ones.
LEAST_OF_LEVEL = NEAREST = 8


class OddTests(NamedTuple):
    """Names of tests whose level no smooth dependence on loads and metadata explains."""

    few: list[str]  #: So few that they are left out.
    too_many: list[str]  #: More than are a matter of single tests: they stay.
    #: Corner of the loads in which the few lie together, off to one side, in words: they may be no faults.
    region: str = ""


def odd_tests(campaign: BinnedTests, columns: FloatArray, floor: NoiseFloor | None) -> OddTests:
    """Return the tests whose level no smooth dependence on loads and metadata explains.

    Odd tests bend the curves that should show them: they hide one another, and their neighbours look odd. So the tests that lie
    farthest off are left out, all are judged by what the others say, and those that lie far off are left out in their place until
    they stay the same (Rousseeuw, Van Driessen, Data Min. Knowl. Disc. 12 (2006) 29).

    A test is not odd where its repeats lie off as well: so are the law, or the scatter, there. Nor is it where the others do not
    reach: no one can say how friction goes on beyond their loads, or at a level of metadata that none of them has.

    `columns`, shape (m, p), are the base in the bins; a floor that is not known yet is estimated here.
    """
    tests = len(campaign.tests)
    if tests < LEAST_TESTS:
        return OddTests([], [])
    y = campaign.average(campaign.mu)
    if floor is None:
        floor = estimate(campaign, Layout.of(campaign), y, columns)
    search = _Search(campaign, Reference(campaign, floor, y), columns)
    most = int(max(MOST_ODD * tests, 2.0 if tests >= TWO_OF else 1.0))
    told = int(MOST_TOLD * tests)
    first = told if tests <= FEW else most
    all_odd = search.odd(first)
    few = all_odd if len(all_odd) <= most else set()
    if first != most and not 0 < len(all_odd) <= most:
        # of many, those that lie off also where fewer are left out to begin with are a matter of single tests
        nearest = search.odd(most)
        few = nearest if len(nearest) <= most and (nearest <= all_odd or len(all_odd) > told) else set()
    names = campaign.tests
    many = sorted(all_odd - few) if len(all_odd) <= told else []
    region = region_of(campaign.levels, sorted(few), search.off(few)) if few else ""
    return OddTests([names[k] for k in sorted(few)], [names[k] for k in many], region)


def most_by_chance(tests: int) -> float:
    """Return how many times their scatter, judged by a median, no one of so many tests lies off by chance."""
    return -float(stdtrit(EFFICIENCY * tests, 0.5 * BY_CHANCE / tests))


class _Search:
    """Looks for odd tests beside the `columns` of a base, shape (m, p)."""

    def __init__(self, campaign: BinnedTests, reference: Reference, columns: FloatArray) -> None:
        self._campaign, self._reference, self._columns = campaign, reference, columns
        self._repeats, self._nearest, self._levels = _repeats(campaign), _nearest(campaign), _levels(campaign)
        self._limit = most_by_chance(len(campaign.tests))
        self._of_all = reference.surprise(columns)

    def odd(self, first: int) -> set[int]:
        """Return the odd tests; as many as `first` that lie farthest off what all say are left out to begin with."""
        far = np.zeros(len(self._of_all), dtype=bool)
        far[np.argsort(-np.abs(self._of_all), kind="stable")[:first]] = True
        for _ in range(ROUNDS):
            off = self._reference.surprise(self._columns, far) if far.any() else self._of_all
            before, far = far, np.abs(off) > self._limit * self._usual(off)
            if (far == before).all() or far.sum() > len(far) // 2:
                break
        return set(np.flatnonzero(far & _reached(self._campaign, ~far, self._levels)).tolist())

    def off(self, odd: set[int]) -> FloatArray:
        """Return how far each test lies off what others say without the odd ones."""
        left = np.isin(np.arange(len(self._of_all)), sorted(odd))
        return self._reference.surprise(self._columns, left)

    def _usual(self, off: FloatArray) -> FloatArray:
        """Return how far tests like each one lie off."""
        scatter = [
            _of_the_others(off, self._repeats),
            _around(off, self._nearest),
            *_of_levels(off, self._levels),
        ]
        return np.asarray(np.maximum.reduce([np.ones(len(off)), *scatter]))


def _repeats(campaign: BinnedTests) -> Mask:
    """Return which tests were set to the same loads, shape (tests, tests); the contact may have warmed up meanwhile."""
    levels = {n: v for n, v in campaign.levels.items() if n != "sd"}
    units = (in_units(name, level, WARMS if name == "T" else 0.0) for name, level in levels.items())
    same = same_pairs(units, len(campaign.tests)) & bool(levels)
    np.fill_diagonal(same, False)
    return same


def _nearest(campaign: BinnedTests) -> Indexes:
    """Return the tests with the most similar loads for each test, shape (tests, NEAREST)."""
    apart = np.zeros((len(campaign.tests),) * 2)
    for name, level in campaign.levels.items():
        z = on_scale(name, level)
        z = z / max(float(z.std()), 1e-300)
        apart += (z[:, None] - z) ** 2
    np.fill_diagonal(apart, np.inf)
    # names say nothing: of two that are as near, the first one in the order of the loads
    order = np.argsort(campaign.place)
    return np.asarray(order[np.argsort(apart[:, order], axis=1, kind="stable")[:, :NEAREST]])


def _levels(campaign: BinnedTests) -> list[Indexes]:
    """Return the level of each test in every column of texts that tests share."""
    found = []
    for name in sorted(campaign.system):
        values, level = np.unique(campaign.system[name][campaign.point_starts, 0], return_inverse=True)
        if is_text(campaign.loads, name) and len(values) <= MOST_LEVELS * len(campaign.tests):
            found.append(level.astype(np.intp))
    return found


def _of_the_others(off: FloatArray, repeats: Mask) -> FloatArray:
    """Return the root mean square over the repeats of each test; 0 where it has none."""
    count = repeats.sum(axis=1)
    return np.asarray(np.sqrt(repeats @ off**2 / np.maximum(count, 1)))


def _around(off: FloatArray, nearest: Indexes) -> FloatArray:
    """Return the robust scatter of the tests nearest to each one: a few of them may be odd themselves.

    0 where tests with similar loads scatter alike no more than by chance: that of so few is chance itself.
    """
    around = np.median(np.abs(off[nearest]), axis=1)
    if min(np.ptp(np.abs(off)), np.ptp(around)) <= 0.0:  # ranks need differences
        return np.zeros(len(off))
    alike = spearmanr(np.abs(off), around).statistic * np.sqrt(len(off)) > BY_THEIR_LOADS
    return np.asarray(1.4826 * around if alike else np.zeros(len(off)))


def _of_levels(off: FloatArray, levels: list[Indexes]) -> list[FloatArray]:
    """Return the robust scatter at the level of each test, for each column of metadata whose levels differ in it; 0 where few tests show it."""
    found = []
    for level in levels:
        own = [np.abs(off[level == k]) for k in range(int(level.max()) + 1)]
        many = [z for z in own if len(z) >= LEAST_OF_LEVEL]
        if len(many) > 1 and np.ptp(np.abs(off)) > 0.0 and kruskal(*many).pvalue < BY_THEIR_LEVEL:
            scatter = [1.4826 * float(np.median(z)) if len(z) >= LEAST_OF_LEVEL else 0.0 for z in own]
            found.append(np.array(scatter)[level])
    return found


def _reached(campaign: BinnedTests, kept: Mask, levels: list[Indexes]) -> Mask:
    """Return which tests lie within the loads of those that are kept, or not far beyond, and share their levels of metadata."""
    inside = np.ones(len(kept), dtype=bool)
    for name, mean in campaign.levels.items():
        # far below all speeds, where contacts stick, a step on the scale of the curves is small
        z = np.log(np.maximum(mean, 1e-9 * mean.max())) if name == "v_rel" else on_scale(name, mean)
        margin = BEYOND * float(np.ptp(z))
        inside &= (z >= z[kept].min() - margin) & (z <= z[kept].max() + margin)
    for level in levels:
        inside &= np.isin(level, level[kept])
    return inside


def without_tests(campaign: BinnedTests, names: list[str], why: str) -> BinnedTests:
    """Return the campaign without some tests, with a warning that names them and says `why`."""
    keep: npt.NDArray[np.bool_] = ~np.isin(np.array(campaign.tests)[campaign.point_test], names)
    return replace(part_of(campaign, keep), warnings=[*campaign.warnings, why], spikes=campaign.spikes)


def left_out_text(names: list[str], region: str = "") -> str:
    """Return what is said of odd tests that are left out; they may lie in one `region` of the loads."""
    told = first_names(names)
    if len(names) == 1:
        return f"one test lies far off what all others say and was left out ({told}): look at its record"
    together = (
        f". All lie to one side at {region}, where there are hardly others: a law may begin there, which tests would show"
        if region
        else ""
    )
    return f"{len(names)} tests lie far off what all others say and were left out ({told}): look at their records{together}"


def too_many_text(names: list[str]) -> str:
    """Return what is said of odd tests that stay."""
    if len(names) == 1:
        return f"one more test lies far off what all others say, too many to be left out ({names[0]}): look at its record"
    return f"{len(names)} tests lie far off what all others say, too many to be left out ({first_names(names)}): look at their records"
