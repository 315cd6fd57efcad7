"""What is left out of a table before its tests are binned: gaps, copies of tests, points beyond what bins need, spikes."""

from __future__ import annotations

from collections.abc import Mapping
from math import gcd
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...common.wording import counted, first_names
from ...loads import LOADS, FloatArray

MOST_POINTS = 150_000
LEAST_COPY = 3  # points: fewer agree by chance where values are rounded
TOLD_APART = 4  # columns
LEAST_ALIKE = 5  # different tests, each of them as often as the others: the table was copied
SAME_VALUE = 1e-4  # of the range of a column: no two tests agree so well in every point
SPIKE = 0.005  # least distance in mu of a point from its neighbours that counts as a spike
NOISES = 12.0  # times the noise of its test, at least, by which a spike is off
LEAST_POINTS = 10  # of a table that is searched for spikes
STEPS = 2.5  # of the resolution: noise around the edge of a step jumps by one or two of them
MOST_VALUES = 0.1  # share of the points that differ: with fewer values mu was rounded
NEARBY = 15  # points on either side of one: a logger that rounds jumps to a value that is there, too
AGREE = 3  # points nearby of the same value, to a quarter of the distance: the value is no spike


def without_gaps(frame: pd.DataFrame, warnings: list[str]) -> pd.DataFrame:
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


def thinned(frame: pd.DataFrame, whole: int, warnings: list[str]) -> pd.DataFrame:
    """Return every k-th point of each test where there are far more than bins need; tests of at most `whole` points stay."""
    step = len(frame) // MOST_POINTS + 1
    if step == 1:
        return frame
    place = frame.groupby("test_id", sort=False).cumcount()
    size = frame.groupby("test_id", sort=False)["mu"].transform("size")
    kept = frame[(place % step == 0) | (size <= whole)]
    warnings.append(f"every {step}. point was used ({len(kept)} of {len(frame)})")
    return kept.reset_index(drop=True)


def without_copies(frame: pd.DataFrame, warnings: list[str]) -> pd.DataFrame:
    """Return the tests without those that are copies of an earlier one: copies would pass for confirmation.

    No two tests agree in all loads and in mu to `SAME_VALUE` of the range of each: the noise of the sensor is larger. Tests of
    one or two points must agree exactly, in at least `TOLD_APART` columns that vary; where others share their loads but not their mu,
    the plan has repeats, and rounded values of these agree by chance.
    """
    columns = [q.name for q in LOADS if q.name in frame.columns] + ["mu"]
    values = frame[columns].apply(pd.to_numeric, errors="coerce").to_numpy(dtype=np.float64)
    span = np.ptp(values, axis=0)
    varied = int(np.sum(span > 0.0))
    values = values / (SAME_VALUE * np.where((span > 0.0) & np.isfinite(span), span, 1.0))
    rows_of = {str(k): v for k, v in frame.groupby("test_id", sort=False).indices.items()}
    order = {name: k for k, name in enumerate(rows_of)}
    near = sorted((len(rows), float(values[rows, -1].mean()), name) for name, rows in rows_of.items())
    by_chance = varied < TOLD_APART or _repeated(values, rows_of)
    copies = _all_several_times({name: values[rows].tobytes() for name, rows in rows_of.items()})
    exact = True
    for k, (size, level, name) in enumerate(near):
        for other_size, other_level, other in near[k + 1 :]:
            if other_size != size or not other_level - level <= 1.0:
                break
            apart = float(np.max(np.abs(values[rows_of[other]] - values[rows_of[name]])))
            if apart <= 1.0 if size >= LEAST_COPY else apart == 0.0 and not by_chance:
                copies.add(max(name, other, key=order.__getitem__))
                exact = exact and apart == 0.0
    if not copies:
        return frame
    told = sorted(copies, key=order.__getitem__)
    how = "exact" if exact else f"to {SAME_VALUE:g} of the range"
    are, were = ("is a copy", "was") if len(told) == 1 else ("are copies", "were")
    warnings.append(
        f"{counted(len(told), 'test')} {are} of others ({how}) and {were} left out ({first_names(told)})"
    )
    return frame[~frame["test_id"].isin(copies)].reset_index(drop=True)


