"""Tests as units: points sorted by test and averaged into distance bins that are fine near the start."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...common import InputError
from ...loads import (
    LOAD_NAMES,
    LOADS,
    MEASURED_MU,
    FloatArray,
    TriboLoads,
    about_negative,
    check_column,
    missing_column,
    not_measured,
)
from ...loads.contract import QUANTITIES, behind
from ...loads.order import about_falls
from .cleaning import thinned, without_copies, without_gaps, without_spikes
from .clipping import about_clipping
from .conflicting_loads import about_conflicts
from .dead_sensor import about_dead_sensor
from .load_noise import without_noise
from .load_spikes import without_load_spikes
from .metadata import about_table, metadata_columns
from .mixed_units import about_units
from .settings import HELD, setting_of_tests, varies

#: Share of what a load changes along the tests by which its means must differ from test to test to set them apart.
LEVELS = 0.1
APART = 10.0  # largest over smallest distance of averages from which on it is not the length of the tests that differs
BINS = 19  # a test, with many tests
MOST_BINS = 120  # a test, with few tests
ALL_BINS = 2100  # of a campaign, about
FEW_TESTS = 6  # with fewer their scatter is so poorly known that "nothing is missing" is not said
MOST_SAMPLES = 8  # of a bin, for the mean of a smooth formula
FINENESS = 1.7  # exponent of the bin edges: the first bin covers about 0.7 % of the distance


@dataclass
class BinnedTests:
    """Measured points of whole tests, with the bins that every later step works on."""

    loads: TriboLoads  #: All points, without the noise of sensors; the points of one test are consecutive.
    mu: FloatArray  #: Measured coefficient of friction, shape (n,).
    tests: list[str]  #: Test names in the order of the points.
    point_starts: npt.NDArray[np.intp]  #: First point of each test, shape (tests,).
    starts: npt.NDArray[np.intp]  #: First point of each bin, shape (m,).
    count: FloatArray  #: Points in each bin, shape (m,).
    test: npt.NDArray[np.intp]  #: Test of each bin, shape (m,).
    slot: npt.NDArray[np.intp]  #: Number of the bin within its test, shape (m,).
    #: Sliding distance since the start of the test [mm], of averages far apart the recorded one; counts of points where it does
    #: not vary. Shape (n,).
    distance: FloatArray
    #: Metadata of the tests that is recorded for every test, as numbers, each of shape (n, 1).
    system: dict[str, FloatArray] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)  #: What the user should know about the data.
    grouped: bool = True  #: Whether tests are known.
    #: Loads as they were read, noise included; None where they are as in `loads`.
    read: TriboLoads | None = field(default=None, repr=False)
    #: Bins that lie far off their neighbours; they carry no weight. Shape (m,).
    distrusted: npt.NDArray[np.bool_] | None = None
    spikes: float = 0.0  #: Share of the points that lay far off their neighbours and were replaced.
    #: States of effects whose evolution does not depend on shape parameters, with the mu that drove them.
    integrated: dict[str, tuple[FloatArray, dict[str, FloatArray]]] = field(default_factory=dict, repr=False)
    #: Curves along the loads, once they have been computed, shape (m, k).
    smooth: list[FloatArray] | None = field(default=None, repr=False)

    @property
    def as_read(self) -> TriboLoads:
        """Loads as they were read, noise included."""
        return self.loads if self.read is None else self.read

    def average(self, values: FloatArray) -> FloatArray:
        """Return bin means of `values`, shape (n,) or (n, k)."""
        sums = np.add.reduceat(values, self.starts, axis=0)
        return sums / (self.count if sums.ndim == 1 else self.count[:, None])

    def of_tests(self, values: FloatArray) -> FloatArray:
        """Return means over each test of values in the bins, shape (m,), weighted by their points."""
        weight = np.bincount(self.test, self.count)
        return np.asarray(np.bincount(self.test, self.count * values) / weight)

    def metadata(self, name: str) -> FloatArray:
        """Return a column of metadata in the bins, shape (m,)."""
        return self.average(self.system[name][:, 0])

    @cached_property
    def largest_mu(self) -> float:
        """Largest mean friction coefficient of a bin."""
        return float(np.max(self.average(self.mu)))

    @cached_property
    def samples(self) -> npt.NDArray[np.intp]:
        """Points that stand for their bins in the mean of a smooth formula: evenly spaced ones, at most `MOST_SAMPLES` a bin."""
        size = np.minimum(self.count, MOST_SAMPLES).astype(np.intp)
        within = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
        steps = np.repeat(self.count / size, size)
        return np.asarray(np.repeat(self.starts, size) + ((within + 0.5) * steps).astype(np.intp))

    @cached_property
    def sampled(self) -> BinnedTests:
        """The same bins, of their `samples` only; without what the points before these did."""
        rows = self.samples
        count = np.minimum(self.count, MOST_SAMPLES)
        starts = (np.cumsum(count) - count).astype(np.intp)
        return BinnedTests(
            self.loads.take(rows), self.mu[rows], self.tests, starts[self.first_bins], starts, count, self.test, self.slot,
            self.distance[rows], {name: column[rows] for name, column in self.system.items()}, grouped=self.grouped,
        )  # fmt: skip

    @cached_property
    def place(self) -> npt.NDArray[np.intp]:
        """Place of each test in the order of their mean loads and mu.

        Names of tests say nothing: by this order every random number falls on the same test, whatever its name.
        """
        means = [self.of_tests(self.average(column)) for column in (*self.loads.as_array().T, self.mu)]
        return np.asarray(np.argsort(np.lexsort(means[::-1])))

    @cached_property
    def levels(self) -> dict[str, FloatArray]:
        """Mean over each test of each load that was measured and varies, of the distance for ``sd``; shape (tests,) each."""
        columns = {n: self.distance if n == "sd" else getattr(self.loads, n) for n in self.varied}
        return {n: self.of_tests(self.average(column)) for n, column in columns.items()}

    @cached_property
    def setting(self) -> npt.NDArray[np.intp]:
        """Setting of each test, see `setting_of_tests`."""
        means = dict(self.levels)
        if not self.averaged:  # how long a test was
            means.pop("sd", None)
        if "T" in means and "T_tool" in self.system:
            means["T_tool"] = self.of_tests(self.metadata("T_tool"))
            del means["T"]
        return setting_of_tests(means, self.place)

    def with_load(self, name: str, values: FloatArray) -> BinnedTests:
        """Return the same bins with other values of a load, shape (n,); what was computed with the present ones stays behind."""
        changed: Any = {name: values}
        return replace(self, loads=replace(self.loads, **changed), integrated={}, smooth=None)

    def spread(self, tests: npt.NDArray[np.intp], most: int) -> npt.NDArray[np.intp]:
        """Return some tests, all or `most` of them, evenly spread over their loads whatever their names are; sorted."""
        by_loads = tests[np.argsort(self.place[tests])]
        count = min(len(tests), most)
        return np.sort(by_loads[np.linspace(0, len(tests) - 1, count).astype(int)])

    def part(self, rows: npt.NDArray[np.bool_]) -> BinnedTests:
        """Return the points of some tests, binned, with their metadata."""
        ids = self.loads.test_id
        part = campaign_of(self.loads.take(rows), self.mu[rows], None if ids is None else ids[rows])
        part.read = None if self.read is None else self.read.take(rows)
        part.system = {name: column[rows] for name, column in self.system.items()}
        return part

    @property
    def absent(self) -> tuple[str, ...]:
        """Loads that the data lack; they are held constant."""
        return self.loads.absent

    @property
    def averaged(self) -> bool:
        """Whether there is one average a test, so that nothing shows along tests."""
        return len(self.starts) == len(self.tests)

    @property
    def first_bins(self) -> npt.NDArray[np.intp]:
        """First bin of each test."""
        return np.flatnonzero(np.r_[True, np.diff(self.test) > 0])

    @property
    def point_test(self) -> npt.NDArray[np.intp]:
        """Test of each point."""
        return np.repeat(self.test, self.count.astype(int))

    @property
    def varied(self) -> list[str]:
        """Loads that were measured and vary, in their usual order."""
        return [n for n in LOAD_NAMES if n not in self.absent and self.varies(n)]

    def ranges(self, names: Iterable[str]) -> dict[str, list[float]]:
        """Return the lowest and the highest value of those names that are loads which vary."""
        columns = {n: getattr(self.loads, n) for n in names if n in LOAD_NAMES and self.varies(n)}
        return {n: [float(column.min()), float(column.max())] for n, column in columns.items()}

    def sets_apart(self, name: str) -> bool:
        """Whether a load differs from test to test, and not only by where the averages of equal tests begin and end."""
        values = self.average(getattr(self.loads, name))
        means = self.of_tests(values)
        return float(np.std(means)) > LEVELS * float(np.sqrt(np.mean((values - means[self.test]) ** 2)))

    def varies(self, name: str) -> bool:
        """Whether a load takes more than one value, beyond what a machine makes of one set point."""
        return name in self._varying

    @cached_property
    def _varying(self) -> frozenset[str]:
        columns = {n: getattr(self.loads, n) for n in LOAD_NAMES}
        held = {n: self.average(c) if n in HELD else c for n, c in columns.items()}
        return frozenset(n for n, column in held.items() if varies(n, column, self.averaged))


def prepare(data: pd.DataFrame, tests: pd.DataFrame | None = None) -> BinnedTests:
    """Check, sort and bin a table of points.

    Loads that the table lacks are filled with a constant and reported; a table without `test_id` is one test.
    Raises InputError: no points, no `mu`, or values outside the physical limits.
    """
    warnings: list[str] = []
    if not isinstance(data, pd.DataFrame) or not (tests is None or isinstance(tests, pd.DataFrame)):
        other = tests if isinstance(data, pd.DataFrame) else data
        raise InputError(
            f"data: {type(other).__name__}; allowed: a pandas.DataFrame of points, and one of tests"
        )
    frame = data.reset_index(drop=True)
    if "mu" not in frame.columns:
        raise missing_column("mu", frame.columns)
    if frame.empty:
        raise InputError("data: no points; allowed: at least one test with some points")
    absent = not_measured(frame.columns)
    if absent and len(absent) < len(LOADS):
        names = ", ".join(absent)
        warnings.append(f"the data lack {names}: taken as constant, effects of these loads cannot be seen")
    if "test_id" not in frame.columns:
        warnings.append("the data have no test_id: all points count as one test")
        frame = frame.assign(test_id="all")
    frame = without_gaps(frame, warnings)
    blank = (frame["test_id"].isna() | (frame["test_id"].astype(str).str.strip() == "")).to_numpy()
    if blank.any():
        raise InputError(f"data: column 'test_id', row {int(np.argmax(blank))}: no value; allowed: any name")
    frame = frame.assign(test_id=frame["test_id"].astype(str))
    _, rows = TriboLoads.from_frame(frame, tests).in_order(memory=False)
    frame = without_copies(frame.iloc[rows].reset_index(drop=True), warnings)
    # the order of the table says nothing: by name, so that every choice falls on the same test
    frame = frame.sort_values("test_id", kind="stable").reset_index(drop=True)
    frame = thinned(frame, 4 * BINS, warnings)
    loads = TriboLoads.from_frame(frame, tests)
    order = [] if loads.test_id is None else about_falls(loads.test_id, loads.sd)
    warnings += [*order, *about_table(loads)]
    loads, lone = without_load_spikes(loads, frame["test_id"].to_numpy(dtype=str), warnings)
    measured = check_column(frame["mu"].to_numpy(), MEASURED_MU, "data")
    about_negative(measured, "data")  # refuses the wrong sign
    warnings += about_clipping(measured, frame["test_id"].to_numpy(dtype=str))
    mu = without_spikes(measured, frame["test_id"], warnings)
    campaign = campaign_of(loads, mu, loads.test_id)
    campaign.spikes = float(np.mean((mu != measured) | lone))
    campaign.system = metadata_columns(loads)
    warnings += about_units(loads, campaign.point_starts, campaign.tests)
    warnings += about_dead_sensor(loads, campaign.point_starts, campaign.tests)
    warnings += about_conflicts(loads, campaign.point_starts, campaign.tests, campaign.system)
    campaign.warnings = warnings + _remarks(campaign)
    return campaign


def campaign_of(loads: TriboLoads, mu: FloatArray, groups: npt.NDArray[np.str_] | None) -> BinnedTests:
    """Bin points whose tests, named by `groups`, are consecutive; without `groups` every point is a bin of its own."""
    n = len(mu)
    if groups is None:
        index = np.arange(n)
        return BinnedTests(
            loads, mu, ["all"], np.array([0]), index, np.ones(n), np.zeros(n, dtype=int), index,
            np.maximum(loads.sd - loads.sd[:1], 0.0), grouped=False,
        )  # fmt: skip
    change = np.r_[True, groups[1:] != groups[:-1]]
    order = np.cumsum(change) - 1
    point_starts = np.flatnonzero(change)
    read, loads = loads, without_noise(loads, point_starts)
    bins = int(np.clip(ALL_BINS // len(point_starts), BINS, MOST_BINS))
    progress, distance = _progress(loads, point_starts, bins)
    slot_of_point = np.minimum((bins * progress ** (1.0 / FINENESS)).astype(int), bins - 1)
    starts = np.flatnonzero(np.r_[True, (np.diff(order) > 0) | (np.diff(slot_of_point) != 0)])
    count = np.diff(np.r_[starts, n]).astype(float)
    test = order[starts]
    slot = np.arange(len(starts)) - np.flatnonzero(np.r_[True, np.diff(test) > 0])[test]
    names = [str(g) for g in groups[point_starts]]
    return BinnedTests(loads, mu, names, point_starts, starts, count, test, slot, distance, read=read)


def _remarks(campaign: BinnedTests) -> list[str]:
    """Return what the user should know about thin data."""
    warnings, tests = [], len(campaign.tests)
    if campaign.averaged:
        warnings.append(
            "one point a test (averaged data): running-in, static peak and wear-out cannot be seen at all"
        )
    if tests == 1:
        warnings.append("one test: the scatter between tests cannot be estimated; nothing here is confirmed")
    elif tests < FEW_TESTS:
        warnings.append(f"only {tests} tests: the scatter between tests is poorly known")
    for name in LOAD_NAMES:
        if name not in campaign.absent and not campaign.varies(name):
            column = getattr(campaign.loads, name)
            low, high = f"{np.min(column):.4g}", f"{np.max(column):.4g}"
            how = (
                "does not vary in the data"
                if low == high
                else f"varies only as a machine holds it ({low} to {high}{behind(QUANTITIES[name].unit)})"
            )
            warnings.append(f"{name} {how}: effects of {name} cannot be seen")
    return warnings


def _progress(
    loads: TriboLoads, point_starts: npt.NDArray[np.intp], bins: int
) -> tuple[FloatArray, FloatArray]:
    """Return how far each point is within its test, 0 to 1, and its distance since the start.

    Averages stand at distances of their own where these are far apart; else theirs is half the length of the test.
    """
    progress, distance = np.empty(len(loads)), np.empty(len(loads))
    if len(loads) == len(point_starts) and loads.sd.max() > APART * max(float(loads.sd.min()), 0.0) > 0.0:
        return np.zeros(len(loads)), loads.sd
    for a, b in zip(point_starts, np.r_[point_starts[1:], len(loads)], strict=True):
        sd = np.maximum.accumulate(loads.sd[a:b]) - loads.sd[a]
        if not sd[-1] > 0:
            sd = np.arange(b - a, dtype=float)
        distance[a:b] = sd
        if b - a > bins:
            progress[a:b] = sd / float(sd[-1])
        else:  # every point is its own bin: aim at the middle of successive slots
            progress[a:b] = ((np.arange(b - a) + 0.5) / bins) ** FINENESS
    return progress, distance
