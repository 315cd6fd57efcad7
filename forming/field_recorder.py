"""Takes the fields of a forming run while it goes on."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from friction_models.loads import InputError

from .fe.shape import FloatArray
from .fe.simulation import Simulation
from .fe.state import State
from .fields import MOST, FieldHistory, Snapshot


class FieldRecorder:
    """Takes snapshots while a simulation runs; it is given to `advance_to` and only looks.

    A simulation that was put back to an earlier state takes its later snapshots again.

    Parameters
    ----------
    strokes : sequence of float, optional
        Strokes [mm]; each is kept at the first increment that reaches it.
    every : int, optional
        Instead: one snapshot each so many increments.
    """

    def __init__(self, strokes: Sequence[float] | FloatArray | None = None, every: int | None = None) -> None:
        self.wanted = np.sort(np.asarray([] if strokes is None else strokes, dtype=np.float64))
        self.every = every
        self.taken: list[Snapshot] = []
        self._increments: list[int] = []

    def begin(self, simulation: Simulation) -> None:
        """Forget everything and take the state at stroke 0, if it is wanted."""
        self.taken, self._increments = [], []
        if self.every is not None or (len(self.wanted) and self.wanted[0] <= 0.0):
            self._take(simulation)

    def __call__(self, simulation: Simulation) -> bool:
        """Look at the state after an increment; never ends the advance."""
        state = simulation.state
        while self.taken and self.taken[-1].stroke >= state.stroke - 1e-9:
            self.taken.pop()
            self._increments.pop()
        if self._due(state):
            self._take(simulation)
        return False

    def finish(self, simulation: Simulation) -> FieldHistory:
        """Return what was taken; a run that stopped early also keeps the state where it stopped."""
        state = simulation.state
        if state.status != "ok" and (not self.taken or self.taken[-1].stroke < state.stroke - 1e-9):
            self._take(simulation)
        return FieldHistory(tuple(self.taken))

    def _due(self, state: State) -> bool:
        if self.every is not None:
            return state.increments - (self._increments[-1] if self._increments else 0) >= self.every
        before = self.taken[-1].stroke if self.taken else -math.inf
        return bool(((self.wanted > before + 1e-9) & (self.wanted <= state.stroke + 1e-9)).any())

    def _take(self, simulation: Simulation) -> None:
        if len(self.taken) < MOST:
            self.taken.append(Snapshot.of(simulation))
            self._increments.append(simulation.state.increments)


def recorder_for(snapshots: int | Sequence[float] | FloatArray, stroke: float, where: str) -> FieldRecorder:
    """Return a recorder of so many snapshots, evenly from the start to `stroke`, or of those at given strokes.

    Raises
    ------
    InputError
        Fewer than 2, more than 1000, or strokes that the run does not reach.
    """
    if isinstance(snapshots, (int, np.integer)) and not isinstance(snapshots, bool):
        if not 2 <= snapshots <= MOST:
            raise InputError(
                f"{where}: snapshots = {snapshots}; allowed: 2 to {MOST}, or a list of strokes [mm]"
            )
        return FieldRecorder(np.linspace(0.0, stroke, int(snapshots)))
    try:
        wanted = np.asarray(snapshots, dtype=np.float64)
    except (TypeError, ValueError):
        wanted = np.empty(0)
    if wanted.ndim != 1 or not 1 <= len(wanted) <= MOST:
        raise InputError(
            f"{where}: snapshots = {str(snapshots)[:60]!r}; allowed: a number from 2 to {MOST}, "
            f"or a list of 1 to {MOST} strokes [mm]"
        )
    bad = wanted[~((wanted >= 0.0) & (wanted <= stroke + 1e-9))]
    if len(bad):
        raise InputError(f"{where}: snapshot at stroke {bad[0]:g} mm; allowed: 0 to {stroke:g} mm")
    return FieldRecorder(wanted)