def _repeated(values: FloatArray, rows_of: Mapping[str, Any]) -> bool:
    """Return whether tests of one or two points share all loads, but not mu; `values` hold the loads and mu, shape (n, k)."""
    mu_at: dict[bytes, set[bytes]] = {}
    for rows in rows_of.values():
        if len(rows) < LEAST_COPY:
            mu_at.setdefault(values[rows, :-1].tobytes(), set()).add(values[rows, -1].tobytes())
    return any(len(different) > 1 for different in mu_at.values())


def _all_several_times(held: Mapping[str, bytes]) -> set[str]:
    """Return the surplus tests of a table that holds everything n times: some single points agree by chance, but not all."""
    alike: dict[bytes, list[str]] = {}
    for name, content in held.items():
        alike.setdefault(content, []).append(name)
    times = gcd(*map(len, alike.values()))
    if times < 2 or len(alike) < LEAST_ALIKE:
        return set()
    return {name for names in alike.values() for name in names[len(names) // times :]}


def without_spikes(mu: FloatArray, test: pd.Series, warnings: list[str]) -> FloatArray:
    """Return mu with single points far off their neighbours replaced by the median of five around them.

    Monotone stretches pass unchanged, also steep ones: break-away and running-in are not spikes. So does a value that the test has
    several times nearby: a logger that rounds the force jumps by a step, which in mu follows the pressure.
    """
    names, middle = test.to_numpy(), median_of_five(mu)
    spike = lone_points(mu, middle, names, max(SPIKE, STEPS * _resolution(mu)))
    if not spike.any():
        return mu
    warnings.append(f"left out, far off their neighbours: {lone_text(spike, names)}")
    return np.where(spike, middle, mu)


def median_of_five(values: FloatArray) -> FloatArray:
    """Return the medians of five points around each, shape (n,); of the two first and last points their values.

    Examples
    --------
    >>> median_of_five(np.array([1.0, 2.0, 9.0, 2.0, 3.0, 4.0])).tolist()
    [1.0, 2.0, 2.0, 3.0, 3.0, 4.0]
    """
    middle = values.copy()
    if len(values) > 4:
        middle[2:-2] = np.median(np.lib.stride_tricks.sliding_window_view(values, 5), axis=1)
    return middle


def lone_points(
    values: FloatArray, middle: FloatArray, names: npt.NDArray[Any], least: FloatArray | float
) -> npt.NDArray[np.bool_]:
    """Return which points lie far off the `middle` of their neighbours in a test, shape (n,).

    They are off by more than `least` (one number, or one for each point) and by far more than the noise of the test, and their value
    is not there again nearby.
    """
    if len(values) < LEAST_POINTS:
        return np.zeros(len(values), dtype=bool)
    same = np.zeros(len(values), dtype=bool)
    same[2:-2] = names[4:] == names[:-4]
    distance = np.where(same, np.abs(values - middle), 0.0)
    second = np.where(names[2:] == names[:-2], np.abs(np.diff(values, 2)), np.nan)
    noise = np.full(len(values), np.inf)
    of_test = pd.Series(second).groupby(names[1:-1]).transform("median").to_numpy()
    noise[1:-1] = 1.4826 / np.sqrt(6.0) * np.nan_to_num(of_test, nan=np.inf)
    spike = distance > np.fmax(NOISES * noise, least)
    for k in np.flatnonzero(spike):
        near = slice(max(k - NEARBY, 0), k + 1 + NEARBY)
        alike = (np.abs(values[near] - values[k]) < 0.25 * distance[k]) & (names[near] == names[k])
        spike[k] = np.count_nonzero(alike) <= AGREE  # itself is one of them
    return np.asarray(spike)


def lone_text(spike: npt.NDArray[np.bool_], names: npt.NDArray[Any]) -> str:
    """Return how many points are alone, and in which tests, those with most of them first."""
    told, count = np.unique(names[spike].astype(str), return_counts=True)
    where = first_names(list(told[np.argsort(-count, kind="stable")]))
    return f"{counted(int(spike.sum()), 'single point')} (test {where})"


def _resolution(mu: FloatArray) -> float:
    """Return the step in which mu was recorded; 0 where hardly a value comes twice."""
    values = np.unique(mu)
    if len(values) < 3 or len(values) > MOST_VALUES * len(mu):
        return 0.0
    return float(np.median(np.diff(values)))
