"""Tests as units: points sorted by test and averaged into distance bins that are fine near the start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import gcd

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...common import InputError
from ...common.wording import counted
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
from .metadata import about_table, metadata_columns
from .settings import setting_of_tests

BINS = 19  # a test, with many tests
MOST_BINS = 120  # a test, with few tests
ALL_BINS = 2100  # of a campaign, about
MOST_POINTS = 150_000
LEAST_COPY = 3  # points: fewer agree by chance where values are rounded
TOLD_APART = 4  # columns
LEAST_ALIKE = 5  # different tests, each of them as often as the others: the table was copied
SAME_VALUE = 1e-4  # of the range of a column: no two tests agree so well in every point
SPIKE = 0.005  # least distance in mu of a point from its neighbours that counts as a spike
STEPS = 2.5  # of the resolution: noise around the edge of a step jumps by one or two of them
MOST_VALUES = 0.1  # share of the points that differ: with fewer values mu was rounded
FEW_TESTS = 6  # with fewer their scatter is so poorly known that "nothing is missing" is not said
FINENESS = 1.7  # exponent of the bin edges: the first bin covers about 0.7 % of the distance


@dataclass
class Campaign:
    """Measured points of whole tests, with the bins that every later step works on.

    Attributes
    ----------
    loads : TriboLoads
        All points; the points of one test are consecutive.
    mu : ndarray, shape (n,)
        Measured coefficient of friction.
    tests : list of str
        Test names in the order of the points.
    point_starts : ndarray of int, shape (tests,)
        First point of each test.
    starts : ndarray of int, shape (m,)
        First point of each bin.
    count : ndarray, shape (m,)
        Points in each bin.
    test : ndarray of int, shape (m,)
        Test of each bin.
    slot : ndarray of int, shape (m,)
        Number of the bin within its test.
    distance : ndarray, shape (n,)
        Sliding distance since the start of the test [mm]; counts of points where it does not vary.
    system : dict of str to ndarray, shape (n, 1)
        Metadata of the tests that is recorded for every test, as numbers.
    warnings : list of str
        What the user should know about the data.
    grouped : bool
        Whether tests are known.
    distrusted : ndarray of bool, shape (m,), or None
        Bins that lie far off their neighbours; they carry no weight.
    spikes : float
        Share of the points that lay far off their neighbours and were replaced.
    integrated : dict
        States of effects whose evolution does not depend on shape parameters, with the mu that drove them.
    smooth : ndarray, shape (m, k), or None
        Curves along the loads, once they have been computed.
    """

    loads: TriboLoads
    mu: FloatArray
    tests: list[str]
    point_starts: npt.NDArray[np.intp]
    starts: npt.NDArray[np.intp]
    count: FloatArray
    test: npt.NDArray[np.intp]
    slot: npt.NDArray[np.intp]
    distance: FloatArray
    system: dict[str, FloatArray] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    grouped: bool = True
    distrusted: npt.NDArray[np.bool_] | None = None
    spikes: float = 0.0
    integrated: dict[str, tuple[FloatArray, dict[str, FloatArray]]] = field(default_factory=dict, repr=False)
    smooth: FloatArray | None = field(default=None, repr=False)

    def average(self, values: FloatArray) -> FloatArray:
        """Return bin means of `values`, shape (n,) or (n, k)."""
        sums = np.add.reduceat(values, self.starts, axis=0)
        return sums / (self.count if sums.ndim == 1 else self.count[:, None])

    def of_tests(self, values: FloatArray) -> FloatArray:
        """Return means over each test of values in the bins, shape (m,), weighted by their points."""
        weight = np.bincount(self.test, self.count)
        return np.asarray(np.bincount(self.test, self.count * values) / weight)

    @cached_property
    def place(self) -> npt.NDArray[np.intp]:
        """Place of each test in the order of their mean loads and mu.

        Names of tests say nothing: by this order every random number falls on the same test, whatever its name.
        """
        means = [self.of_tests(self.average(column)) for column in (*self.loads.as_array().T, self.mu)]
        return np.asarray(np.argsort(np.lexsort(means[::-1])))

    @cached_property
    def setting(self) -> npt.NDArray[np.intp]:
        """Setting of each test, see `setting_of_tests`."""
        averaged = self.count.size == len(self.tests)
        columns = {n: getattr(self.loads, n) for n in LOAD_NAMES if n not in self.absent and self.varies(n)}
        if not averaged:  # how long a test was
            columns.pop("sd", None)
        if "T" in columns and "T_tool" in self.system:
            columns["T_tool"] = self.system["T_tool"][:, 0]
            del columns["T"]
        return setting_of_tests({n: self.of_tests(self.average(c)) for n, c in columns.items()}, self.place)

    def part(self, rows: npt.NDArray[np.bool_]) -> Campaign:
        """Return the points of some tests, binned, with their metadata."""
        ids = self.loads.test_id
        part = campaign_of(self.loads.take(rows), self.mu[rows], None if ids is None else ids[rows])
        part.system = {name: column[rows] for name, column in self.system.items()}
        return part

    @property
    def absent(self) -> tuple[str, ...]:
        """Loads that the data lack; they are held constant."""
        return self.loads.absent

    @property
    def point_test(self) -> npt.NDArray[np.intp]:
        """Test of each point."""
        return np.repeat(self.test, self.count.astype(int))

    def varies(self, name: str) -> bool:
        """Whether a load takes more than one value."""
        column = getattr(self.loads, name)
        return bool(np.ptp(column) > 1e-9 * max(1.0, float(np.max(np.abs(column)))))


def prepare(data: pd.DataFrame, tests: pd.DataFrame | None = None) -> Campaign:
    """Check, sort and bin a table of points.

    Loads that the table lacks are filled with a constant and reported; a table without `test_id` is one test.

    Raises
    ------
    InputError
        No points, no `mu`, or values outside the physical limits.
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
        warnings.append(f"the data lack {names}: held constant, effects of these loads cannot be seen")
    if "test_id" not in frame.columns:
        warnings.append("the data have no test_id: all points count as one test")
        frame = frame.assign(test_id="all")
    frame = _without_gaps(frame, warnings)
    blank = (frame["test_id"].isna() | (frame["test_id"].astype(str).str.strip() == "")).to_numpy()
    if blank.any():
        raise InputError(f"data: column 'test_id', row {int(np.argmax(blank))}: no value; allowed: any name")
    frame = frame.assign(test_id=frame["test_id"].astype(str))
    _, rows = TriboLoads.from_frame(frame, tests).in_order(memory=False)
    frame = _without_copies(frame.iloc[rows].reset_index(drop=True), warnings)
    # the order of the table says nothing: by name, so that every choice falls on the same test
    frame = frame.sort_values("test_id", kind="stable").reset_index(drop=True)
    frame = _thinned(frame, warnings)
    loads = TriboLoads.from_frame(frame, tests)
    warnings += [*_about_order(loads), *about_table(loads)]
    measured = check_column(frame["mu"].to_numpy(), MEASURED_MU, "data")
    about_negative(measured, "data")  # refuses the wrong sign
    mu = _without_spikes(measured, frame["test_id"], warnings)
    campaign = campaign_of(loads, mu, loads.test_id)
    campaign.spikes = float(np.mean(mu != measured))
    campaign.system = metadata_columns(loads)
    campaign.warnings = warnings + _remarks(campaign)
    return campaign


