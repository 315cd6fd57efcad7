"""Master of a co-simulation: runs the components of a system step by step and exchanges their values.

Modes
-----
gauss_seidel
    Components run in their order; each gets the newest outputs. With friction first, the forming process uses in step n the
    friction coefficient of the loads at the end of step n - 1: the same lag of one step as a friction subroutine of a solver.
jacobi
    All components get the outputs of the previous step, which is a lag of two steps. libcosim and ecos do the same and give
    the same numbers.
iterated
    Each step is repeated from a saved FMU state until the values of every connection agree, so there is no lag. All FMUs
    must be able to save their state. `iteration` says when repetitions agree.

In every mode, connected inputs are initialized along the connections before the first step.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from fmus.archive.made_here import runs_apart
from fmus.runtime.contact_points import PointInstances
from fmus.runtime.errors import SimulationEnded, SimulationError
from fmus.runtime.fmu_files import unpack
from fmus.runtime.instance import AnyInstance, Instance
from fmus.runtime.interrupts import Interrupts
from fmus.runtime.isolated import IsolatedInstance
from friction_models.common import InputError, check_folder, unknown_name
from friction_models.common.folders import RUN
from friction_models.loads import FloatArray

from . import iteration
from .components import Components
from .iteration import FixedPointIteration
from .run_folders import Course, Run, write_run
from .setup.coupling_warnings import coupling_warnings
from .setup.wiring import Wiring
from .system import System

MODES = ("gauss_seidel", "jacobi", "iterated")

Progress = Callable[[float], None]


class Master:
    """Runs a system of FMUs.

    Parameters
    ----------
    system : System
        What to run.
    mode : {"gauss_seidel", "jacobi", "iterated"}
        How the components exchange values.
    tolerance : float
        Mode ``iterated``: repetitions agree when the values of every connection change by less than this
        share of their largest.
    isolate : bool, optional
        Run every FMU in a process of its own, where a crash does no harm, or none. By default those that were not
        made on this machine (`fmus.archive.made_here`).

    Attributes
    ----------
    course : Course
        What happened in the last run, beside its results.

    Raises
    ------
    InputError
        Unknown mode, a tolerance that is not between 0 and 1, a component that cannot save its state where
        the mode needs it, or errors in the set-up (all at once).

    Examples
    --------
    A table of temperatures feeds a friction FMU:

    >>> from fmus import pack, pack_signals
    >>> from friction_models import ConstantFriction
    >>> place = tempfile.TemporaryDirectory()
    >>> here = Path(place.name)
    >>> table = pack_signals(here / "table.fmu", [0.0, 0.1, 0.2], {"T": ("degC", "temperature", [20.0, 80.0])})
    >>> law = pack(ConstantFriction(mu=0.1), here / "law.fmu", target="python")
    >>> system = System.from_dict({
    ...     "communication_step": 0.1, "stop_time": 0.2,
    ...     "components": {"table": {"fmu": str(table)}, "friction": {"fmu": str(law)}},
    ...     "connections": ["table.T -> friction.T"],
    ... })
    >>> run = Master(system, mode="jacobi").run(here / "run")
    >>> run.time, run["table.T"], run["friction.mu"]
    (array([0. , 0.1, 0.2]), array([20., 20., 80.]), array([0.1, 0.1, 0.1]))
    >>> place.cleanup()
    """

    def __init__(
        self,
        system: System,
        mode: str = "gauss_seidel",
        tolerance: float = iteration.TOLERANCE,
        isolate: bool | None = None,
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
        #: Sentences about inputs that nothing feeds, algebraic loops, and friction that lags too far.
        self.warnings = [*self.wiring.notes, *coupling_warnings(system, self.wiring, mode)]
        #: Components that run in a process of their own.
        self.isolated = {n for n, d in self.wiring.descriptions.items() if runs_apart(d.path, isolate)}
        self.course = self._unstarted()
        self._iteration: FixedPointIteration | None = None
        self._interrupts = Interrupts()

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
        InputError
            `folder` holds something else than a run; an FMU that cannot be loaded or creates no instance.
        SimulationError
            A component failed; the message says which, when and why, and what is kept.
        KeyboardInterrupt
            Ctrl-C, between two steps or two seconds after it in a step of an isolated FMU; the message says what is kept.
        """
        check_folder(folder, RUN)
        self.course = course = self._unstarted()
        began = time.perf_counter()
        # Binaries cannot be deleted while they are mapped on some platforms: folders go after the instances.
        work = Path(tempfile.mkdtemp(prefix="tribofmu-"))
        try:
            with ExitStack() as stack:
                self._interrupts = stack.enter_context(Interrupts())
                instances: dict[str, AnyInstance] = {}
                for name in self.wiring.descriptions:
                    instances[name] = self._open(name, work / name)
                    stack.callback(instances[name].close)
                    self._interrupts.check()
                history = self._integrate(Components.of(self.system, self.wiring, instances), progress)
                timing = {name: instance.seconds for name, instance in instances.items()}
        finally:
            shutil.rmtree(work, ignore_errors=True)
        timing["master"] = max(0.0, course.loop_seconds - sum(timing.values()))
        timing["setup"] = time.perf_counter() - began - course.loop_seconds
        timing["total"] = time.perf_counter() - began
        course.timing = timing
        run = write_run(Path(folder), self.system, self.wiring, course, history, csv)
        if course.stopped is not None:
            kept = f"{course.stopped}; kept in {folder}: {len(run.time) - 1} steps until then"
            raise type(course.stopped)(kept)
        return run

    def _open(self, name: str, folder: Path) -> AnyInstance:
        folder.mkdir()
        fmu = unpack(self.wiring.descriptions[name], folder)
        parts = self.system.parts(name)
        if name in self.isolated:
            points = self.wiring.points.get(name)
            waiting = self._interrupts.check_waiting
            return IsolatedInstance(name, fmu, points, self.course.log, parts, waiting)
        if name in self.wiring.points:
            return PointInstances(name, fmu, self.wiring.points[name], self.course.log, parts)
        return Instance(name, fmu, self.course.log, parts)

    def _integrate(self, components: Components, progress: Progress | None) -> dict[str, FloatArray]:
        components.initialize(self.wiring, self.system.stop_time)
        for name in components.needed_at_start(self.mode):
            components.check_numbers(name, 0.0)
        recorded = [
            (
                item.label,
                components.outputs[item.component],
                np.array([components.outputs[item.component].index[v.name] for v in item.elements]),
            )
            for item in self.wiring.recorded
        ]
        steps, size = self.system.steps, self.system.communication_step
        history = {label: np.empty((steps + 1, len(rows))) for label, _, rows in recorded}
        made = 0
        loop = time.perf_counter()
        for k in range(steps + 1):
            if k and not self._advance(components, (k - 1) * size, size):
                break
            for label, port, rows in recorded:
                history[label][k] = port.values[rows]
            made = k
            if progress is not None:
                progress(k / steps)
            ended = [name for name, instance in components.instances.items() if instance.ended]
            if ended and k < steps:
                self.course.ending = f"component {ended[0]!r} ended the simulation at t = {k * size:g} s"
                break
        self.course.loop_seconds = time.perf_counter() - loop
        if self.course.ending:
            self.course.ending += f", before the stop time of {self.system.stop_time:g} s"
        if self.course.stopped is not None and not made:
            raise type(self.course.stopped)(
                f"{self.course.stopped}; nothing was written, as no step was complete"
            )
        return {label: values[: made + 1] for label, values in history.items()}

    def _advance(self, components: Components, now: float, size: float) -> bool:
        """Make a step; return whether it is complete, and keep why not."""
        advance = {"jacobi": self._jacobi, "gauss_seidel": self._gauss_seidel, "iterated": self._iterated}
        try:
            self._interrupts.check()
            advance[self.mode](components, now, size)
            return True
        except SimulationEnded as end:
            self.course.ending = str(end)
        except SimulationError as error:
            # An FMU that saw the interrupt itself may have failed by it.
            self.course.stopped = self._interruption(now) if self._interrupts.asked else error
        except KeyboardInterrupt:
            self.course.stopped = self._interruption(now)
        return False

    def _interruption(self, now: float) -> KeyboardInterrupt:
        return KeyboardInterrupt(f"interrupted at t = {now:g} s")

    def _gauss_seidel(self, components: Components, now: float, size: float) -> None:
        for name in components.order:
            components.hand_over(name)
            components.step(name, now, size)
            self._interrupts.check()

    def _jacobi(self, components: Components, now: float, size: float) -> None:
        for name in components.order:
            components.hand_over(name)
        for name in components.order:
            components.step(name, now, size)
            self._interrupts.check()

    def _iterated(self, components: Components, now: float, size: float) -> None:
        outputs, instances = components.outputs, components.instances
        if self._iteration is None or self._iteration.outputs is not outputs:
            self._iteration = FixedPointIteration(
                self.wiring.links, outputs, components.order, self.tolerance
            )
        fixed_point = self._iteration
        with ExitStack() as stack:
            saved = {}
            for name, instance in instances.items():
                saved[name] = instance.save_state(now)
                stack.callback(instance.free_state, saved[name])
            fixed_point.begin()
            while fixed_point.repetitions < iteration.MOST_REPETITIONS:
                if fixed_point.repetitions:
                    for name, instance in instances.items():
                        instance.restore_state(saved[name], now)
                    fixed_point.pass_on()
                self._gauss_seidel(components, now, size)
                if fixed_point.converged():
                    self.course.iterations.append(fixed_point.repetitions)
                    self.course.changes.append(fixed_point.change)
                    self.course.lagging.append(fixed_point.lagging)
                    return
        raise SimulationError(
            f"the step at t = {now:g} s did not converge in {fixed_point.repetitions} repetitions: {fixed_point.where} still "
            f"changes by {100 * fixed_point.change:.2g} %; use a smaller communication step or the mode 'gauss_seidel'"
        )

    def _unstarted(self) -> Course:
        return Course(self.mode, self.tolerance, self.isolated, self.warnings)
