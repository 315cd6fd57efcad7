"""Tests whose loads are recorded in another unit than those of the others: GPa among MPa, m/s among mm/s."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...common.wording import counted, first_names
from ...loads import FloatArray, TriboLoads
from ...loads.contract import QUANTITIES

#: Loads that have a natural zero, and are recorded in units a thousand times larger, too.
SCALED = ("v_rel", "sigma_n", "sd")
#: Powers of ten: between two groups of tests, at least, and by how far their medians may be off a thousand. Plans step less.
GAP, OFF = 1.5, 0.5


def about_units(loads: TriboLoads, starts: npt.NDArray[np.intp], names: list[str]) -> list[str]:
    """Return a warning for each load of which some tests lie about a thousand times lower, or higher, than the others.

    `starts`, shape (tests,), is the first point of each test, and `names` are the tests.

    Examples
    --------
    >>> p, one = np.array([300.0, 900.0, 0.5, 600.0]), np.ones(4)
    >>> about_units(TriboLoads(50 * one, 80 * one, p, one, one), np.arange(4), ["a", "b", "c", "d"])
    ['sigma_n of 1 test (c) is about a thousand times smaller than that of the others: is it in another unit? MPa is expected']
    """
    said = []
    for name in SCALED:
        if name in loads.absent:
            continue
        means = means_of_tests(getattr(loads, name), starts)
        if len(means) < 3 or means.min() <= 0.0:
            continue
        order = np.argsort(means, kind="stable")
        size = np.log10(means[order])
        k = int(np.argmax(np.diff(size))) + 1
        apart = float(np.median(size[k:]) - np.median(size[:k]))
        if size[k] - size[k - 1] < GAP or abs(apart - 3.0) > OFF:
            continue
        few, way = (order[:k], "smaller") if 2 * k <= len(order) else (order[k:], "larger")
        they = "is it" if len(few) == 1 else "are they"
        told = f"{counted(len(few), 'test')} ({first_names([names[j] for j in sorted(few)])})"
        said.append(
            f"{name} of {told} is about a thousand times {way} than that of the others: {they} in another unit? "
            f"{QUANTITIES[name].unit} is expected"
        )
    return said


def means_of_tests(values: FloatArray, starts: npt.NDArray[np.intp]) -> FloatArray:
    """Return the mean of the points of each test, shape (tests,); `starts` is the first point of each."""
    return np.asarray(np.add.reduceat(values, starts) / np.diff(np.r_[starts, len(values)]))
