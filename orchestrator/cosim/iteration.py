"""Fixed-point iteration of a communication step: when its repetitions agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fmus.runtime.ports import Port
from friction_models.loads import FloatArray

from .setup.wiring import Link

#: Repetitions agree when the values of every connection change by less than this share of their largest.
TOLERANCE = 1e-8
#: A solver that stops at its own residual gives slightly different loads in each repetition. A change that no longer falls
#: counts as that when it is below this share,
RESOLUTION = 1e-4
#: and has not halved in so many repetitions.
PATIENCE = 3
MOST_REPETITIONS = 50
_REAL = ("Real", "Float64", "Float32")
#: Repetitions after which a step that oscillates is damped: the mean of the last two values is passed on. A value that is even
#: then exactly that of the step before in one repetition and not in the next tells of an event that happens or not, such as a
#: point that touches. No mean settles that: the value of the step before is passed on instead.
DAMPED_AFTER = 10


@dataclass
class FixedPointIteration:
    """Compares the values of all connections from one repetition of a step to the next.

    A step has converged when the values of every connection agree, as far as the components themselves resolve them.
    """

    links: Sequence[Link]  # the connections
    outputs: Mapping[str, Port]  # their values, by component
    tolerance: float = TOLERANCE  # relative change that counts as agreement
    repetitions: int = 0  # made so far
    change: float = float("inf")  # the largest relative one of any connection in the last repetition
    where: str = ""  # that connection
    _rows: list[tuple[str, str, npt.NDArray[np.intp]]] = field(default_factory=list)
    _previous: list[FloatArray] = field(default_factory=list)
    _passed: list[FloatArray] = field(default_factory=list)
    _start: list[FloatArray] = field(default_factory=list)
    _held: list[npt.NDArray[np.bool_]] = field(default_factory=list)
    _best: float = float("inf")
    _since: int = 0

    def __post_init__(self) -> None:
        for link in self.links:
            index = self.outputs[link.source].index
            rows = np.array([index[v.name] for v in link.sources], dtype=np.intp)
            self._rows.append((_name(link), link.source, rows))

    def begin(self) -> None:
        """Start with the values of the step before."""
        self.repetitions, self.change, self.where = 0, float("inf"), ""
        self._best, self._since = float("inf"), 0
        self._previous = self._values()
        self._passed, self._start = list(self._previous), list(self._previous)
        self._held = [np.zeros(len(values), dtype=bool) for values in self._previous]

    def converged(self) -> bool:
        """Compare with the last repetition; return whether the values agree."""
        values = self._values()
        self.repetitions += 1
        self.change = 0.0
        for (name, _, _), new, old in zip(self._rows, values, self._previous):
            size = max(float(np.max(np.abs(new), initial=0.0)), 1e-12)
            change = float(np.max(np.abs(new - old), initial=0.0)) / size
            if change >= self.change:
                self.change, self.where = change, name
        if self.repetitions >= DAMPED_AFTER + PATIENCE:
            for held, start, new, old in zip(self._held, self._start, values, self._previous):
                held |= (new == start) != (old == start)
        self._previous = values
        if self.repetitions < 2:
            return False
        if self.change < 0.5 * self._best:
            self._best, self._since = self.change, 0
        else:
            self._since += 1
        return self.change <= self.tolerance or (self.change <= RESOLUTION and self._since >= PATIENCE)

    def pass_on(self) -> None:
        """Prepare the next repetition; after many of them what oscillates is damped, and an event that comes and goes left out."""
        for k, (_, source, rows) in enumerate(self._rows):
            if self.repetitions >= DAMPED_AFTER and self.links[k].sources[0].type in _REAL:
                mean = 0.5 * (self._passed[k] + self._previous[k])
                self._passed[k] = np.where(self._held[k], self._start[k], mean)
                self.outputs[source].values[rows] = self._passed[k]
            else:
                self._passed[k] = self._previous[k]

    def _values(self) -> list[FloatArray]:
        return [self.outputs[source].values[rows].copy() for _, source, rows in self._rows]


def _name(link: Link) -> str:
    base = link.sources[0].name.partition("[")[0], link.targets[0].name.partition("[")[0]
    return f"{link.source}.{base[0]} -> {link.target}.{base[1]}"
