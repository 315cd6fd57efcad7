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
    """Return the widening in each gap beside a level that lies between two others, where `model` misses that level.

    `predicted`, shape (n,), is mu by models that have not seen the test of a point, NaN where there is none. Levels at the ends of
    the domain cannot be left out: without them nothing is asked between two levels.
    """
    names, test = np.unique(groups, return_inverse=True)
    usual = _mean_errors(predicted, mu, test, len(names))
    found = []
    for j, name in enumerate(LOAD_NAMES):
        if name in domain.absent:
            continue
        column = loads.as_array()[:, j]
        order = np.argsort(column, kind="stable")
        scaled = np.asarray(feature(NumpyOps(), name, column[order]))
        places = gap_places(scaled)
        if len(places) < 2:
            continue
        ends = [(float(column[order[p - 1]]), float(column[order[p]])) for p in places]
        mean = np.bincount(test, column) / np.bincount(test)
        level = np.searchsorted([0.5 * (low + high) for low, high in ends], mean)
        missed = [0.0] * (len(ends) + 1)
        for k in range(1, len(ends)):
            missed[k] = _missed(model, loads, mu, groups, level[test] == k, usual)
        for k, (low, high) in enumerate(ends):
            if (extra := IN_THE_MIDDLE * max(missed[k], missed[k + 1])) > 0.0:
                found.append(Widening(name, low, high, min(extra, WIDEST)))
    return tuple(found)


def _missed(
    model: Any,
    loads: TriboLoads,
    mu: FloatArray,
    groups: npt.NDArray[np.str_],
    held: npt.NDArray[np.bool_],
    usual: FloatArray,
) -> float:
    """Return by how much a model that has not seen the tests `held` misses them, beyond the `usual` errors of tests left out."""
    names, test = np.unique(groups[held], return_inverse=True)
    if len(names) < LEAST_AT_LEVEL or len(np.unique(groups[~held])) < LEAST_BESIDE:
        return 0.0
    try:
        fitted = clone(model).fit(loads.take(~held), mu[~held], groups[~held])
    except InputError:  # what other levels leave cannot be fitted, and says nothing
        return 0.0
    error = _mean_errors(fitted.predict(loads.take(held)), mu[held], test, len(names))
    known = usual[np.isin(np.unique(groups), names)]
    known = known[np.isfinite(known)]
    chance = float(np.mean(known**2)) if len(known) else 0.0
    beyond = float(np.mean(error**2)) - chance
    return math.sqrt(beyond) if beyond > BY_CHANCE * math.sqrt(2.0 / len(names)) * chance else 0.0


def _mean_errors(predicted: FloatArray, mu: FloatArray, test: npt.NDArray[np.intp], tests: int) -> FloatArray:
    """Return the mean error of each test, shape (tests,); NaN where nothing is predicted of it."""
    known = np.isfinite(predicted)
    count = np.bincount(test[known], minlength=tests)
    total = np.bincount(test[known], (predicted - mu)[known], minlength=tests)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
