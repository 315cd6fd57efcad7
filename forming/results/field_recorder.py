"""Records the fields of a forming run while it runs."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from friction_models.common import InputError

from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from .fields import MOST, FieldHistory
from .snapshot import Snapshot

#: Environment variables that make a forming FMU write its fields: folder, and stroke between two snapshots [mm].
FIELDS_FOLDER, FIELDS_EVERY = "TRIBOFMU_FIELDS", "TRIBOFMU_FIELDS_EVERY"
#: Smallest, largest and default stroke between two snapshots [mm].
LEAST_SPACING, MOST_SPACING, SPACING = 0.01, 100.0, 0.5


class FieldRecorder:
    """Takes snapshots while a simulation runs; pass it to `advance_to`. It does not change the simulation.

    A simulation that was put back to an earlier state takes its later snapshots again.

    - `strokes` [mm]: each is kept at the first increment that reaches it.
    """

    def __init__(self, strokes: FloatArray) -> None:
        self.wanted = np.sort(strokes)
        self.taken: list[Snapshot] = []

    def begin(self, simulation: Simulation) -> None:
        """Forget everything and take the state at stroke 0, if it is wanted."""
        while self.taken:
            self._drop()
        if self.wanted[0] <= 0.0:
            self._take(simulation)

    def __call__(self, simulation: Simulation) -> bool:
        """Take a snapshot after an increment if one is due; return False, so that the run continues."""
        stroke = simulation.state.stroke
        while self.taken and self.taken[-1].stroke >= stroke - 1e-9:
            self._drop()
        before = self.taken[-1].stroke if self.taken else -math.inf
        if ((self.wanted > before + 1e-9) & (self.wanted <= stroke + 1e-9)).any():
            self._take(simulation)
        return False

    def finish(self, simulation: Simulation) -> FieldHistory:
        """Return all snapshots; a run that stopped early also keeps the state where it stopped."""
        state = simulation.state
        if state.status != "ok" and (not self.taken or self.taken[-1].stroke < state.stroke - 1e-9):
            self._take(simulation)
        return FieldHistory(tuple(self.taken))

    def _drop(self) -> None:
        self.taken.pop()

    def _take(self, simulation: Simulation) -> None:
        if len(self.taken) < MOST:
            self.taken.append(Snapshot.of(simulation))


class FieldWriter(FieldRecorder):
    """Writes each snapshot into a file at once: for a simulation inside an FMU, in a process of another program.

    - `folder`: where a folder is made for the files ``0000.npz``, ``0001.npz`` ..., which `FieldHistory.load`
      reads.
    - `name`: name of that folder; a number follows if it is there already.
    - `spacing`: stroke between two snapshots [mm].
    """

    def __init__(self, folder: str | os.PathLike[str], name: str, spacing: float) -> None:
        super().__init__(spacing * np.arange(MOST, dtype=np.float64))
        self.folder = Path(folder).absolute()
        self.name = name
        self._place: Path | None = None

    def _take(self, simulation: Simulation) -> None:
        super()._take(simulation)
        try:
            if self._place is None:
                self._place = self._claimed()
            FieldHistory((self.taken[-1],)).save(self._file(len(self.taken) - 1))
        except OSError as error:
            raise InputError(
                f"forming: fields cannot be written into {self.folder} ({error.strerror})"
            ) from None

    def _drop(self) -> None:
        super()._drop()
        self._file(len(self.taken)).unlink(missing_ok=True)

    def _file(self, number: int) -> Path:
        assert self._place is not None
        return self._place / f"{number:04d}.npz"

    def _claimed(self) -> Path:
        for number in range(1, MOST):
            place = self.folder / (self.name if number == 1 else f"{self.name}-{number}")
            try:
                place.mkdir(parents=True)
            except FileExistsError:
                if not self.folder.is_dir():
                    raise
                continue
            return place
        raise InputError(f"forming: {self.folder} holds {MOST} folders of fields; allowed: fewer")


def writer_from_environment(name: str) -> FieldWriter | None:
    """Return the writer that the environment variables ask for, or None.

    Raises InputError: the stroke between two snapshots is not a number from 0.01 to 100 mm.
    """
    folder = os.environ.get(FIELDS_FOLDER)
    if not folder:
        return None
    given = os.environ.get(FIELDS_EVERY) or str(SPACING)
    try:
        spacing = float(given)
    except ValueError:
        spacing = math.nan
    return FieldWriter(folder, name, checked_spacing(spacing, f"{FIELDS_EVERY}={given[:40]!r}"))


def checked_spacing(spacing: float, where: str) -> float:
    """Return a stroke between two snapshots that is allowed [mm]; raise InputError for another."""
    if not LEAST_SPACING <= spacing <= MOST_SPACING:
        raise InputError(f"{where}; allowed: {LEAST_SPACING:g} to {MOST_SPACING:g} mm")
    return spacing


def recorder_for(snapshots: int | Sequence[float] | FloatArray, stroke: float, where: str) -> FieldRecorder:
    """Return a recorder of so many snapshots, evenly from the start to `stroke`, or of those at given strokes.

    Raises InputError: fewer than 2, more than 1000, or strokes that the run does not reach.
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
