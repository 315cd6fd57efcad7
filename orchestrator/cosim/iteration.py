"""Fixed-point iteration of a communication step: when its repetitions agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fmus.runtime.ports import Port
from friction_models.loads import FloatArray

from .setup.wiring import Link

#: Repetitions agree when what every connection carries and what comes of it differ by less than this share of the largest.
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
#: Damped repetitions without a halved change after which single values that do not settle are left out, too,
STUCK = 9
#: up to this share of those of a connection.
MOST_HELD = 0.1


@dataclass
class FixedPointIteration:
    """Compares the values that all connections carry in a repetition of a step with those that come of it.

    A step has converged when the values of every connection agree, as far as the components themselves resolve them, or those of
    all connections out of one component through which a repetition hears of the one before: all that is passed on late comes from it,
    or all goes to it. The others follow from them. Loads of a solver may go on changing by its residual where friction no longer does.

    A damped step passes on means: that the same comes of two of them does not tell that it would come of itself, too. It is therefore
    passed on as it is, once: either the values agree, or damping goes on from where it was.
    """

    links: Sequence[Link]  # the connections
    outputs: Mapping[str, Port]  # their values, by component
    order: Sequence[str]  # in which the components run
    tolerance: float = TOLERANCE  # relative change that counts as agreement
    repetitions: int = 0  # made so far
    change: float = float("inf")  # the largest relative difference of any connection in the last repetition
    where: str = ""  # that connection
    _rows: list[tuple[str, str, npt.NDArray[np.intp]]] = field(default_factory=list)
    _cuts: list[list[int]] = field(default_factory=list)  # the connections out of each such component
    _late: list[bool] = field(default_factory=list)  # whether the target runs before the source
    _previous: list[FloatArray] = field(default_factory=list)
    _passed: list[FloatArray] = field(default_factory=list)
    _start: list[FloatArray] = field(default_factory=list)
    _held: list[npt.NDArray[np.bool_]] = field(default_factory=list)
    _best: float = float("inf")
    _since: int = 0
    _repeats: bool = False  # whether the same has come of the last two repetitions
    _tried: bool = False  # whether that has been passed on
    _damped: list[FloatArray] | None = None  # what else would have been passed on in this repetition

    def __post_init__(self) -> None:
        for link in self.links:
            index = self.outputs[link.source].index
            rows = np.array([index[v.name] for v in link.sources], dtype=np.intp)
            self._rows.append((_name(link), link.source, rows))
            self._late.append(self.order.index(link.target) <= self.order.index(link.source))
        late = [link for link, is_late in zip(self.links, self._late) if is_late]
        sources, targets = {link.source for link in late}, {link.target for link in late}
        self._cuts = [
            [k for k, link in enumerate(self.links) if link.source == name]
            for name in self.order
            if {name} in (sources, targets)
        ]

    def begin(self) -> None:
        """Start with the values of the step before."""
        self.repetitions, self.change, self.where = 0, float("inf"), ""
        self._best, self._since = float("inf"), 0
        self._repeats, self._tried, self._damped = False, False, None
        self._previous = self._values()
        self._passed, self._start = list(self._previous), list(self._previous)
        self._held = [np.zeros(len(values), dtype=bool) for values in self._previous]

    def converged(self) -> bool:
        """Compare with what was passed on; return whether the values agree."""
        values = self._values()
        self.repetitions += 1
        used = [
            # What is held at the start of the step is meant to differ.
            np.where(held, old, passed) if late else old
            for late, held, old, passed in zip(self._late, self._held, self._previous, self._passed)
        ]
        self.change, self.where = self._largest(values, used)
        if self.repetitions <= DAMPED_AFTER:  # what was passed on is what came of the repetition before
            cuts = (self._largest(values, used, cut) for cut in self._cuts)
            self.change, self.where = min([(self.change, self.where), *cuts])
        if self._damped is not None and self.change > self.tolerance:
            self._passed, self._damped = self._damped, None
            return False
        self._repeats = self._largest(values, self._previous)[0] <= self.tolerance
        self._tried = self._tried and self._repeats
        if self.repetitions >= DAMPED_AFTER + PATIENCE:
            for held, start, new, old in zip(self._held, self._start, values, self._previous):
                held |= (new == start) != (old == start)
        if self.repetitions > DAMPED_AFTER and self._since >= STUCK:
            self._leave_out(values)
            self._since = STUCK - PATIENCE  # the others may settle now
        self._previous = values
        if self.repetitions < 2:
            return False
        if self.change < 0.5 * self._best or self.repetitions == DAMPED_AFTER:
            self._best, self._since = self.change, 0
        else:
            self._since += 1
        settled = self._since >= PATIENCE or self.repetitions >= MOST_REPETITIONS
        return self.change <= self.tolerance or (self.change <= RESOLUTION and settled)

    @property
    def lagging(self) -> int:
        """Number of values that were passed on as they were at the start of the step."""
        return sum(int(held.sum()) for held, late in zip(self._held, self._late) if late)

    def _leave_out(self, values: list[FloatArray]) -> None:
        """Hold the value of each connection that changes most at the start of the step; those held stay few."""
        for held, new, passed in zip(self._held, values, self._passed):
            if held.sum() + 1 <= MOST_HELD * len(new):
                moved = np.where(held, 0.0, np.abs(new - passed))
                largest = int(np.argmax(moved))
                held[largest] |= moved[largest] > RESOLUTION * np.max(np.abs(new))

    def pass_on(self) -> None:
        """Prepare the next repetition; after many of them what oscillates is damped, and an event that comes and goes left out."""
        trial = self.repetitions >= DAMPED_AFTER and self._repeats and not self._tried
        if trial:
            self._tried, self._damped = True, list(self._passed)
        for k, (_, source, rows) in enumerate(self._rows):
            if self.repetitions >= DAMPED_AFTER and self.links[k].sources[0].type in _REAL:
                proposed = self._previous[k] if trial else 0.5 * (self._passed[k] + self._previous[k])
                self._passed[k] = np.where(self._held[k], self._start[k], proposed)
                self.outputs[source].values[rows] = self._passed[k]
            else:
                self._passed[k] = self._previous[k]

    def _largest(
        self, values: list[FloatArray], others: list[FloatArray], among: Sequence[int] | None = None
    ) -> tuple[float, str]:
        """Return the largest difference relative to the largest value of any connection, or `among` some, and which that is."""
        largest, where = 0.0, ""
        for k in range(len(values)) if among is None else among:
            name, new, other = self._rows[k][0], values[k], others[k]
            size = max(float(np.max(np.abs(new), initial=0.0)), 1e-12)
            change = float(np.max(np.abs(new - other), initial=0.0)) / size
            if change >= largest:
                largest, where = change, name
        return largest, where

    def _values(self) -> list[FloatArray]:
        return [self.outputs[source].values[rows].copy() for _, source, rows in self._rows]


def _name(link: Link) -> str:
    base = link.sources[0].name.partition("[")[0], link.targets[0].name.partition("[")[0]
    return f"{link.source}.{base[0]} -> {link.target}.{base[1]}"
