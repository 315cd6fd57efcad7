"""Splits by whole tests: points of one test are never on both sides."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ..common import InputError

Mask = npt.NDArray[np.bool_]
#: With fewer tests a held-out part says nothing.
FEWEST_TESTS = 4


def hold_out(
    groups: npt.NDArray[np.str_] | None, points: int, fraction: float, seed: int
) -> tuple[Mask, Mask]:
    """Return masks (train, held out) that keep tests whole.

    Parameters
    ----------
    groups : ndarray of str, shape (points,), or None
        Test of each point. Without tests, or with fewer than four, nothing is held out.
    points : int
    fraction : float
        Share of the tests to hold out; at least one test (unless it is 0), never all.
    seed : int
        Chooses the tests; the same tests whatever the order of the points.

    Examples
    --------
    >>> tests = np.repeat(["a", "b", "c", "d", "e"], 3)
    >>> train, held = hold_out(tests, len(tests), 0.2, seed=0)
    >>> int(held.sum()), len(set(tests[held]))
    (3, 1)
    """
    held = np.zeros(points, dtype=bool)
    if groups is not None and fraction > 0:
        tests = np.unique(groups)
        if len(tests) >= FEWEST_TESTS:
            count = min(max(1, round(fraction * len(tests))), len(tests) - 1)
            chosen = np.random.default_rng(seed).choice(tests, count, replace=False)
            held = np.isin(groups, chosen)
    return ~held, held


def k_fold(groups: npt.NDArray[np.str_], folds: int = 5, seed: int = 0) -> Iterator[tuple[Mask, Mask]]:
    """Yield masks (train, held out), each test held out once.

    Parameters
    ----------
    groups : ndarray of str, shape (n,)
        Test of each point.
    folds : int
        2 to the number of tests.
    seed : int
        Shuffles the tests.

    Raises
    ------
    InputError
        More folds than tests, or fewer than two.

    Examples
    --------
    >>> tests = np.repeat(["a", "b", "c", "d"], 2)
    >>> [(int(train.sum()), int(held.sum())) for train, held in k_fold(tests, folds=4)]
    [(6, 2), (6, 2), (6, 2), (6, 2)]
    """
    tests = np.unique(groups)
    if not 2 <= folds <= len(tests):
        raise InputError(f"k-fold: {folds} folds with {len(tests)} tests; allowed: 2 to the number of tests")
    shuffled = np.random.default_rng(seed).permutation(tests)
    for part in np.array_split(shuffled, folds):
        held = np.isin(groups, part)
        yield ~held, held
