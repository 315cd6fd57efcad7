"""A contact temperature that stands still in some tests, where sliding heats all others: a sensor that was not connected."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...common.wording import counted, first_names
from ...loads import TriboLoads

#: Fewest points of a test of which one reading says that the sensor stood still.
LEAST_POINTS = 4
#: Share of the tests in which the temperature must move.
MOVES = 0.5


def about_dead_sensor(loads: TriboLoads, starts: npt.NDArray[np.intp], names: list[str]) -> list[str]:
    """Return a warning about tests that all have the same temperature at all points, to the last digit, where most others change it.

    `starts`, shape (tests,), is the first point of each test, `names` are the tests.

    Examples
    --------
    >>> n = np.zeros(20)
    >>> T = np.r_[np.linspace(30, 60, 5), np.linspace(30, 50, 5), np.full(10, 20.0)]
    >>> loads = TriboLoads(n + 10, T, n + 500, n, n + 1)
    >>> about_dead_sensor(loads, np.array([0, 5, 10, 15]), ["a", "b", "c", "d"])[0][:70]
    'T is 20 degC at all points of 2 tests (c, d), and changes along others'
    """
    if "T" in loads.absent:
        return []
    ends = np.r_[starts[1:], len(loads.T)]
    low, high = np.minimum.reduceat(loads.T, starts), np.maximum.reduceat(loads.T, starts)
    still = (low == high) & (ends - starts >= LEAST_POINTS)
    values, count = np.unique(low[still], return_counts=True)
    if np.mean(low < high) < MOVES or not np.any(count > 1):
        return []
    value = float(values[np.argmax(count)])
    dead = [name for name, flat, T in zip(names, still, low, strict=True) if flat and value == T]
    return [
        f"T is {value:g} degC at all points of {counted(len(dead), 'test')} ({first_names(dead)}), and changes along others: was the sensor "
        "connected? leave these tests out, or the column T"
    ]
