"""A source of signals over time: no inputs; each output is a recorded or planned quantity."""

from __future__ import annotations

import numpy as np

from friction_models.loads import FloatArray

from .core import Solver


class _Nothing:
    """The state of a source is its outputs alone, which the host keeps."""

    def snapshot(self) -> None:
        """Return nothing."""

    def restore(self, snapshot: None) -> None:
        """Do nothing."""


class SignalsSolver(Solver):
    """Outputs: the mean of each signal over the step that has just ended.

    A signal is constant between two times of the table. Means, not samples: the integral of a speed over
    the steps of a master is then the distance of the table, whatever the step.
    """

    def start(self) -> None:
        self.process = _Nothing()
        edges = np.array(self.config["edges"], dtype=np.float64)
        means = np.array(self.config["means"], dtype=np.float64)  # one row a signal
        sums = np.cumsum(means * np.diff(edges), axis=1)
        self.edges: FloatArray = edges
        self.sums: FloatArray = np.hstack([np.zeros((len(means), 1)), sums])
        self.means: FloatArray = means
        self.values[: self.first_input] = means[:, 0]

    def advance(self, elapsed: float, step: float) -> None:
        if step <= 0.0:
            return
        begin, end = self._integral(elapsed), self._integral(elapsed + step)
        self.values[: self.first_input] = (end - begin) / step

    def _integral(self, time: float) -> FloatArray:
        """Integral of every signal from the first time on; the last value holds beyond the table."""
        beyond = max(time - self.edges[-1], 0.0)
        inside = np.array([np.interp(time, self.edges, row) for row in self.sums])
        return np.asarray(inside + beyond * self.means[:, -1])
