"""Measured points of whole tests in bins, which every later step works on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ...effects.time_course import TimeCourse
from ...loads import LOAD_NAMES, FloatArray, TriboLoads
from .settings import HELD, setting_of_tests, varies

#: Share of what a load changes along the tests by which its means must differ from test to test to set them apart.
LEVELS = 0.1
#: Averages of neighbouring points of a bin, at most, that stand for it where a formula is evaluated many times.
PIECES = 4
#: Points between which the contact rests, or the speed changes by more than this share of it, stand for themselves.
STEP = 0.1


@dataclass
class BinnedTests:
    """Measured points of whole tests, with the bins that every later step works on."""

    loads: TriboLoads  #: All points, without the noise of sensors; the points of one test are consecutive.
    mu: FloatArray  #: Measured coefficient of friction, shape (n,).
    tests: list[str]  #: Test names in the order of the points.
    point_starts: npt.NDArray[np.intp]  #: First point of each test, shape (tests,).
    starts: npt.NDArray[np.intp]  #: First point of each bin, shape (m,).
    count: FloatArray  #: Points read in each bin, shape (m,).
    test: npt.NDArray[np.intp]  #: Test of each bin, shape (m,).
    slot: npt.NDArray[np.intp]  #: Number of the bin within its test, shape (m,).
    #: Sliding distance since the start of the test [mm], of averages far apart the recorded one; counts of points where it does
    #: not vary. Shape (n,).
    distance: FloatArray
    #: Metadata of the tests that is recorded for every test, as numbers, each of shape (n, 1).
    system: dict[str, FloatArray] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)  #: What the user should know about the data.
    grouped: bool = True  #: Whether tests are known.
    #: Loads as they were read, noise included; None where they are as in `loads`.
    read: TriboLoads | None = field(default=None, repr=False)
    #: Points read that each point is the average of; None where each is one. Shape (n,).
    weight: FloatArray | None = field(default=None, repr=False)
    #: Bins that lie far off their neighbours; they carry no weight. Shape (m,).
    distrusted: npt.NDArray[np.bool_] | None = None
    spikes: float = 0.0  #: Share of the points that lay far off their neighbours and were replaced.
    #: States of effects whose evolution does not depend on shape parameters, with the mu that drove them.
    integrated: dict[str, tuple[FloatArray, dict[str, FloatArray]]] = field(default_factory=dict, repr=False)
    #: Curves along the loads, once they have been computed, shape (m, k).
    smooth: list[FloatArray] | None = field(default=None, repr=False)

    @property
    def as_read(self) -> TriboLoads:
        """Loads as they were read, noise included."""
        return self.loads if self.read is None else self.read

    @property
    def point_lasts(self) -> npt.NDArray[np.intp]:
        """Last point of each test, shape (tests,)."""
        return np.asarray(np.r_[self.point_starts[1:], len(self.mu)] - 1)

    def average(self, values: FloatArray) -> FloatArray:
        """Return bin means of `values`, shape (n,) or (n, k)."""
        if self.weight is not None:
            values = values * (self.weight if values.ndim == 1 else self.weight[:, None])
        sums = np.add.reduceat(values, self.starts, axis=0)
        return sums / (self.count if sums.ndim == 1 else self.count[:, None])

    def of_tests(self, values: FloatArray) -> FloatArray:
        """Return means over each test of values in the bins, shape (m,), weighted by their points."""
        weight = np.bincount(self.test, self.count)
        return np.asarray(np.bincount(self.test, self.count * values) / weight)

    def metadata(self, name: str) -> FloatArray:
        """Return a column of metadata in the bins, shape (m,)."""
        return self.average(self.system[name][:, 0])

    @cached_property
    def largest_mu(self) -> float:
        """Largest mean friction coefficient of a bin."""
        return float(np.max(self.average(self.mu)))

    @cached_property
    def course(self) -> TimeCourse:
        """The points one after the other in time."""
        return TimeCourse.of(self.loads, self.point_starts)

    @cached_property
    def pieces(self) -> BinnedTests:
        """The same bins, of averages of neighbouring points: at most `PIECES` a bin, and more where the contact rests or the speed steps."""
        rows = self._first_of_pieces
        size = np.diff(np.r_[rows, len(self.mu)]).astype(float)
        if len(rows) == len(self.mu):
            return self
        loads: Any = {n: self.over_pieces(getattr(self.loads, n)) for n in LOAD_NAMES}
        t = None if self.loads.t is None else self.over_pieces(self.loads.t)
        starts, point_starts = (np.searchsorted(rows, first) for first in (self.starts, self.point_starts))
        return BinnedTests(
            replace(self.loads.take(rows), **loads, t=t), self.over_pieces(self.mu), self.tests, point_starts, starts, self.count,
            self.test, self.slot, self.over_pieces(self.distance), {name: column[rows] for name, column in self.system.items()},
            grouped=self.grouped, weight=size,
        )  # fmt: skip

    @cached_property
    def first_of_bins(self) -> BinnedTests:
        """The same bins, each with its first point alone."""
        rows = self.starts
        return BinnedTests(
            self.loads.take(rows), self.mu[rows], self.tests, self.first_bins, np.arange(len(rows)), np.ones(len(rows)),
            self.test, self.slot, self.distance[rows], {name: column[rows] for name, column in self.system.items()},
            grouped=self.grouped,
        )  # fmt: skip

    @cached_property
    def _first_of_pieces(self) -> npt.NDArray[np.intp]:
        """First point of each piece."""
        edges = self.starts[:, None] + self.count[:, None].astype(np.intp) * np.arange(PIECES) // PIECES
        v = self.loads.v_rel
        steps = np.abs(np.diff(v, prepend=v[:1])) > STEP * v
        behind = np.flatnonzero((self.course.pause > 0.0) | steps)
        rows = np.r_[edges.ravel(), behind - 1, behind, behind + 1]
        return np.unique(rows[(rows >= 0) & (rows < len(v))])

    def over_pieces(self, values: FloatArray) -> FloatArray:
        """Return means over the pieces of `values`, shape (n,) or (n, k)."""
        rows = self._first_of_pieces
        if len(rows) == len(values):
            return values
        size = np.diff(np.r_[rows, len(values)])
        sums = np.add.reduceat(values, rows, axis=0)
        return np.asarray(sums / (size if sums.ndim == 1 else size[:, None]))

    @cached_property
    def place(self) -> npt.NDArray[np.intp]:
        """Place of each test in the order of their mean loads and mu.

        Names of tests say nothing: by this order every random number falls on the same test, whatever its name.
        """
        means = [self.of_tests(self.average(column)) for column in (*self.loads.as_array().T, self.mu)]
        return np.asarray(np.argsort(np.lexsort(means[::-1])))

    @cached_property
    def path(self) -> FloatArray:
        """Distance along which friction may change [mm], shape (n,): since the start of the test, or the recorded one where tests go
        on on the track of others, so that it differs more between their starts than along them."""
        sd = self.loads.sd
        if self.averaged or "sd" in self.absent:
            return self.distance
        along = sd - self.mean_at_points(sd)
        return sd if np.std(sd[self.point_starts]) > np.std(along) else self.distance

    def mean_at_points(self, values: FloatArray) -> FloatArray:
        """Return at every point the mean of values, shape (n,), over the points of its test."""
        test = self.point_test
        return np.asarray((np.bincount(test, values) / np.bincount(test))[test])

    @cached_property
    def levels(self) -> dict[str, FloatArray]:
        """Mean over each test of each load that was measured and varies, of the `path` for ``sd``; shape (tests,) each."""
        columns = {n: self.path if n == "sd" else getattr(self.loads, n) for n in self.varied}
        return {n: self.of_tests(self.average(column)) for n, column in columns.items()}

    @cached_property
    def setting(self) -> npt.NDArray[np.intp]:
        """Setting of each test, see `setting_of_tests`."""
        means = dict(self.levels)
        if not self.averaged:  # how long a test was
            means.pop("sd", None)
        if "T" in means and "T_tool" in self.system:
            means["T_tool"] = self.of_tests(self.metadata("T_tool"))
            del means["T"]
        return setting_of_tests(means, self.place)

    def with_load(self, name: str, values: FloatArray) -> BinnedTests:
        """Return the same bins with other values of a load, shape (n,); what was computed with the present ones stays behind."""
        changed: Any = {name: values}
        return replace(self, loads=replace(self.loads, **changed), integrated={}, smooth=None)

    def spread(self, tests: npt.NDArray[np.intp], most: int) -> npt.NDArray[np.intp]:
        """Return some tests, all or `most` of them, evenly spread over their loads whatever their names are; sorted."""
        by_loads = tests[np.argsort(self.place[tests])]
        count = min(len(tests), most)
        return np.sort(by_loads[np.linspace(0, len(tests) - 1, count).astype(int)])

    @property
    def absent(self) -> tuple[str, ...]:
        """Loads that the data lack; they are held constant."""
        return self.loads.absent

    @property
    def averaged(self) -> bool:
        """Whether there is one average a test, so that nothing shows along tests."""
        return len(self.starts) == len(self.tests)

    @property
    def first_bins(self) -> npt.NDArray[np.intp]:
        """First bin of each test."""
        return np.flatnonzero(np.r_[True, np.diff(self.test) > 0])

    @property
    def point_test(self) -> npt.NDArray[np.intp]:
        """Test of each point."""
        return np.repeat(self.test, np.diff(np.r_[self.starts, len(self.mu)]))

    @property
    def varied(self) -> list[str]:
        """Loads that were measured and vary, in their usual order."""
        return [n for n in LOAD_NAMES if n not in self.absent and self.varies(n)]

    def ranges(self, names: Iterable[str]) -> dict[str, list[float]]:
        """Return the lowest and the highest value of those names that are loads which vary."""
        columns = {n: getattr(self.loads, n) for n in names if n in LOAD_NAMES and self.varies(n)}
        return {n: [float(column.min()), float(column.max())] for n, column in columns.items()}

    def sets_apart(self, name: str) -> bool:
        """Whether a load differs from test to test, and not only by where the averages of equal tests begin and end."""
        values = self.average(getattr(self.loads, name))
        means = self.of_tests(values)
        return float(np.std(means)) > LEVELS * float(np.sqrt(np.mean((values - means[self.test]) ** 2)))

    def varies(self, name: str) -> bool:
        """Whether a load takes more than one value, beyond what a machine makes of one set point."""
        return name in self._varying

    @cached_property
    def _varying(self) -> frozenset[str]:
        columns = {n: getattr(self.loads, n) for n in LOAD_NAMES}
        held = {n: self.average(c) if n in HELD else c for n, c in columns.items()}
        return frozenset(n for n, column in held.items() if varies(n, column, self.averaged))
