"""What the learning-curve study found: curves, tests needed, and what that says of the two data collections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from friction_models.loads import FloatArray
from friction_models.training import lowest_error, needed_with_interval, percentile_curve, share_fewer
from friction_models.training.learning_curve import LEVEL, NeededTests

from ...jobs.graph import JobResult
from .jobs import AVERAGE, MEAN, SERIES, DataFacts, Point
from .study import LearningCurveStudy

#: A curve has converged from where on it stays within this factor of its lowest point.
CONVERGED = 1.1
#: The paper's limit of 0.01 is about this factor above its lowest errors of 0.007 to 0.008.
APART = 1.3
#: Fewest held-out tests by which two data collections are told apart.
FEWEST = 6
NO_DIFFERENCE, AT_ONCE = "no clear difference", "both at once"


@dataclass(frozen=True)
class Curve:
    """Errors of one model over the size of its training set.

    Examples
    --------
    One repeat, two sizes and two held-out tests:

    >>> parts = np.array([[[0.03, 0.01], [0.01, 0.01]]])
    >>> curve = Curve("oil", "series", "linear", (4, 8), (400, 800), parts, parts, ({}, {}))
    >>> curve.errors
    array([[0.02, 0.01]])
    """

    lubricant: str
    collection: str
    model: str
    sizes: tuple[int, ...]
    points: tuple[int, ...]  # of the first repeat
    #: What each held-out test contributes to the MAE on time series, shape (repeats, sizes, tests); their mean is the MAE.
    parts: FloatArray
    averages: FloatArray  # the same on averages
    parameters: tuple[dict[str, object], ...]  # that the search chose at each size

    @classmethod
    def of(cls, lubricant: str, collection: str, model: str, entries: Sequence[Point]) -> Curve:
        """Put the sizes of a model together, in whatever order they were computed."""
        ordered = sorted(entries, key=lambda e: e["tests"])
        return cls(
            lubricant, collection, model,
            tuple(e["tests"] for e in ordered), tuple(e["points"] for e in ordered),
            np.array([e["errors"] for e in ordered]).swapaxes(0, 1),
            np.array([e["errors_averages"] for e in ordered]).swapaxes(0, 1),
            tuple(dict(e["parameters"]) for e in ordered),
        )  # fmt: skip

    @property
    def head(self) -> dict[str, object]:
        """Whose curve it is, as tables say it."""
        return {"lubricant": self.lubricant, "collection": self.collection, "model": self.model}

    @property
    def errors(self) -> FloatArray:
        """MAE on the held-out time series, shape (repeats, sizes)."""
        return np.asarray(self.parts.mean(axis=2))

    @property
    def percentile(self) -> FloatArray:
        """The 0.95 percentile of the MAE at each size."""
        return percentile_curve(self.parts)

    @cached_property
    def lowest(self) -> tuple[float, float, float]:
        """Lowest point of the percentile curve and its interval."""
        return lowest_error(self.parts)

    @cached_property
    def converged(self) -> NeededTests:
        """Tests from which on the curve stays near its lowest point."""
        return self.needed(CONVERGED * self.lowest[0])

    def needed(self, accuracy: float) -> NeededTests:
        """Return the tests needed for an accuracy."""
        return needed_with_interval(self.sizes, self.parts, accuracy)


@dataclass(frozen=True)
class Comparison:
    """Time-series-based against average-based data for one model, lubricant and accuracy."""

    lubricant: str
    model: str
    accuracy: float
    series: NeededTests
    average: NeededTests
    own: NeededTests  # of the average-based data, judged by the averages of the held-out tests instead of their series
    fewer: float  # share of the resamples in which the time series needs fewer tests
    more: float  # share of those in which it needs more
    judged: bool  # whether there are sizes and held-out tests enough to tell the collections apart

    @property
    def verdict(self) -> str:
        """``fewer``, ``more``, ``both at once``, or ``no clear difference`` where less than 95 % of the resamples agree.

        The latter, too, where one size or less than six held-out tests say too little. ``both at once``: the smallest training set suffices with either collection, so the sizes cannot tell them apart.
        """
        if self.series.at_most and self.average.at_most:
            return AT_ONCE
        if not self.judged:
            return NO_DIFFERENCE
        if self.fewer >= LEVEL:
            return "fewer"
        return "more" if self.more >= LEVEL else NO_DIFFERENCE


@dataclass(frozen=True)
class LearningCurves:
    """All curves of the study."""

    curves: tuple[Curve, ...]
    facts: Mapping[str, DataFacts]
    accuracy: float
    repeats: int
    missing: int = 0  # jobs without a result
    virtual: bool = False  # whether the virtual laboratory of the study measured, and not the user

    @classmethod
    def of(cls, study: LearningCurveStudy, results: Mapping[str, JobResult]) -> LearningCurves:
        """Gather the results that are there."""
        curves: list[Curve] = []
        missing = 0
        for (lubricant, collection), names in study.curves.items():
            entries: dict[str, list[Point]] = {m: [] for m in (MEAN, *study.plan.models)}
            for name in names:
                missing += name not in results
                for entry in results[name].values["curves"] if name in results else ():
                    entries[entry["model"]].append(entry)
            curves += [
                Curve.of(lubricant, collection, model, found) for model, found in entries.items() if found
            ]
        facts: dict[str, DataFacts] = {
            lubricant: cast(DataFacts, results[name].values)
            for lubricant, name in study.facts.items()
            if name in results
        }
        missing += len(study.facts) - len(facts)
        return cls(tuple(curves), facts, study.plan.accuracy, study.plan.repeats, missing, study.virtual)

    @property
    def synthetic(self) -> bool:
        """Whether any data comes from a virtual laboratory; also where nothing is known."""
        return any(bool(f["synthetic"]) for f in self.facts.values()) or not self.facts

    @property
    def lubricants(self) -> list[str]:
        """Lubricants in the order of the study."""
        return list(dict.fromkeys(c.lubricant for c in self.curves))

    @property
    def models(self) -> list[str]:
        """Models in the order of the study, without the mean."""
        return [m for m in dict.fromkeys(c.model for c in self.curves) if m != MEAN]

    def curve(self, lubricant: str, collection: str, model: str) -> Curve | None:
        """Return one curve, None where it is missing."""
        wanted = lubricant, collection, model
        return next((c for c in self.curves if (c.lubricant, c.collection, c.model) == wanted), None)

    @cached_property
    def comparisons(self) -> list[Comparison]:
        """Both collections at the accuracy that is asked for."""
        return self._compare(self.accuracy)

    @cached_property
    def strict(self) -> list[Comparison]:
        """Both collections near the lowest error that the model reaches with either of them."""
        return self._compare(None)

    @cached_property
    def apart(self) -> list[Comparison]:
        """Both collections as far above that lowest error as the paper's limit is above its own."""
        return self._compare(None, APART)

    def _compare(self, accuracy: float | None, above: float = CONVERGED) -> list[Comparison]:
        found = []
        for lubricant in self.lubricants:
            for model in self.models:
                series, average = (self.curve(lubricant, c, model) for c in (SERIES, AVERAGE))
                # A job that failed leaves a hole; curves of different sizes do not compare.
                if series is None or average is None or series.sizes != average.sizes:
                    continue
                limit = accuracy or above * min(series.lowest[0], average.lowest[0])
                fewer, more = share_fewer(series.sizes, series.parts, average.parts, limit)
                own = needed_with_interval(average.sizes, average.averages, limit)
                needed = series.needed(limit), average.needed(limit), own
                judged = len(series.sizes) > 1 and series.parts.shape[2] >= FEWEST
                found.append(Comparison(lubricant, model, limit, *needed, fewer, more, judged))
        return found