def campaign_of(loads: TriboLoads, mu: FloatArray, groups: npt.NDArray[np.str_] | None) -> Campaign:
    """Bin points whose tests are consecutive; without `groups` every point is a bin of its own.

    Parameters
    ----------
    loads : TriboLoads
    mu : ndarray, shape (n,)
    groups : ndarray of str, shape (n,), or None
    """
    n = len(mu)
    if groups is None:
        index = np.arange(n)
        return Campaign(
            loads, mu, ["all"], np.array([0]), index, np.ones(n), np.zeros(n, dtype=int), index,
            np.maximum(loads.sd - loads.sd[:1], 0.0), grouped=False,
        )  # fmt: skip
    change = np.r_[True, groups[1:] != groups[:-1]]
    order = np.cumsum(change) - 1
    point_starts = np.flatnonzero(change)
    bins = int(np.clip(ALL_BINS // len(point_starts), BINS, MOST_BINS))
    progress, distance = _progress(loads, point_starts, bins)
    slot_of_point = np.minimum((bins * progress ** (1.0 / FINENESS)).astype(int), bins - 1)
    starts = np.flatnonzero(np.r_[True, (np.diff(order) > 0) | (np.diff(slot_of_point) != 0)])
    count = np.diff(np.r_[starts, n]).astype(float)
    test = order[starts]
    slot = np.arange(len(starts)) - np.flatnonzero(np.r_[True, np.diff(test) > 0])[test]
    names = [str(g) for g in groups[point_starts]]
    return Campaign(loads, mu, names, point_starts, starts, count, test, slot, distance)


def _without_gaps(frame: pd.DataFrame, warnings: list[str]) -> pd.DataFrame:
    """Return the points that have a number in every column; a table without any such point is left to be refused."""
    columns = [q.name for q in LOADS if q.name in frame.columns] + ["mu"]
    full = frame[columns].notna().all(axis=1)
    if full.all() or not full.any():
        return frame
    holding = [c for c in columns if frame[c].isna().any()]
    warnings.append(
        f"{int((~full).sum())} of {len(frame)} points have no number in {', '.join(holding)} and were left out"
    )
    return frame[full].reset_index(drop=True)


def _thinned(frame: pd.DataFrame, warnings: list[str]) -> pd.DataFrame:
    """Return every k-th point of each test where there are far more than the bins need."""
    step = len(frame) // MOST_POINTS + 1
    if step == 1:
        return frame
    place = frame.groupby("test_id", sort=False).cumcount()
    size = frame.groupby("test_id", sort=False)["mu"].transform("size")
    kept = frame[(place % step == 0) | (size <= 4 * BINS)]
    warnings.append(f"every {step}. point was used ({len(kept)} of {len(frame)})")
    return kept.reset_index(drop=True)


def _without_copies(frame: pd.DataFrame, warnings: list[str]) -> pd.DataFrame:
    """Return the tests without those that are copies of an earlier one: copies would pass for confirmation.

    No two tests agree in all loads and in mu to `SAME_VALUE` of the range of each: the noise of the sensor is larger. Tests of
    one or two points must agree exactly, in at least `TOLD_APART` columns that vary.
    """
    columns = [q.name for q in LOADS if q.name in frame.columns] + ["mu"]
    values = frame[columns].apply(pd.to_numeric, errors="coerce").to_numpy(dtype=np.float64)
    span = np.ptp(values, axis=0)
    varied = int(np.sum(span > 0.0))
    values = values / (SAME_VALUE * np.where((span > 0.0) & np.isfinite(span), span, 1.0))
    rows_of = {str(k): v for k, v in frame.groupby("test_id", sort=False).indices.items()}
    order = {name: k for k, name in enumerate(rows_of)}
    near = sorted((len(rows), float(values[rows, -1].mean()), name) for name, rows in rows_of.items())
    copies = _all_several_times({name: values[rows].tobytes() for name, rows in rows_of.items()})
    exact = True
    for k, (size, level, name) in enumerate(near):
        for other_size, other_level, other in near[k + 1 :]:
            if other_size != size or not other_level - level <= 1.0:
                break
            apart = float(np.max(np.abs(values[rows_of[other]] - values[rows_of[name]])))
            if apart <= 1.0 if size >= LEAST_COPY else apart == 0.0 and varied >= TOLD_APART:
                copies.add(max(name, other, key=order.__getitem__))
                exact = exact and apart == 0.0
    if not copies:
        return frame
    told = sorted(copies, key=order.__getitem__)
    shown = ", ".join(told[:4]) + (" ..." if len(told) > 4 else "")
    how = "exact copies of others" if exact else f"copies of others (to {SAME_VALUE:g} of the range)"
    warnings.append(f"{len(told)} tests are {how} and were left out ({shown})")
    return frame[~frame["test_id"].isin(copies)].reset_index(drop=True)


def _all_several_times(held: Mapping[str, bytes]) -> set[str]:
    """Return the surplus tests of a table that holds everything n times: some single points agree by chance, but not all."""
    alike: dict[bytes, list[str]] = {}
    for name, content in held.items():
        alike.setdefault(content, []).append(name)
    times = gcd(*map(len, alike.values()))
    if times < 2 or len(alike) < LEAST_ALIKE:
        return set()
    return {name for names in alike.values() for name in names[len(names) // times :]}


def _without_spikes(mu: FloatArray, test: pd.Series, warnings: list[str]) -> FloatArray:
    """Return mu with single points far off their neighbours replaced by the median of five around them.

    Monotone stretches pass unchanged, also steep ones: break-away and running-in are not spikes.
    """
    if len(mu) < 10:
        return mu
    windows = np.lib.stride_tricks.sliding_window_view(mu, 5)
    middle = np.median(windows, axis=1)
    names = test.to_numpy()
    same = names[4:] == names[:-4]
    distance = np.where(same, np.abs(mu[2:-2] - middle), 0.0)
    second = np.where(names[2:] == names[:-2], np.abs(np.diff(mu, 2)), np.nan)
    noise = 1.4826 / np.sqrt(6.0) * pd.Series(second).groupby(names[1:-1]).transform("median").to_numpy()
    spike = distance > np.fmax(12.0 * noise[1:-1], max(SPIKE, STEPS * _resolution(mu)))
    if not spike.any():
        return mu
    warnings.append(f"left out, far off their neighbours: {counted(int(spike.sum()), 'single point')}")
    cleaned = mu.copy()
    cleaned[2:-2][spike] = middle[spike]
    return cleaned


def _resolution(mu: FloatArray) -> float:
    """Return the step in which mu was recorded; 0 where hardly a value comes twice."""
    values = np.unique(mu)
    if len(values) < 3 or len(values) > MOST_VALUES * len(mu):
        return 0.0
    return float(np.median(np.diff(values)))


def _remarks(campaign: Campaign) -> list[str]:
    """Return what the user should know about thin data."""
    warnings, tests = [], len(campaign.tests)
    if campaign.count.size == tests:
        warnings.append(
            "one point a test (averaged data): running-in, static peak and wear-out cannot be seen at all"
        )
    if tests == 1:
        warnings.append("one test: the scatter between tests cannot be estimated; nothing here is confirmed")
    elif tests < FEW_TESTS:
        warnings.append(f"only {tests} tests: the scatter between tests is poorly known")
    for name in LOAD_NAMES:
        if name not in campaign.absent and not campaign.varies(name):
            warnings.append(f"{name} does not vary in the data: effects of {name} cannot be seen")
    return warnings


def _progress(
    loads: TriboLoads, point_starts: npt.NDArray[np.intp], bins: int
) -> tuple[FloatArray, FloatArray]:
    """Return how far each point is within its test, 0 to 1, and its distance since the start."""
    progress, distance = np.empty(len(loads)), np.empty(len(loads))
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


def _about_order(loads: TriboLoads) -> list[str]:
    """Return a warning where the distance falls within tests: points out of order."""
    if loads.test_id is None or len(loads) < 2:
        return []
    falls = (np.diff(loads.sd) < -1e-6 * max(float(np.ptp(loads.sd)), 1e-300)) & (
        loads.test_id[1:] == loads.test_id[:-1]
    )
    tests = len(np.unique(loads.test_id[1:][falls]))
    if not tests:
        return []
    return [
        f"sd falls within {tests} tests: are their points out of order? they are taken in the order of the table"
    ]
