"""Learning curves: error on held-out tests over the number of training tests, and how many tests an accuracy needs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise

import numpy as np

from ..common import InputError
from ..loads import FloatArray

#: Share of the repeats whose error lies below the curve.
PROBABILITY = 0.95
#: Resamples and level of the intervals.
RESAMPLES, LEVEL = 2000, 0.95
#: An error of 0 has no logarithm.
TINY = 1e-12


@dataclass(frozen=True)
class NeededTests:
    """Number of training tests from which on an accuracy is kept.

    Examples
    --------
    >>> NeededTests(0.01, 21.3, at_most=False, lower=17.2, upper=30.0, reached=1.0).text()
    '22 (18 - 30)'
    >>> NeededTests(0.01, None, at_most=False, lower=None, upper=None, reached=0.0).text()
    'not reached'
    """

    #: Error that the curve has to stay below.
    accuracy: float
    #: Where the curve, a power law between its sizes, falls below it for good; None where it never does.
    tests: float | None
    #: Whether the smallest size suffices already, so that fewer tests might.
    at_most: bool
    #: Interval by resampling repeats and held-out tests; None at the top where it is open.
    lower: float | None
    upper: float | None
    #: Share of the resamples that reach the accuracy at all.
    reached: float

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        return asdict(self)

    def text(self) -> str:
        """Return the number with its interval, as one writes it in a table."""
        if self.tests is None:
            return "not reached" if self.reached < 0.5 * (1 - LEVEL) else f"not reached ({self.reached:.0%})"
        smallest = self.lower == self.upper == self.tests
        if self.at_most and smallest:
            return f"<= {math.ceil(self.tests)}"
        sign = "<= " if self.at_most else ""
        upper = ">" if self.upper is None else f"{math.ceil(self.upper)}"
        lower = "?" if self.lower is None else f"{math.ceil(self.lower)}"
        return f"{sign}{math.ceil(self.tests)} ({lower} - {upper})"


def growing_sets(tests: Sequence[str], repeats: int, seed: int) -> list[list[str]]:
    """Return for each repeat all tests in a random order; its training set of n tests is the first n.

    So a training set grows by further tests, and every model and data collection sees the same sets.

    Examples
    --------
    >>> sets = growing_sets(["a", "b", "c"], repeats=2, seed=0)
    >>> [sorted(tests) for tests in sets]
    [['a', 'b', 'c'], ['a', 'b', 'c']]
    """
    ordered = sorted(tests)
    return [np.random.default_rng([seed, k]).permutation(ordered).tolist() for k in range(repeats)]


def percentile_curve(errors: FloatArray, probability: float = PROBABILITY) -> FloatArray:
    """Return the error that a share of the repeats stays below, shape (sizes,).

    Linear between the ordered repeats: of ten, the 0.95 percentile lies between the two worst.

    Parameters
    ----------
    errors : ndarray, shape (repeats, sizes) or (repeats, sizes, tests)
        MAE, or what each held-out test contributes to it: the mean over the tests is the MAE.
    probability : float

    Examples
    --------
    >>> errors = np.array([[0.5, 0.25], [0.25, 0.125], [0.0, 0.0]])
    >>> percentile_curve(errors, probability=0.5).tolist()
    [0.25, 0.125]
    """
    matrix = errors if errors.ndim == 2 else errors.mean(axis=2)
    return np.asarray(np.quantile(matrix, probability, axis=0), dtype=np.float64)


def needed_tests(sizes: Sequence[int], curve: FloatArray, accuracy: float) -> float | None:
    """Return the number of tests from which on a curve stays below `accuracy`, None where it does not.

    Between the sizes a power law, as learning curves fall; a curve that is below everywhere gives the
    smallest size.

    Examples
    --------
    An error that is halved whenever the number of tests doubles has fallen to a third at three times as many:

    >>> curve = np.array([0.04, 0.02, 0.01])
    >>> round(needed_tests([10, 20, 40], curve, 0.04 / 3), 6)
    30.0
    >>> needed_tests([10, 20, 40], curve, 0.005) is None
    True
    """
    above = np.flatnonzero(~(curve < accuracy))
    if len(above) == 0:
        return float(sizes[0])
    last = int(above[-1])
    if last == len(curve) - 1:
        return None
    return _between(sizes, last, float(curve[last]), float(curve[last + 1]), accuracy)


def _between(sizes: Sequence[int], last: int, above: float, below: float, accuracy: float) -> float:
    """Return where the power law between two sizes, `last` the first of them, has an accuracy; its errors there are given."""
    high, low = math.log(max(above, TINY)), math.log(max(below, TINY))
    share = (high - math.log(max(accuracy, TINY))) / (high - low) if high > low else 1.0
    return float(sizes[last] * (sizes[last + 1] / sizes[last]) ** share)


def needed_with_interval(
    sizes: Sequence[int], errors: FloatArray, accuracy: float, seed: int = 0
) -> NeededTests:
    """Return the number of tests needed and its interval from resampled repeats and held-out tests.

    Parameters
    ----------
    sizes : sequence of int
        Growing numbers of training tests.
    errors : ndarray, shape (repeats, sizes) or (repeats, sizes, tests)
        As for `percentile_curve`; without the third axis only repeats are drawn. A repeat is drawn as a whole: its
        training sets grow out of each other. Few repeats know little of their worst case, so the interval is rather
        too narrow than too wide.
    accuracy : float
    seed : int
        Of the resamples.

    Raises
    ------
    InputError
        Sizes that do not grow, or errors of another shape.

    Examples
    --------
    >>> errors = np.array([[0.04, 0.01], [0.04, 0.01]])
    >>> found = needed_with_interval([10, 40], errors, accuracy=0.02)
    >>> round(found.tests, 6), found.reached
    (20.0, 1.0)
    """
    matrix = np.asarray(errors, dtype=np.float64)
    if matrix.ndim not in {2, 3} or matrix.shape[1] != len(sizes) or not matrix.size:
        raise InputError(
            f"learning curve: errors of shape {matrix.shape}; allowed: repeats x {len(sizes)} sizes (x tests)"
        )
    if any(b <= a for a, b in pairwise(sizes)):
        raise InputError(f"learning curve: sizes {list(sizes)}; allowed: growing numbers of tests")
    curve = percentile_curve(matrix)
    found = needed_tests(sizes, curve, accuracy)
    drawn = _needed_by_draw(sizes, matrix, accuracy, seed)
    low, high = np.quantile(drawn, [0.5 * (1 - LEVEL), 0.5 * (1 + LEVEL)], method="inverted_cdf").tolist()
    return NeededTests(
        accuracy,
        found,
        bool((curve < accuracy).all()),
        low if math.isfinite(low) else None,
        high if math.isfinite(high) else None,
        float(np.mean(np.isfinite(drawn))),
    )


def lowest_error(errors: FloatArray, seed: int = 0) -> tuple[float, float, float]:
    """Return the lowest point of the percentile curve and its interval from resampled repeats and held-out tests."""
    matrix = np.asarray(errors, dtype=np.float64)
    drawn = _resampled(matrix, seed).min(axis=1)
    low, high = np.quantile(drawn, [0.5 * (1 - LEVEL), 0.5 * (1 + LEVEL)]).tolist()
    return float(percentile_curve(matrix).min()), low, high


def share_fewer(
    sizes: Sequence[int], errors: FloatArray, others: FloatArray, accuracy: float, seed: int = 0
) -> tuple[float, float]:
    """Return in which shares of the resamples `errors` needs at least one test fewer, or more, than `others`.

    Both have one shape, as for `percentile_curve`, and belong to the same training and held-out tests, so these are
    drawn for both. Where neither reaches the accuracy, neither needs fewer.
    """
    one, other = np.asarray(errors, dtype=np.float64), np.asarray(others, dtype=np.float64)
    if one.shape != other.shape:
        raise InputError(
            f"learning curve: errors of shapes {one.shape} and {other.shape}; allowed: equal shapes"
        )
    first, second = (_needed_by_draw(sizes, e, accuracy, seed) for e in (one, other))
    fewer = np.isfinite(first) & (first <= second - 1.0)
    more = np.isfinite(second) & (second <= first - 1.0)
    return float(np.mean(fewer)), float(np.mean(more))


def _needed_by_draw(sizes: Sequence[int], matrix: FloatArray, accuracy: float, seed: int) -> FloatArray:
    """Return the tests needed in each resample, infinite where the accuracy is not reached."""
    curves = _resampled(matrix, seed)
    above = ~(curves < accuracy)
    found = np.where(above.any(axis=1), math.inf, float(sizes[0]))
    # One by one only where a curve falls below between two sizes; a page asks for millions of them.
    (rows,) = np.nonzero(above.any(axis=1) & ~above[:, -1])
    last = len(sizes) - 1 - np.argmax(above[rows, ::-1], axis=1)
    ends = zip(last.tolist(), curves[rows, last].tolist(), curves[rows, last + 1].tolist(), strict=True)
    found[rows] = [_between(sizes, *end, accuracy) for end in ends]
    return found


def _resampled(matrix: FloatArray, seed: int) -> FloatArray:
    """Return the percentile curve of each resample of whole repeats and held-out tests, shape (resamples, sizes)."""
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, len(matrix), (RESAMPLES, len(matrix)))
    if matrix.ndim == 2:
        drawn = matrix[rows]
    else:
        tests = matrix.shape[2]
        share = rng.multinomial(tests, np.full(tests, 1.0 / tests), RESAMPLES) / tests
        by_draw = np.tensordot(share, matrix, axes=(1, 2))
        drawn = by_draw[np.arange(RESAMPLES)[:, None], rows]
    return np.asarray(np.quantile(drawn, PROBABILITY, axis=1), dtype=np.float64)
