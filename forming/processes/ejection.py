"""Ejection after the stroke: the punch is withdrawn, then an ejector pushes the product off the tools."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError, unknown_name

from ..fe.contact import PRESSURE
from ..fe.mesh.polyline import SizeField
from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..fe.state import RemeshPolicy, State, StepControl
from ..results.ejection_result import EjectionResult
from ..tools.ejection_tools import Stage, grip_patches
from .ejection_state import TRIALS, EjectionProgress, EjectionRow, EjectionState, StageUnderWay
from .friction_input import Friction, checked_mu
from .run_log import ContactLog
from .stepwise import StepwiseProcess

#: Contact that carries less than this share of the contact at the phase's start holds nothing.
LOOSE = 1e-3
#: A solver that gives up below this share of the highest force has lost a product that is practically free.
NEARLY_LOOSE = 0.02
#: Share of the forming force by which the force may change in one increment.
FORCE_CHANGE = 0.03
#: Element quality below which the product is meshed anew, and the plastic strain since.
REMESH = RemeshPolicy(every=1_000_000, quality=0.15, strain=1.0)


class Ejection:
    """Withdraws the punch from the product of a forming process, then ejects it.

    It starts from the process's present state and leaves the process as it is. The elements are those at the
    end of the stroke, so that the stresses which hold the product are not smeared by a remeshing; the heat goes
    on. The spring of press and punch does not take part: travel is that of the tool itself.

    Parameters
    ----------
    process : StepwiseProcess
        At the end of its stroke.
    how : str or True
        One of `process.ejections`; True: the first.

    Raises
    ------
    InputError
        A way that the process does not have, or the process has stopped or not moved.
    """

    def __init__(self, process: StepwiseProcess, how: str | bool = True) -> None:
        self.process = process
        self.how = ejection_choice(process, how)
        formed = process.simulation
        if formed.state.status != "ok" or formed.state.stroke <= 0.0:
            raise InputError(
                f"{process.name}: eject at stroke {formed.state.stroke:g} mm, status {formed.state.status!r}; "
                "allowed: after a stroke that has not stopped"
            )
        self._formed = formed
        self._forming_force = max(abs(formed.force), 1.0)
        self.status, self.message = "ok", ""
        self.contact = ContactLog(process.n_points)
        self._progress = EjectionProgress()
        self._begin(0, formed.snapshot())

    def _begin(self, number: int, state: State) -> None:
        """Start a stage from the state at the end of the one before."""
        stage = self.process.ejection_stage(self.how, number, state)
        if stage is None:
            self._progress.finished = True
            return
        kept = {tool.name: force for tool, force in zip(state.tools, state.forces)}
        incoming = state.body.velocity.copy()
        self._motion = StageUnderWay(number, stage, incoming, EjectionRow(stage.name, 0.0, 0.0, 0.0, 0.0))
        control = self._control()
        tools = list(copy.deepcopy(stage.tools))
        self.simulation = self._simulation(
            State(
                body=state.body,
                tools=tools,
                markers=state.markers,
                mu=state.mu,
                strain_at_remesh=state.body.strain.copy(),
                next_dt=control.first / max(tool.speed for tool in tools),
                time=state.time,
                energy=state.energy,
                forces=np.array([kept.get(tool.name, np.zeros(2)) for tool in tools]),
            )
        )
        self.simulation.state.body.guess(TRIALS[0][0] * incoming)
        self._motion.last = self._motion.last._replace(force=self._force(self.simulation))

    @property
    def stage(self) -> Stage:
        """The motion under way."""
        return self._motion.stage

    @property
    def finished(self) -> bool:
        """Whether the product is free."""
        return self._progress.finished

    def _control(self) -> StepControl:
        width = float(self._formed.state.body.x[:, 0].max())
        return StepControl(
            first=2e-4 * width,
            largest=0.02 * width,
            smallest=1e-6 * width,
            slip=math.inf,
            force_change=FORCE_CHANGE * self._forming_force,
        )

    def _simulation(self, state: State) -> Simulation:
        formed = self._formed
        simulation = Simulation(
            state.body,
            state.tools,
            formed.material,
            state.markers.start_arc,
            settings=replace(formed.settings, slip_regularisation=TRIALS[self._motion.trial][1]),
            control=self._control(),
            heat=formed.heat,
            size=self._size(),
            policy=REMESH,
            isothermal=formed.heat is None,
        )
        simulation.state = state
        return simulation

    def _size(self) -> Callable[[State], SizeField] | None:
        """Return the sizes at the end of the stroke, moving with the product that the ejector pushes."""
        formed, rides = self._formed, self.stage.clear is None
        if formed.size is None:
            return None
        size = formed.size(formed.state)

        def size_at(state: State) -> SizeField:
            shift = np.array([0.0, state.travel if rides else 0.0])
            return lambda points: size(points - shift)

        return size_at

    def advance(self, step: float = 0.1) -> bool:
        """Move the tool by `step` [mm] at most; the next stage begins by itself.

        Returns
        -------
        bool
            False when the product is free (`finished`), or the run has stopped (`status`, `message`).
        """
        if self.finished or self.status != "ok":
            return False
        mu, before = self.simulation.state.mu, self.simulation.state.stroke
        target = min(before + step, self.stage.longest)
        while not self.simulation.advance_to(target, self._observe) and not self._stage_is_over():
            if not self._try_again():
                break
        simulation = self.simulation
        travelled = simulation.state.stroke - before
        self._progress.travel += travelled
        if travelled > 0.0:
            self.contact.add(simulation, self._progress.travel, mu)
        if self._stage_is_over():
            if self._motion.number == 0:
                self._progress.patches = grip_patches(simulation)
            self._begin(self._motion.number + 1, simulation.snapshot())
        elif simulation.state.status != "ok":
            where = f"{self.stage.name}: stopped at travel"
            self.status = "stopped"
            self.message = simulation.state.message.replace("stopped at stroke", where)
        return not self.finished and self.status == "ok"

    def _try_again(self) -> bool:
        """Continue from the last increment with another guess or a blunter friction law, if one is left."""
        if self._motion.trial + 1 >= len(TRIALS):
            return False
        self._motion.trial += 1
        state, share = self.simulation.state, TRIALS[self._motion.trial][0]
        moved = state.increments + state.remeshes > 0
        state.body.guess(share * (state.body.velocity if moved else self._motion.incoming))
        state.status, state.message, state.failures_in_row = "ok", "", 0
        state.next_dt = self._control().first / self.simulation.speed
        self.simulation = self._simulation(state)
        self._progress.regularisation = max(self._progress.regularisation, TRIALS[self._motion.trial][1])
        return True

    def _observe(self, simulation: Simulation) -> bool:
        state = simulation.state
        self.contact.read_ratio(simulation)
        grip = sum(p.friction for p in grip_patches(simulation))
        last, force = self._motion.last, self._force(simulation)
        work = last.work + 0.5 * (last.force + force) * (state.stroke - last.travel)
        self._motion.last = EjectionRow(self.stage.name, state.stroke, force, work, grip)
        self._progress.rows.append(self._motion.last)
        load = self._load(simulation)
        self._motion.start_load = max(self._motion.start_load, load)
        if load > LOOSE * self._motion.start_load:
            self._motion.last_touch = state.stroke
        return self._stage_is_over()

    def _force(self, simulation: Simulation) -> float:
        """Return the force of the mover against its motion [kN]."""
        state = simulation.state
        k = [tool.name for tool in state.tools].index(self.stage.mover)
        return -float(state.forces[k] @ state.tools[k].velocity) / simulation.speed * 1e-3

    def _load(self, simulation: Simulation) -> float:
        """Return the contact force that must vanish for the stage to be over, whatever its direction [N]."""
        state, load = simulation.state, 0.0
        for tool, table in zip(state.tools, state.tables or []):
            counts = tool.name == self.stage.mover if self.stage.clear is not None else tool.speed == 0.0
            if not counts:
                continue
            pressure = np.maximum(table[:, PRESSURE], 0.0)
            if self.stage.opening is not None:
                pressure = np.where(state.body.surface[:, 1] < self.stage.opening, pressure, 0.0)
            load += 2.0 * math.pi * float(pressure @ state.weights)
        return load

    def _stage_is_over(self) -> bool:
        state, rows = self.simulation.state, self._progress.rows
        if state.stroke >= self.stage.longest - 1e-9:
            return True
        untouched = state.stroke - self._motion.last_touch
        if rows and untouched > 0.0 and untouched >= (self.stage.clear or 0.0):
            return True
        if state.status == "ok":
            return False
        forces = [abs(row.force) for row in rows if row.stage == self.stage.name and row.travel > 0.0]
        return (
            bool(forces)
            and forces[-1] <= NEARLY_LOOSE * max(forces)
            and rows[-1].grip <= NEARLY_LOOSE * max(row.grip for row in rows)
        )

    def set_mu(self, mu: npt.ArrayLike) -> None:
        """Set the coefficients of friction at the markers, shape (n_points,) or one number."""
        self.simulation.state.mu = checked_mu(mu, self.process.n_points, self._progress.travel)

    def loads(self) -> FloatArray:
        """Return v_rel, T, sigma_n, sd, psi of the material markers, shape (n_points, 5)."""
        return self.simulation.state.markers.loads()

    @property
    def time(self) -> float:
        """Time since the start of the forming stroke [s]."""
        return self.simulation.state.time

    def snapshot(self) -> EjectionState:
        """Return the complete state; `restore` continues from it exactly."""
        return copy.deepcopy(EjectionState(self._motion, self._progress, self.simulation.state))

    def restore(self, kept: EjectionState) -> None:
        """Go back to a snapshot of this ejection."""
        self._motion, self._progress, state = copy.deepcopy(kept)
        self.contact.cut(self._progress.travel)
        self.simulation = self._simulation(state)
        self.status, self.message = "ok", ""

    def run(
        self,
        friction: Friction,
        communication_step: float = 0.1,
        progress: Callable[[float], None] | None = None,
    ) -> EjectionResult:
        """Continue until the product is free.

        Parameters
        ----------
        friction : float or callable
            As in `FormingProcess.run`; the coefficients at the end of the stroke act first.
        progress : callable, optional
            Called with the travel so far, all stages together [mm].
        """
        going = True
        while going:
            going = self.advance(communication_step)
            if going and callable(friction):
                try:
                    self.set_mu(friction(self.loads(), self.time))
                except Exception as error:
                    self.status, self.message = "stopped", f"{self.stage.name}: {error}"
                    raise
            if progress is not None:
                progress(self._progress.travel)
        return self.result()

    def result(self) -> EjectionResult:
        """Return the result so far."""
        rows = self._progress.rows
        travel, force, work, grip = np.array([row[1:] for row in rows]).reshape(-1, 4).T
        return EjectionResult(
            how=self.how,
            phase=tuple(row.stage for row in rows),
            travel=travel,
            force=force,
            work=work,
            grip=grip,
            patches=self._progress.patches,
            contact=self.contact.history(),
            energy_balance=self.simulation.state.energy.imbalance,
            slip_regularisation=self._progress.regularisation,
            status=self.status,
            message=self.message,
        )


def ejection_choice(process: StepwiseProcess, how: str | bool) -> str:
    """Return the name of a way to eject the product of a process.

    Raises InputError: the process has no such way.
    """
    if not process.ejections:
        raise InputError(f"{process.name}: eject = {how!r}; allowed: False, its product is held by no tool")
    if how is True:
        return process.ejections[0]
    if how not in process.ejections:
        raise unknown_name(f"way to eject from {process.name}", str(how), process.ejections)
    return str(how)
