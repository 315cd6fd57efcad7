"""Tests as units: points sorted by test and averaged into distance bins that are fine near the start."""

from __future__ import annotations

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
from ...loads.points import repeated_rows, repeated_text
from .binned_tests import BinnedTests
from .cleaning import thinned, without_copies, without_gaps, without_spikes
from .clipping import about_clipping
from .conflicting_loads import about_conflicts
from .dead_sensor import about_dead_sensor
from .load_noise import as_set, without_noise
from .load_spikes import without_load_spikes
from .metadata import about_table, metadata_columns
from .mixed_units import about_units

APART = 10.0  # largest over smallest distance of averages from which on it is not the length of the tests that differs
BINS = 19  # a test, with many tests
MOST_BINS = 120  # a test, with few tests
ALL_BINS = 2100  # of a campaign, about
FEW_TESTS = 6  # with fewer their scatter is so poorly known that "nothing is missing" is not said
FINENESS = 1.7  # exponent of the bin edges: the first bin covers about 0.7 % of the distance


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
    if (twice := repeated_rows(frame)).any():
        warnings.append(repeated_text(twice))
        frame = frame[~twice].reset_index(drop=True)
    _, rows = TriboLoads.from_frame(frame, tests).in_order(memory=False)
    frame = without_copies(frame.iloc[rows].reset_index(drop=True), warnings)
    # the order of the table says nothing: by name, so that every choice falls on the same test
    frame = frame.sort_values("test_id", kind="stable").reset_index(drop=True)
    frame = thinned(frame, 4 * BINS, warnings)
    loads = TriboLoads.from_frame(frame, tests)
    warnings += [*about_falls(frame["test_id"], loads.sd), *about_table(loads)]
    loads, lone = without_load_spikes(loads, frame["test_id"].to_numpy(dtype=str), warnings)
    measured = check_column(frame["mu"].to_numpy(), MEASURED_MU, "data")
    about_negative(measured, "data")  # refuses the wrong sign
    warnings += about_clipping(measured, frame["test_id"].to_numpy(dtype=str))
    mu = without_spikes(measured, frame["test_id"], warnings)
    campaign = campaign_of(as_set(loads), mu, loads.test_id)
    campaign.read = loads
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


def part_of(campaign: BinnedTests, rows: npt.NDArray[np.bool_]) -> BinnedTests:
    """Return the points of some tests, binned, with their metadata."""
    ids = campaign.loads.test_id
    part = campaign_of(campaign.loads.take(rows), campaign.mu[rows], None if ids is None else ids[rows])
    part.read = None if campaign.read is None else campaign.read.take(rows)
    part.system = {name: column[rows] for name, column in campaign.system.items()}
    return part


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
            column = getattr(campaign.as_read, name)
            low, high = f"{np.min(column):.4g}", f"{np.max(column):.4g}"
            how = (
                "does not vary in the data"
                if low == high
                else f"varies only as it is held ({low} to {high}{behind(QUANTITIES[name].unit)})"
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
