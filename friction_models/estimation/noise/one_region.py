"""Tests that lie far off together, in one corner of the loads: a law that nothing else shows, perhaps, and no faults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product

import numpy as np
from scipy.stats import rankdata

from ...common.wording import listed
from ...loads import FloatArray

#: The corner may hold so many tests for each of those that lie off.
FOR_EACH = 2


def region_of(levels: Mapping[str, FloatArray], odd: Sequence[int], off: FloatArray) -> str:
    """Return the corner of the loads in which all `odd` tests lie that are `off` to one side, in words; empty where there is none.

    Parameters
    ----------
    levels : mapping of str to array, shape (tests,)
        Mean loads of the tests.
    odd : sequence of int
        Numbers of the tests that lie far off.
    off : array, shape (tests,)
        How far each test lies off.

    Examples
    --------
    >>> v_rel, T = np.arange(10.0), np.array([3.0, 1.0, 4.0, 1.0, 5.0, 2.0, 6.0, 5.0, 3.0, 5.0])
    >>> region_of({"v_rel": v_rel, "T": T}, [7, 9], np.ones(10))
    'high v_rel'
    >>> region_of({"v_rel": v_rel, "T": T}, [2, 9], np.ones(10))
    ''
    """
    odd = list(odd)
    if len(odd) < 2 or abs(np.sign(off[odd]).sum()) < len(odd):
        return ""
    for words, depth in _corners(levels):
        if int(np.sum(depth >= depth[odd].min())) <= FOR_EACH * len(odd):
            return words
    return ""


def _corners(levels: Mapping[str, FloatArray]) -> Iterator[tuple[str, FloatArray]]:
    """Give each end of a load, then each corner of two, with how deep in it every test lies."""
    ends = {}
    for name, level in levels.items():
        ends[name] = {"high": rankdata(level), "low": rankdata(-level)}
        yield from ((f"{side} {name}", depth) for side, depth in ends[name].items())
    for first, second in combinations(ends, 2):
        for a, b in product(("high", "low"), repeat=2):
            yield listed([f"{a} {first}", f"{b} {second}"]), np.minimum(ends[first][a], ends[second][b])
