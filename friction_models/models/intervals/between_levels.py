"""How much wider a prediction interval is between the levels of a plan, where no test measured.

A law can meet the levels of a load and miss the truth between them. By how much, a level shows that the law has not seen: a model
is fitted without the tests of one level between two others, and predicts them. What it misses there beyond the errors of tests left
out one by one is taken as the width to add in the middle of the gaps beside this level.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.base import clone

from ...common import InputError
from ...common.json_values import JsonObject
from ...expressions.ops import NumpyOps, Ops, Value
from ...expressions.parameters import check_number
from ...loads import LOAD_NAMES, FloatArray, TriboLoads
from ...loads.gaps import gap_places
from ..domain import Domain
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
#: Largest width in mu that is read from a file.
WIDEST = 10.0


@dataclass(frozen=True)
class Widening:
    """A gap between two levels of a load, and what is added to half the width of an interval in its middle.

    Examples
    --------
    >>> import numpy as np
    >>> between = Widening("T", 100.0, 200.0, 0.004)
    >>> between.at(NumpyOps(), np.array([50.0, 100.0, 125.0, 150.0, 190.0])).round(4).tolist()
    [0.0, 0.0, 0.002, 0.004, 0.0008]
    """

    load: str
    low: float  #: Levels, in the unit of the load.
    high: float
    extra: float  #: In mu.

    def at(self, x: Ops, column: Value) -> Value:
        """Return what is added at values of the load, with either back end; falls to 0 at both levels."""
        low, high = (float(feature(NumpyOps(), self.load, np.array(v))) for v in (self.low, self.high))
        place = feature(x, self.load, column)
        share = x.minimum(place - low, high - place) * (2.0 / (high - low))
        return x.maximum(share, 0.0) * self.extra

    def to_dict(self) -> JsonObject:
        """Return it as JSON holds it."""
        return asdict(self)

    @classmethod
    def from_dict(cls, content: Any) -> Widening:
        """Build from `to_dict`. Raises InputError: a value is missing, no number, or outside its limits."""
        if not isinstance(content, dict) or content.get("load") not in LOAD_NAMES:
            raise InputError(
                f"interval: between = {content!r:.60}; allowed: load ({', '.join(LOAD_NAMES)}), low, high, extra"
            )
        low, high, extra = (
            check_number("interval", f"between.{key}", content.get(key), *limits)
            for key, limits in (("low", (-1e4, 1e9)), ("high", (-1e4, 1e9)), ("extra", (0.0, WIDEST)))
        )
        with np.errstate(invalid="ignore", divide="ignore"):  # no load, which is told below
            ends = [float(feature(NumpyOps(), content["load"], np.array(v))) for v in (low, high)]
        if not (np.isfinite(ends).all() and ends[1] > ends[0]):
            raise InputError(
                f"interval: between.low = {low:g}, high = {high:g}; allowed: low below high, both loads"
            )
        return cls(content["load"], low, high, extra)


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
                extra = min(IN_THE_MIDDLE * max(known), WIDEST)
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
