"""The points of whole tests one after the other, along which effects that remember advance."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..expressions.ops import LoadColumns, NumpyOps
from ..loads import FloatArray, TriboLoads
from ..loads.time_steps import rests, time_steps

OPS = NumpyOps()
Rows = npt.NDArray[np.intp] | slice
#: Takes rows, their loads, states there and seconds, all of shape (rows, ...); returns the states after these seconds.
Advance = Callable[[Rows, LoadColumns, Sequence[FloatArray], FloatArray], Sequence[FloatArray]]


@dataclass(frozen=True)
class TimeCourse:
    """Points of tests, of which each slides up to the next; before it slides, the contact may stand still."""

    loads: FloatArray  #: Shape (n, 5); the points of one test are consecutive.
    starts: npt.NDArray[np.intp]  #: First point of each test, shape (tests,).
    dt: FloatArray  #: Since the point before [s], shape (n,); 0 at the first one of a test.
    pause: FloatArray  #: Part of it in which the contact stood still first.

    @classmethod
    def of(cls, loads: TriboLoads, starts: npt.NDArray[np.intp], absent: Collection[str] = ()) -> TimeCourse:
        """Return the course of tests that begin at these points, for a law that does not know the loads in `absent`."""
        dt = time_steps(loads, starts)
        seen = LoadColumns.from_matrix(OPS, loads.as_array()).without(OPS, tuple(absent))
        # a law that knows no speed knows no rest
        pause = np.zeros_like(dt) if "v_rel" in absent else rests(loads, dt)
        return cls(np.hstack(seen.columns()), starts, dt, pause)

    def at(self, rows: Rows = slice(None)) -> LoadColumns:
        """Return the loads of some points, or of all."""
        return LoadColumns.from_matrix(OPS, self.loads[rows])

    def step_by_step(self, start: Sequence[FloatArray], advance: Advance) -> list[FloatArray]:
        """Return states at every point, shape (n, g) each, from those at the `start` of each test, shape (tests, g), all tests one step further at a time."""
        n = len(self.dt)
        lengths = np.diff(np.r_[self.starts, n])
        current = [s.copy() for s in start]
        history = [np.empty((n, s.shape[1])) for s in start]
        for step in range(int(lengths.max(initial=0))):
            running = lengths > step
            rows = self.starts[running] + step
            L = self.at(rows)
            held: Sequence[FloatArray] = [c[running] for c in current]
            if self.pause[rows].any():
                held = advance(rows, L.at_rest(), held, self.pause[rows])
            for k, value in enumerate(advance(rows, L, held, (self.dt - self.pause)[rows])):
                current[k][running] = value
                history[k][rows] = value
        return history

    def at_once(
        self,
        start: Sequence[FloatArray],
        linear_step: Callable[[LoadColumns, FloatArray], Sequence[FloatArray]],
    ) -> list[FloatArray]:
        """Return the same where ``linear_step(loads, seconds)`` gives ``keep, gain`` of each state in turn, shape (n, g) each.

        What a step keeps and adds is known for all points before the first step is made.
        """
        sliding = linear_step(self.at(), self.dt - self.pause)
        resting = linear_step(self.at().at_rest(), self.pause) if self.pause.any() else None
        by_length, order, ends = self._side_by_side
        history = []
        for k, begin in enumerate(start):
            keep, gain = sliding[2 * k : 2 * k + 2]
            if resting is not None:
                kept_at_rest, gained_at_rest = resting[2 * k : 2 * k + 2]
                keep, gain = keep * kept_at_rest, keep * gained_at_rest + gain
            kept, gained = keep[order], gain[order]
            states, now = np.empty((len(self.dt), begin.shape[1])), begin[by_length]
            for first, end in pairwise([0, *ends]):
                now = np.add(kept[first:end] * now[: end - first], gained[first:end], out=states[first:end])
            at_points = np.empty_like(states)
            at_points[order] = states
            history.append(at_points)
        return history

    @cached_property
    def _side_by_side(self) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], npt.NDArray[np.intp]]:
        """Tests, the longest first; their points, all first ones before all second ones and so on; where each of these groups ends.

        Tests that still run are the first of the step before.
        """
        lengths = np.diff(np.r_[self.starts, len(self.dt)])
        number = np.arange(len(self.dt)) - np.repeat(self.starts, lengths)
        by_length = np.argsort(-lengths, kind="stable")
        order = np.lexsort((np.repeat(np.argsort(by_length), lengths), number))
        return by_length, order, np.cumsum(np.bincount(number))
