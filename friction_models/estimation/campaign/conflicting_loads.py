"""Loads that contradict each other, or what the table of tests says was set: a wrong unit, or columns that are exchanged."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise, permutations

import numpy as np
import numpy.typing as npt

from ...common.wording import counted, first_names
from ...loads import FloatArray, TriboLoads
from ...loads.contract import POINT_UNITS, SET_BY, SETTING_UNITS
from .mixed_units import means_of_tests

#: Powers of ten by which a distance may differ from speed times time: few points, and machines that hold a speed badly.
OFF = 0.7
#: 0 degC [K], and how far a test may start from the temperature of its tool [K].
KELVIN, START = 273.15, 40.0
#: The same of most tests, which heat little before the first point [K].
OFFSET = 15.0
#: Share of the largest setting within which a load agrees with it, and which another one misses by much.
AGREES, MISSES = 0.15, 0.5
#: Surfaces that shrink by less may be rounding; no forming stretches one by more.
LEAST_PSI, MOST_PSI = 0.98, 50.0


def about_conflicts(
    loads: TriboLoads, starts: npt.NDArray[np.intp], names: list[str], settings: Mapping[str, FloatArray]
) -> list[str]:
    """Return warnings about loads that cannot all be right.

    `starts`, shape (tests,), is the first point of each test, `names` are the tests, and `settings` what the table of tests
    holds, by column, shape (n, 1) each.

    Examples
    --------
    Two tests at 50 mm/s for a second, the second of which has its distance in metres:

    >>> t, sd, one = np.array([0.0, 1.0, 0.0, 1.0]), np.array([0.0, 50.0, 0.0, 0.05]), np.ones(4)
    >>> loads = TriboLoads(50.0 * one, 80.0 * one, 900.0 * one, sd, one, t, ["a", "a", "b", "b"])
    >>> about_conflicts(loads, np.array([0, 2]), ["a", "b"], {})
    ['sd of 1 test (b) grows 0.001 times as far as v_rel gives over t: one of them is in another unit; mm, mm/s and s are expected']
    """
    said = [*_about_distance(loads, starts, names), *_about_standing(loads, starts, names)]
    held = {name: column[starts, 0] for name, column in settings.items()}
    if "T" not in loads.absent and "T_tool" in held:
        said += _about_kelvin(loads.T[starts] - held["T_tool"], names)
    means = {n: means_of_tests(getattr(loads, n), starts) for n in SET_BY if n not in loads.absent}
    exchanged: dict[frozenset[str], str] = {}
    for a, b in permutations(means, 2):
        if SET_BY[a] in held and _is_set(means[b], held[SET_BY[a]], means[a]):
            exchanged[frozenset((a, b))] = (
                f"{b} is what {SET_BY[a]} says, and {a} is not: are they exchanged? {a} is expected in {POINT_UNITS[a]}, "
                f"{b} in {POINT_UNITS[b]}"
            )
    said += exchanged.values()
    if "psi" not in loads.absent and loads.psi.min() < LEAST_PSI:
        shrunk = np.minimum.reduceat(loads.psi, starts) < LEAST_PSI
        said.append(
            f"psi of {_tests(shrunk, names)} falls to {loads.psi.min():.3g}: below 1 the surface shrinks; psi is the new over the old area"
        )
    if "psi" not in loads.absent and loads.psi.max() > MOST_PSI:
        large = np.maximum.reduceat(loads.psi, starts) > MOST_PSI
        said.append(
            f"psi of {_tests(large, names)} reaches {loads.psi.max():.3g}: no forming stretches a surface that far; psi is the new over the old "
            "area: are columns exchanged?"
        )
    return said


def distance_by_speed(loads: TriboLoads, starts: npt.NDArray[np.intp]) -> FloatArray:
    """Return the decadic logarithm of the distance of each test over what speed and time give, shape (tests,); NaN where nothing tells.

    It is that of most steps from point to point: a rest in a test takes time, and no way.
    """
    ratio = np.full(len(starts), np.nan)
    if loads.t is None or {"v_rel", "sd"}.intersection(loads.absent):
        return ratio
    path = 0.5 * (loads.v_rel[1:] + loads.v_rel[:-1]) * np.diff(loads.t)
    slid = np.diff(loads.sd)
    moved = (path > 0.0) & (slid > 0.0)
    moved[starts[1:] - 1] = False  # from one test to the next
    for test, (a, b) in enumerate(pairwise([*starts, len(loads)])):
        steps = a + np.flatnonzero(moved[a : b - 1])
        if len(steps):
            ratio[test] = np.median(np.log10(slid[steps] / path[steps]))
    return ratio


def _about_standing(loads: TriboLoads, starts: npt.NDArray[np.intp], names: list[str]) -> list[str]:
    """Return a warning where the distance of tests grows that never move by their speed."""
    if {"v_rel", "sd"}.intersection(loads.absent):
        return []
    lasts = np.r_[starts[1:], len(loads)] - 1
    standing = (np.maximum.reduceat(loads.v_rel, starts) <= 0.0) & (loads.sd[lasts] > loads.sd[starts])
    if not standing.any():
        return []
    return [f"sd of {_tests(standing, names)} grows though v_rel is 0 all the time: was the speed recorded?"]


def _about_distance(loads: TriboLoads, starts: npt.NDArray[np.intp], names: list[str]) -> list[str]:
    """Return a warning where the distance of some tests, or of all, is not what speed and time give."""
    ratio = np.nan_to_num(distance_by_speed(loads, starts))
    off = np.abs(ratio) > OFF
    if not off.any():
        return []
    lowest, highest = (float(f"{10.0**r:.2g}") for r in (ratio[off].min(), ratio[off].max()))
    if highest > 10.0**OFF * lowest:
        return [
            f"sd of {_tests(off, names)} grows {lowest:g} to {highest:g} times as far as v_rel gives over t, from test to test: one of them is "
            "not what its name says"
        ]
    times = float(f"{10.0 ** np.median(ratio[off]):.2g}")
    units = [POINT_UNITS[n] for n in ("sd", "v_rel", "t")]
    return [
        f"sd of {_tests(off, names)} grows {times:g} times as far as v_rel gives over t: one of them is in another unit; "
        f"{units[0]}, {units[1]} and {units[2]} are expected"
    ]


def _about_kelvin(above: FloatArray, names: list[str]) -> list[str]:
    """Return a warning where tests start as far `above` the temperature of their tool [K] as K and degC lie apart, and the others near it."""
    unit = SETTING_UNITS["T_tool"]
    return [
        f"{name} of {_tests(far, names)} starts {np.median(sign * above[far]):.0f} above {other}: is it in K? {unit} is expected"
        for name, other, sign in (("T", "T_tool", 1.0), ("T_tool", "T", -1.0))
        if (far := np.abs(sign * above - KELVIN) < START).any()
        and abs(np.median(sign * above[far]) - KELVIN) < OFFSET
        and np.all(far | (np.abs(above) < 2.0 * START))
    ]


def _is_set(mean: FloatArray, setting: FloatArray, other: FloatArray) -> bool:
    """Return whether the means of a load over the tests follow a setting of several levels that another load misses."""
    scale = float(np.max(np.abs(setting)))
    if not np.ptp(setting) > MISSES * scale:
        return False
    return bool(
        np.all(np.abs(mean - setting) < AGREES * scale)
        and np.median(np.abs(other - setting)) > MISSES * scale
    )


def _tests(which: npt.NDArray[np.bool_], names: list[str]) -> str:
    """Return tests as one says them."""
    if which.all():
        return "all tests" if len(names) > 1 else f"the test {names[0]}"
    return f"{counted(int(which.sum()), 'test')} ({first_names([names[k] for k in np.flatnonzero(which).tolist()])})"
