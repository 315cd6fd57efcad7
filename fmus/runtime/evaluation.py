"""Outputs of a friction FMU at loads: at points without time, or all through a test; here or in a process of its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, FloatArray

from ..interface.quantities import load_conversion
from .fmu_files import UnpackedFmu
from .friction_names import FrictionNames
from .running import FmuError, RunningFmu, Value
from .separate_process import Apart, Died

#: Most points of one evaluation of an FMU whose size can be chosen.
_BLOCK = 1024
#: Two ordinary contact states that differ in all loads: an FMU that answers both alike at once may answer after a step.
_PROBES = ((5.0, 50.0, 500.0, 2.0, 1.1), (200.0, 150.0, 1500.0, 20.0, 3.0))
#: Step that lets such an FMU answer [s], where it names none.
_SHORT = 1e-3


class Evaluation:
    """Outputs of a friction FMU at loads; `folder` holds it where it is unpacked already.

    Without names it is one with the variables of the contract. Of one with names, units and habits of its own the points
    of a data set without time are each evaluated from the start state where the FMU can save it, and where outputs
    follow inputs only after a step, it is given a short one.
    Raises InputError: variables that do not fit, no co-simulation, or no contact point.
    """

    def __init__(self, path: Path, names: FrictionNames | None = None, folder: Path | None = None) -> None:
        self.fmu = fmu = UnpackedFmu.of(path, folder)
        self.names = FrictionNames() if names is None else names
        loads = self.names.loads
        self.inputs, self.outputs = [name for name, _ in loads.values()], [self.names.mu]
        if names is None:
            fmu.contact_points()
        for name in (*self.inputs, *self.outputs):
            fmu.check_float64(fmu.resolve(name))
        if fmu.raw.coSimulation is None:
            raise InputError(f"{fmu.path}: the FMU offers no co-simulation, allowed: an FMU that does")
        self.nodes = len(fmu.resolve(self.names.mu))
        if self.nodes < 1:
            raise InputError(f"{fmu.path}: the FMU has no contact point, allowed: at least one")
        #: The parameter that gives the arrays their length; those under other names keep theirs.
        ours = set(loads) == set(LOAD_NAMES) and all(name == load for load, (name, _) in loads.items())
        self.sizing = fmu.sizing(LOAD_NAMES[0]) if ours else None
        self._sized: dict[int, UnpackedFmu] = {}
        self._columns = [LOAD_NAMES.index(load) for load in loads]
        units = [load_conversion(q, u, str(path)) if u else (1.0, 0.0) for q, (_, u) in loads.items()]
        self._factors, self._offsets = np.array([f for f, _ in units]), np.array([o for _, o in units])
        self._saves = names is not None and fmu.claims("canGetAndSetFMUState")
        self._short = _short_step(fmu)
        #: Whether mu follows the loads only after a step; None: not known yet.
        self._late = None if names is not None else False

    def values(
        self,
        array: FloatArray,
        times: tuple[FloatArray, FloatArray] | None,
        start: dict[str, float],
        outputs: list[str],
    ) -> FloatArray:
        """Return an output at points of a test, with their times and pauses, or at points without time.

        Without points it only finds out whether the FMU answers after a step.
        """
        if self._late is None:
            try:
                self._late = self._answers_late()
            except FmuError as error:
                raise InputError(f"{self.fmu.path}: the FMU refuses ordinary loads ({error})") from None
        if not len(array):
            return np.empty(0)
        if times is None:
            return self.at_once(array, start, outputs)
        return self.in_steps(array, *times, start, outputs)

    def _answers_late(self) -> bool:
        """Return whether mu follows the loads only after a step."""
        first, second = (np.tile(p, (max(self._width(1), 1), 1)) for p in _PROBES)
        with self._run(self._width(1), {}) as fmu:
            before = self._evaluate(fmu, first, self.outputs)
            now = self._evaluate(fmu, second, self.outputs)
            if not np.array_equal(before, now):
                return False
            fmu.step(0.0, self._short)
            return not np.array_equal(now, fmu.get_real(self.outputs))

    def at_once(self, array: FloatArray, start: dict[str, float], outputs: list[str]) -> FloatArray:
        """Return an output at points that do not follow each other in time."""
        mu = np.empty(len(array))
        width = self._width(len(array))
        with self._run(width, start) as fmu:
            fresh = fmu.save_state() if self._saves else None
            time = 0.0
            for first in range(0, len(array), width):
                if fresh is not None:
                    fmu.restore_state(fresh)
                    time = 0.0
                rows = np.minimum(np.arange(first, first + width), len(array) - 1)
                values = self._evaluate(fmu, array[rows], outputs)
                if self._late:
                    fmu.step(time, self._short)
                    time += self._short
                    values = fmu.get_real(outputs)
                count = min(width, len(array) - first)
                mu[first : first + count] = values[:count]
            if fresh is not None:
                fmu.free_state(fresh)
        return mu

    def in_steps(
        self,
        array: FloatArray,
        t: FloatArray,
        pause: FloatArray,
        start: dict[str, float],
        outputs: list[str],
    ) -> FloatArray:
        """Return an output all through one test; its memory starts fresh. Before a point the contact stood still for `pause` [s]."""
        mu = np.empty(len(array))
        width = self._width(1)
        with self._run(width, start) as fmu:
            for row in range(len(array)):
                # The loads of a point act over the interval that ends there, then mu is read.
                rows = np.tile(array[row], (width, 1))
                if row:
                    time = float(t[row - 1] - t[0])
                    if pause[row] > 0.0:
                        still = rows.copy()
                        still[:, LOAD_NAMES.index("v_rel")] = 0.0
                        self._write(fmu, still)
                        fmu.step(time, float(pause[row]))
                        time += float(pause[row])
                    self._write(fmu, rows)
                    fmu.step(time, float(t[row] - t[0]) - time)
                mu[row] = self._evaluate(fmu, rows, outputs)[0]
        if self._late:  # the first point is read before any step
            mu[:1] = self.at_once(array[:1], start, outputs)
        return mu

    def _width(self, count: int) -> int:
        """Return how many points are evaluated at once: what fits best where the FMU lets us choose."""
        if self.sizing is None:
            return self.nodes
        lower, upper = self.fmu.limits(self.sizing)
        return max(lower, 1, min(count, _BLOCK if upper is None else upper, _BLOCK))

    def _run(self, width: int, start: Mapping[str, Value]) -> RunningFmu:
        if self.sizing is not None and width not in self._sized:
            self._sized[width] = self.fmu.sized({self.sizing: width})
        return RunningFmu(self._sized.get(width, self.fmu), start={**self.names.start, **start})

    def _write(self, fmu: RunningFmu, rows: FloatArray) -> None:
        values = rows[:, self._columns] * self._factors + self._offsets
        fmu.set_real(self.inputs, values.T)

    def _evaluate(self, fmu: RunningFmu, rows: FloatArray, outputs: list[str]) -> FloatArray:
        self._write(fmu, rows)
        return fmu.get_real(outputs)


class Elsewhere:
    """The same evaluation in a process of its own, which starts with the first question and again after a crash.

    The folder is that of this process: one that crashes cannot tidy up.
    """

    def __init__(self, path: Path, names: FrictionNames | None, folder: Path) -> None:
        self._path = path
        self._arguments = (path, names, folder)
        self._apart: Apart | None = None

    def values(self, *arguments: Any) -> FloatArray:
        """Return what `Evaluation.values` returns there.

        Raises FmuError: the FMU refuses a value, or ends its process.
        """
        if self._apart is None:
            self._apart = Apart(Evaluation, *self._arguments, errors=(FmuError,))
        try:
            return np.asarray(self._apart.call("values", *arguments), dtype=float)
        except Died as end:
            self._apart = None
            raise FmuError(str(end)) from None


def _short_step(fmu: UnpackedFmu) -> float:
    """Return a step that lets an FMU answer [s]."""
    try:
        step = float(fmu.raw.defaultExperiment.stepSize)
    except (AttributeError, TypeError, ValueError):
        return _SHORT
    return step if 0.0 < step < 1.0 else _SHORT
