"""How much wider a prediction interval is between the levels of a plan, where no test measured.

A law can meet the levels of a load and miss the truth between them. By how much, a level shows that the law has not seen: a model
is fitted without the tests of one level between two others, and predicts them. What it misses there beyond the errors of tests left
out one by one is taken as the width to add in the middle of the gaps beside this level.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.base import clone

from ...common import InputError
from ...expressions.ops import NumpyOps
from ...loads import LOAD_NAMES, FloatArray, TriboLoads
from ...loads.gaps import gap_places
from ..domain import Domain
from .between_levels import MOST_ADDED, Widening
from .features import feature

#: Error in the middle of a gap, of which a prediction is half as far from a measurement as at a level that was left out: half of the
#: error there, and twice that for 95 % of the tests.
IN_THE_MIDDLE = 1.0
#: Tests whose means of a load, on the scale of its feature, lie farther apart than this share of its range are at different levels.
APART = 0.1
#: Fewest tests at a level that is left out, and beside it.
LEAST_AT_LEVEL, LEAST_BESIDE = 3, 6
#: Standard errors by which the mean square over the tests of a level must be above that of tests left out one by one.
BY_CHANCE = 2.0


def widenings(
    model: Any,
    loads: TriboLoads,
    mu: FloatArray,
    groups: npt.NDArray[np.str_],
    predicted: FloatArray,
    domain: Domain,
) -> tuple[Widening, ...]:
    """Return the widening in each gap beside a level that lies between two others; 0 where `model` does not miss that level.

    `predicted`, shape (n,), is mu by models that have not seen the test of a point, NaN where there is none. Levels at the ends of
    the domain cannot be left out: without them nothing is asked between two levels.
    """
    names, test = np.unique(groups, return_inverse=True)
    usual = _mean_errors(predicted, mu, test, len(names))
    columns = {
        name: np.asarray(feature(NumpyOps(), name, column))
        for name, column in zip(LOAD_NAMES, loads.as_array().T, strict=True)
        if name not in domain.absent
    }
    means = {name: np.bincount(test, column) / np.bincount(test) for name, column in columns.items()}
    found = []
    for name, scaled in columns.items():
        order = np.argsort(scaled, kind="stable")
        level = _levels(means[name], float(np.ptp(scaled)))
        missed: dict[int, float | None] = {0: None, int(level.max()): None}
        for place in gap_places(scaled[order]).tolist():
            low, high = order[place - 1], order[place]
            below = int(level[means[name] < 0.5 * (scaled[low] + scaled[high])].max(initial=0))
            for k in (below, below + 1):
                if k not in missed:
                    inside = _held_inside(means, name, level == k)
                    missed[k] = _missed(model, loads, mu, test, level == k, inside, usual)
            known = [miss for k in (below, below + 1) if (miss := missed.get(k)) is not None]
            if known:
                values = getattr(loads, name)
                extra = min(IN_THE_MIDDLE * max(known), MOST_ADDED)
                found.append(Widening(name, float(values[low]), float(values[high]), extra))
    return tuple(found)


def _levels(means: FloatArray, reach: float) -> npt.NDArray[np.intp]:
    """Return the level of each test, numbered from the lowest one; tests of a level lie no farther from the next one than `APART`."""
    order = np.argsort(means, kind="stable")
    level = np.empty(len(means), dtype=np.intp)
    level[order] = np.cumsum(np.r_[False, np.diff(means[order]) > APART * reach])
    return level


def _held_inside(
    means: dict[str, FloatArray], name: str, held: npt.NDArray[np.bool_]
) -> npt.NDArray[np.bool_]:
    """Return which of the tests `held` lie within the other loads of the rest, shape (tests,): beyond them is no matter of a gap."""
    inside = held.copy()
    for other, values in means.items():
        if other != name and not held.all():
            low, high = values[~held].min(), values[~held].max()
            margin = APART * (high - low)
            inside &= (values >= low - margin) & (values <= high + margin)
    return inside


def _missed(
    model: Any,
    loads: TriboLoads,
    mu: FloatArray,
    test: npt.NDArray[np.intp],
    held: npt.NDArray[np.bool_],
    inside: npt.NDArray[np.bool_],
    usual: FloatArray,
) -> float | None:
    """Return by how much a model that has not seen the tests `held` misses those `inside`, beyond the `usual` errors of tests left out.

    None where too few tests tell.
    """
    if inside.sum() < LEAST_AT_LEVEL or (~held).sum() < LEAST_BESIDE:
        return None
    rest, asked = ~held[test], inside[test]
    try:
        fitted = clone(model).fit(loads.take(rest), mu[rest], test[rest].astype(str))
    except InputError:  # what other levels leave cannot be fitted, and says nothing
        return None
    error = _mean_errors(fitted.predict(loads.take(asked)), mu[asked], test[asked], len(held))[inside]
    known = usual[inside]
    known = known[np.isfinite(known)]
    chance = float(np.mean(known**2)) if len(known) else 0.0
    beyond = float(np.mean(error**2)) - chance
    return math.sqrt(beyond) if beyond > BY_CHANCE * math.sqrt(2.0 / len(error)) * chance else 0.0


def _mean_errors(predicted: FloatArray, mu: FloatArray, test: npt.NDArray[np.intp], tests: int) -> FloatArray:
    """Return the mean error of each test, shape (tests,); NaN where nothing is predicted of it."""
    known = np.isfinite(predicted)
    count = np.bincount(test[known], minlength=tests)
    total = np.bincount(test[known], (predicted - mu)[known], minlength=tests)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
