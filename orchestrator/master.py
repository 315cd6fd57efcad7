"""The master: runs the components of a system step by step and hands values from one to the other.

Modes
-----
gauss_seidel
    Components run in their order; each sees the newest outputs. Friction first gives the one-step lag
    of the user subroutine: in step n the forming process uses mu of the loads that it published at the
    end of step n - 1.
jacobi
    All components see the outputs of the previous step: two increments of lag. This is what libcosim and
    ecos do, with the same numbers.
iterated
    Each step is repeated from a saved FMU state until the values of every connection agree: no lag. Needs
    FMUs that can save their state; shows what the lag costs. See `iteration` for when repetitions agree.

Before the first step connected inputs are initialized along the connections in every mode.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from friction_models.loads import FloatArray, InputError, unknown_name

from . import iteration
from .errors import SimulationError
from .fmu_files import unpack
from .instance import Instance
from .iteration import Settling
from .points import PointInstances
from .ports import Port
from .runs import Run, write_run
from .system import System
from .untouched import Patch, Untouched
from .wiring import Wiring

MODES = ("gauss_seidel", "jacobi", "iterated")

Progress = Callable[[float], None]
AnyInstance: TypeAlias = Instance | PointInstances
_Index: TypeAlias = npt.NDArray[np.intp] | slice


@dataclass
class _Transfer:
    """Where the values between two components stand in the arrays of their ports; scaled where units differ."""

    source: str
    rows: _Index
    target: str
    places: _Index
    scale: tuple[FloatArray, FloatArray] | None
    patches: list[Patch]


class Master:
    """Runs a system.

    Parameters
    ----------
    system : System
        What to run.
    mode : {"gauss_seidel", "jacobi", "iterated"}
        How the components exchange values.
    tolerance : float
        Mode ``iterated``: repetitions agree when the values of every connection change by less than this
        share of their largest.

    Raises
    ------
    InputError
        Unknown mode, a tolerance that is not between 0 and 1, a component that cannot save its state where
        the mode needs it, or a set-up that does not hold (all problems at once).
    """

    def __init__(
        self, system: System, mode: str = "gauss_seidel", tolerance: float = iteration.TOLERANCE
    ) -> None:
        if mode not in MODES:
            raise unknown_name("mode", mode, MODES)
        if not 0.0 < tolerance < 1.0:
            raise InputError(f"tolerance = {tolerance!r}, allowed: more than 0 and less than 1")
        self.tolerance = tolerance
        self.system = system
        self.mode = mode
        self.wiring = Wiring.of(system)
        if mode == "iterated":
            stuck = [n for n, d in self.wiring.descriptions.items() if not d.state_can_be_saved]
            if stuck:
                raise InputError(
                    f"{system.source}: component {', '.join(map(repr, stuck))} cannot save its state "
                    "(canGetAndSetFMUstate / canGetAndSetFMUState is not true); mode 'iterated' needs that, "
                    "allowed for it: gauss_seidel, jacobi"
                )
        self._log: list[str] = []
        self._iterations: list[int] = []
        self._changes: list[float] = []
        self._settling: Settling | None = None
        self._failure: SimulationError | None = None
        #: Wall time of the stepping loop of the last run [s], without loading and writing.
        self.loop_seconds = 0.0

    def run(self, folder: str | os.PathLike[str], progress: Progress | None = None, csv: bool = False) -> Run:
        """Run from 0 to the stop time and write a run folder.

        Parameters
        ----------
        folder : path-like
            The run folder; replaced as a whole at the end. When a component fails, it gets the steps until then.
        progress : callable, optional
            Called with the share done, 0 to 1.
        csv : bool
            Also write ``results.csv``.

        Returns
        -------
        Run
            The run as it was written.

        Raises
        ------
        SimulationError
            A component failed; the message says which, when and why, and what is kept.
        """
        self._log, self._iterations, self._changes, self._failure = [], [], [], None
        began = time.perf_counter()
        # Binaries cannot be deleted while they are mapped on some platforms: folders go after the instances.
        work = Path(tempfile.mkdtemp(prefix="tribofmu-"))
        try:
            with ExitStack() as stack:
                instances: dict[str, AnyInstance] = {}
                for name in self.wiring.descriptions:
                    instances[name] = self._open(name, _made(work / name))
                    stack.callback(instances[name].close)
                history = self._integrate(instances, progress)
                timing = {name: instance.seconds for name, instance in instances.items()}
        finally:
            shutil.rmtree(work, ignore_errors=True)
        timing["master"] = max(0.0, self.loop_seconds - sum(timing.values()))
        timing["setup"] = time.perf_counter() - began - self.loop_seconds
        timing["total"] = time.perf_counter() - began
        run = write_run(Path(folder), self, history, timing, self._log, csv, str(self._failure or ""))
        if self._failure is not None:
            raise SimulationError(f"{self._failure}; kept in {folder}: {len(run.time) - 1} steps until then")
        return run

    def _open(self, name: str, folder: Path) -> AnyInstance:
        description = self.wiring.descriptions[name]
        unpacked = unpack(description, folder)
        if name in self.wiring.points:
            return PointInstances(name, description, unpacked, self.wiring.points[name], self._log)
        return Instance(name, description, unpacked, self._log)

    def _integrate(
        self, instances: dict[str, AnyInstance], progress: Progress | None
    ) -> dict[str, FloatArray]:
        system, wiring = self.system, self.wiring
        inputs, outputs, transfers = self._ports()
        order = system.evaluation_order()
        incoming = {name: [t for t in transfers if t.target == name] for name in order}
        self._initialize(instances, incoming, inputs, outputs)
        recorded = [
            (
                item.label,
                item.component,
                np.array([outputs[item.component].index[v.name] for v in item.elements]),
            )
            for item in wiring.recorded
        ]
        steps, size = system.steps, system.communication_step
        history = {label: np.empty((steps + 1, len(rows))) for label, _, rows in recorded}
        advance = {"jacobi": _jacobi, "gauss_seidel": _gauss_seidel, "iterated": self._iterated}[self.mode]
        loop = time.perf_counter()
        for k in range(steps + 1):
            if k:
                try:
                    advance(instances, order, incoming, inputs, outputs, (k - 1) * size, size)
                except SimulationError as error:
                    if k == 1:
                        raise
                    self._failure = error
                    history = {label: values[:k] for label, values in history.items()}
                    break
            for label, component, rows in recorded:
                history[label][k] = outputs[component].values[rows]
            if progress is not None:
                progress(k / steps)
        self.loop_seconds = time.perf_counter() - loop
        return history

    def _ports(self) -> tuple[dict[str, Port], dict[str, Port], list[_Transfer]]:
        inputs: dict[str, Port] = {}
        outputs: dict[str, Port] = {}
        for name in self.wiring.descriptions:
            fed = [v for link in self.wiring.links if link.target == name for v in link.targets]
            given = [v for link in self.wiring.links if link.source == name for v in link.sources]
            given += [v for item in self.wiring.recorded if item.component == name for v in item.elements]
            inputs[name] = Port(fed)
            outputs[name] = Port({v.name: v for v in given}.values())
        # One transfer for all connections of a pair of components.
        pairs: dict[tuple[str, str], tuple[list[int], list[int], list[float], list[float]]] = {}
        patches: dict[tuple[str, str], list[Patch]] = {}
        careful = {
            name: Untouched.of(name, self.wiring.links, outputs)
            for name, component in self.system.components.items()
            if component.contact_only
        }
        for link in self.wiring.links:
            rows, places, factors, offsets = pairs.setdefault((link.source, link.target), ([], [], [], []))
            for name, untouched in careful.items():
                patch = untouched.patch(name, link, len(rows)) if untouched is not None else None
                if patch is not None:
                    patches.setdefault((link.source, link.target), []).append(patch)
            rows += [outputs[link.source].index[v.name] for v in link.sources]
            places += [inputs[link.target].index[v.name] for v in link.targets]
            factors += [link.factor] * len(link.sources)
            offsets += [link.offset] * len(link.sources)
        transfers = []
        for (source, target), (rows, places, factors, offsets) in pairs.items():
            scaled = any(f != 1.0 for f in factors) or any(offsets)
            scale = (np.array(factors), np.array(offsets)) if scaled else None
            transfers.append(
                _Transfer(
                    source, _places(rows), target, _places(places), scale, patches.get((source, target), [])
                )
            )
        return inputs, outputs, transfers

    def _initialize(
        self,
        instances: dict[str, AnyInstance],
        incoming: dict[str, list[_Transfer]],
        inputs: dict[str, Port],
        outputs: dict[str, Port],
    ) -> None:
        """Initialize all components, connected inputs with what feeds them.

        Values pass along the connections as often as there are components, so that they get through any
        chain of them; libcosim and ecos do the same, and start from the same values.
        """
        for name, instance in instances.items():
            instance.enter_initialization(self.wiring.starts[name], self.system.stop_time)
            if inputs[name].is_partial:
                instance.read(inputs[name])  # the elements that no connection feeds
        for _ in instances:
            for name, instance in instances.items():
                instance.read(outputs[name])
            for name, instance in instances.items():
                _transfer(incoming[name], inputs, outputs)
                instance.write(inputs[name])
        for name, instance in instances.items():
            instance.exit_initialization()
            instance.read(outputs[name])

    def _iterated(
        self,
        instances: dict[str, AnyInstance],
        order: list[str],
        incoming: dict[str, list[_Transfer]],
        inputs: dict[str, Port],
        outputs: dict[str, Port],
        now: float,
        size: float,
    ) -> None:
        if self._settling is None or self._settling.outputs is not outputs:
            self._settling = Settling(self.wiring.links, outputs, self.tolerance)
        settling = self._settling
        with ExitStack() as stack:
            saved = {}
            for name, instance in instances.items():
                saved[name] = instance.save_state(now)
                stack.callback(instance.free_state, saved[name])
            settling.begin()
            while settling.repetitions < iteration.MOST_REPETITIONS:
                if settling.repetitions:
                    for name, instance in instances.items():
                        instance.restore_state(saved[name], now)
                    settling.pass_on()
                _gauss_seidel(instances, order, incoming, inputs, outputs, now, size)
                if settling.settled():
                    self._iterations.append(settling.repetitions)
                    self._changes.append(settling.change)
                    return
        raise SimulationError(
            f"the step at t = {now:g} s did not converge in {settling.repetitions} repetitions: {settling.where} still "
            f"changes by {100 * settling.change:.2g} %; use a smaller communication step or the mode 'gauss_seidel'"
        )

    @property
    def iterations(self) -> list[int]:
        """Repetitions of each step of the last run in the mode ``iterated``."""
        return list(self._iterations)

    @property
    def changes(self) -> list[float]:
        """Largest relative change of a connection in the last repetition of each of these steps."""
        return list(self._changes)


def _transfer(transfers: list[_Transfer], inputs: dict[str, Port], outputs: dict[str, Port]) -> None:
    for item in transfers:
        values = outputs[item.source].values[item.rows]
        if item.scale is not None:
            values = item.scale[0] * values + item.scale[1]
        if item.patches:
            values = values.copy()  # a slice shows the outputs themselves
            for patch in item.patches:
                patch.apply(values, outputs)
        inputs[item.target].values[item.places] = values


def _gauss_seidel(
    instances: dict[str, AnyInstance],
    order: list[str],
    incoming: dict[str, list[_Transfer]],
    inputs: dict[str, Port],
    outputs: dict[str, Port],
    now: float,
    size: float,
) -> None:
    for name in order:
        _transfer(incoming[name], inputs, outputs)
        instances[name].step(inputs[name], outputs[name], now, size)


def _jacobi(
    instances: dict[str, AnyInstance],
    order: list[str],
    incoming: dict[str, list[_Transfer]],
    inputs: dict[str, Port],
    outputs: dict[str, Port],
    now: float,
    size: float,
) -> None:
    for name in order:
        _transfer(incoming[name], inputs, outputs)
    for name in order:
        instances[name].step(inputs[name], outputs[name], now, size)


def _places(numbers: list[int]) -> _Index:
    """Return an index for these places: a slice where they follow each other, which is faster."""
    first = numbers[0]
    if numbers == list(range(first, first + len(numbers))):
        return slice(first, first + len(numbers))
    return np.array(numbers, dtype=np.intp)


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder
