"""Prediction intervals of mu: how far a measurement of a NEW test may lie from the model.

The points of one test share an offset, so a data set of 81 tests knows about 81 independent errors, not 44 550.
Every test is predicted by a model that has not seen it (folds of whole tests); the interval is the quantile of
these errors with equal weight on every test and the correction for one test more [1]_. Where the errors
depend on the loads beyond doubt, they are divided by a log-linear function of the loads first [2]_.

References
----------
.. [1] Lee, Barber, Willett (2023), Distribution-free inference with hierarchical data, arXiv:2306.06342;
   Dunn, Wasserman, Ramdas (2022), J. Am. Stat. Assoc. 118: 2491.
.. [2] Lei, G'Sell, Rinaldo, Tibshirani, Wasserman (2018), J. Am. Stat. Assoc. 113: 1094, section 5.2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from ...common import InputError
from ...common.json_values import JsonObject
from ...expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ...expressions.parameters import check_integer, check_number
from ...loads import LOAD_NAMES, FloatArray
from ..domain import Domain
from .between_levels import Widening
from .features import feature, feature_ranges

if TYPE_CHECKING:
    import pandas as pd

#: Output of the ONNX file: half the width of the interval before the cut at 0.
MARGIN = "mu_margin"
#: Outputs of an FMU, and columns of a table: the bounds of mu.
BOUNDS = ("mu_low", "mu_high")
#: Level of an interval unless another one is asked for, and the levels that make sense.
LEVEL = 0.95
LOWEST_LEVEL, HIGHEST_LEVEL = 0.5, 0.999
#: Probabilities at which the distribution of the errors is kept; the tail more finely.
PROBABILITIES = np.unique(np.r_[np.linspace(0.0, 1.0, 101), np.linspace(0.9, 1.0, 101)])
#: Below this size (in mu) an error is taken as this: a model that fits exactly has no logarithm.
SMALLEST_ERROR = 1e-9
#: Fewest whole tests that say anything about a further one.
LEAST_TESTS = 4
#: What is kept of a measured coverage; see `interval_coverage.coverage_measures`.
MEASURES = ("expected", "share", "share_low", "share_high", "points", "worst_test", "tests", "mean_width")
MOST_ROLES, LONGEST_TEXT, MOST_GAPS = 100, 200, 20
#: Largest size of constant and slopes: the slope of a load that hardly varies is steep, and the constant makes up for it.
LARGEST = 1e8
#: Largest logarithm of the width inside the domain: beyond it no width is one, and the graph would overflow.
WIDEST = 50.0


class IntervalNumbers(TypedDict):
    """What a model card shows of an interval; `slopes` by load, `coverage` by role, `between` as `Widening` writes it."""

    level: float
    method: str
    source: str
    tests: int
    points: int
    factor: float
    constant: float
    slopes: dict[str, float]
    coverage: dict[str, dict[str, float]]
    between: list[JsonObject]


@dataclass(frozen=True)
class PredictionInterval:
    """The calibrated interval of one model; symmetric around mu, cut at 0.

    ``margin = factor(level) * exp(constant + slopes . features) * (1 + distance) + between``: the features are those of
    `feature` at the nearest point of the trained domain, and `distance` is how far the loads lie outside
    of it. Outside the domain nothing was measured: there the growth is a convention and no coverage is promised. `between` is
    the sum of the widenings in the gaps of the plan.

    Examples
    --------
    Ten tests whose errors are spread evenly up to 0.02 (the scores, in units of a width of 1):

    >>> interval = PredictionInterval(
    ...     level=0.8,
    ...     tests=10,
    ...     points=100,
    ...     constant=0.0,
    ...     slopes=(0.0,) * 5,
    ...     scores=tuple(0.02 * PROBABILITIES),
    ...     source="an example",
    ...     coverage={},
    ... )
    >>> interval.method(), interval.method(0.95)
    ('conformal', 'student')
    >>> round(interval.factor(), 4)
    0.0176
    """

    #: Share of the points of new tests that the interval is to hold, unless another one is asked for.
    level: float
    #: Whole tests, and points of them, whose errors were measured.
    tests: int
    points: int
    constant: float
    #: Of the logarithm of the width; all 0 where the data does not support a dependence.
    slopes: tuple[float, ...]
    #: Distribution of the errors in units of the width, each test counted alike, at `PROBABILITIES`.
    scores: tuple[float, ...]
    #: Where the errors come from.
    source: str
    #: Measured coverage by role of the tests; see `interval_coverage.coverage_measures`.
    coverage: Mapping[str, Mapping[str, float]]
    #: What is added between the levels of a plan, where a fit without a level was asked; 0 where it did not miss that level.
    between: tuple[Widening, ...] = ()

    def method(self, level: float | None = None) -> str:
        """Return ``conformal``, or ``student`` where the tests are too few for the level."""
        wanted = self.level if level is None else check_level(level)
        return "conformal" if wanted * (self.tests + 1) <= self.tests else "student"

    def factor(self, level: float | None = None) -> float:
        """Return the factor on the width at a level.

        Conformal: the quantile at ``level (K + 1) / K`` for K tests. With too few tests for that (fewer than 19 at
        0.95) the interval of a normal distribution: Student's t with K - 1 degrees of freedom.
        """
        wanted = self.level if level is None else check_level(level)
        scores, k = np.array(self.scores), self.tests
        if self.method(wanted) == "conformal":
            place = int(np.searchsorted(PROBABILITIES, wanted * (k + 1) / k - 1e-12))
            return float(scores[min(place, len(scores) - 1)])
        from scipy.special import stdtrit

        middle = 0.5 * (scores[1:] + scores[:-1])
        size = math.sqrt(float(middle**2 @ np.diff(PROBABILITIES)))
        return float(stdtrit(k - 1, 0.5 * (1.0 + wanted))) * math.sqrt(1.0 + 1.0 / k) * size

    def margin(self, x: Ops, L: LoadColumns, domain: Domain, level: float | None = None) -> Value:
        """Return half the width of the interval before the cut at 0, [n, 1], with either back end."""
        width: Value = self.constant + math.log(max(self.factor(level), SMALLEST_ERROR))
        outside: Value = 0.0
        inside = []
        limits = zip(LOAD_NAMES, L.columns(), domain.lower, domain.upper, domain.scale)
        for name, column, low, high, scale in limits:
            if name not in domain.absent:
                beyond = x.maximum(low - column, column - high) * (1.0 / float(scale))
                outside = x.maximum(outside, beyond)
            inside.append(x.minimum(x.maximum(column, low), high))
        for name, slope in zip(LOAD_NAMES, self.slopes):
            if slope != 0.0:
                width = width + slope * feature(x, name, inside[LOAD_NAMES.index(name)])
        added: Value = 0.0
        for widening in self.between:
            if widening.extra > 0.0:
                added = added + widening.at(x, inside[LOAD_NAMES.index(widening.load)])
        return x.exp(width) * (1.0 + outside) + added

    def margins(self, loads: FloatArray, domain: Domain, level: float | None = None) -> FloatArray:
        """Return `margin` at loads of shape (n, 5) as an array of shape (n,)."""
        if len(loads) == 0:
            return np.empty(0)
        x = NumpyOps()
        return np.asarray(self.margin(x, LoadColumns.from_matrix(x, loads), domain, level))[:, 0]

    def with_coverage(self, role: str, measures: Mapping[str, float]) -> PredictionInterval:
        """Return the interval with a further measured coverage."""
        return replace(self, coverage=dict(self.coverage) | {role: dict(measures)})

    def summary(self) -> IntervalNumbers:
        """Return what the model card shows."""
        return {
            "level": self.level,
            "method": self.method(),
            "source": self.source,
            "tests": self.tests,
            "points": self.points,
            "factor": self.factor(),
            "constant": self.constant,
            "slopes": dict(zip(LOAD_NAMES, self.slopes)),
            "coverage": {role: dict(m) for role, m in self.coverage.items()},
            "between": [w.to_dict() for w in self.between],
        }

    def to_dict(self) -> dict[str, object]:
        """Return everything as JSON holds it."""
        return self.summary() | {"scores": list(self.scores)}

    @classmethod
    def from_dict(cls, content: JsonObject, domain: Domain) -> PredictionInterval:
        """Build from `to_dict`, for a model trained on `domain`.

        Raises InputError: a value is missing, not a finite number or outside its limits; the width overflows
        in the domain.
        """
        try:
            slopes = tuple(float(content["slopes"][n]) for n in LOAD_NAMES)
            scores = np.array(content["scores"], dtype=np.float64)
            constant = float(content["constant"])
            coverage = {
                str(role): {str(k): float(v) for k, v in dict(m).items()}
                for role, m in dict(content.get("coverage", {})).items()
            }
            source = str(content["source"])
        except (KeyError, TypeError, ValueError, OverflowError):
            raise InputError(
                "interval: a value is missing or not a number; allowed: an interval as save() writes it"
            ) from None
        complete = all(
            set(m) == set(MEASURES) and np.isfinite(list(m.values())).all() for m in coverage.values()
        )
        if max(map(len, (source, *coverage))) > LONGEST_TEXT:
            raise InputError(f"interval: a source or role is too long; allowed: {LONGEST_TEXT} characters")
        if not complete or len(coverage) > MOST_ROLES:
            raise InputError(
                f"interval: coverage of {len(coverage)} roles; allowed: at most {MOST_ROLES}, each with finite numbers "
                f"{', '.join(MEASURES)}"
            )
        good = scores.shape == PROBABILITIES.shape and np.isfinite(scores).all() and bool((scores >= 0).all())
        if not good or (np.diff(scores) < 0).any() or not np.isfinite([constant, *slopes]).all():
            raise InputError(
                f"interval: {scores.size} scores, allowed: {len(PROBABILITIES)} finite numbers that never fall, with a "
                "finite constant and slopes"
            )
        if max(map(abs, (constant, *slopes))) > LARGEST or scores[-1] > 1e9:
            raise InputError(
                f"interval: a constant, slope or score is too large; allowed: at most {LARGEST:g}, {LARGEST:g}, 1e9"
            )
        widest = constant + sum(
            max(s * low, s * high) for s, (low, high) in zip(slopes, feature_ranges(domain))
        )
        if widest > WIDEST:
            raise InputError(
                f"interval: the logarithm of the width rises to {widest:.4g} in the domain, allowed: at most {WIDEST:g}"
            )
        return cls(
            check_level(content.get("level")),
            check_integer("interval", "tests", content.get("tests"), LEAST_TESTS, 10**9),
            check_integer("interval", "points", content.get("points"), LEAST_TESTS, 10**12),
            *(constant, slopes, tuple(scores.tolist()), source, coverage),
            _between(content.get("between", [])),  # intervals of earlier versions have none
        )


def check_level(level: object) -> float:
    """Return a level as float; raise `InputError` outside 0.5 to 0.999."""
    return check_number("interval", "level", level, LOWEST_LEVEL, HIGHEST_LEVEL)


def bounds(mu: FloatArray, margin: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the bounds of mu, each of shape (n,), from half the width of an interval; mu is never negative.

    Examples
    --------
    >>> [edge.round(3).tolist() for edge in bounds(np.array([0.1, 0.01]), np.array([0.02, 0.02]))]
    [[0.08, 0.0], [0.12, 0.03]]
    """
    return np.maximum(mu - margin, 0.0), mu + margin


def as_columns(
    low: FloatArray, high: FloatArray, index: pd.Index
) -> tuple[pd.Series[float], pd.Series[float]]:
    """Return bounds as the columns of a table with an `index`."""
    # imported here: what runs FMUs loads no tables
    import pandas as pd

    lower, upper = (
        pd.Series(edge, index=index, name=name) for edge, name in zip((low, high), BOUNDS, strict=True)
    )
    return lower, upper


def check_only_level(where: str, kind: str, own: float | None, asked: float | None) -> None:
    """Refuse what a file of some `kind` with an interval of its `own` level cannot give.

    Raises InputError: it has no interval, or another level is `asked` for.
    """
    if own is None:
        raise InputError(f"{where}: no prediction interval; allowed: {kind} with one")
    if asked is not None and asked != own:
        raise InputError(f"{where}: level {asked:g}; allowed: {own:g}, which the file was packed with")


def _between(content: object) -> tuple[Widening, ...]:
    """Return the widenings that a file holds. Raises InputError: too many, or no widenings."""
    if not isinstance(content, list) or len(content) > MOST_GAPS:
        raise InputError(
            f"interval: between = {content!r:.60}; allowed: a list of at most {MOST_GAPS} widenings"
        )
    return tuple(Widening.from_dict(entry) for entry in content)
