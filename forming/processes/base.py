"""What every forming process offers: a run with given friction, or step by step for a co-simulation."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.common.ranges import check_flag, check_range

from ..fe.mesh.mesher import MeshError
from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..fe.state import State
from ..materials.materials import MaterialSource, as_material
from ..results.field_recorder import recorder_for
from ..results.result import FormingResult
from ..tools.ejection_tools import Stage
from .ejection import Ejection, ejection_choice
from .friction_input import Friction, checked_mu, start_mu
from .run_log import RunLog
from .thermal_conditions import RANGES, HeatInput


class FormingProcess(ABC):
    """A forming process with material markers on the workpiece surface.

    A subclass gives what all processes have to this constructor, checks its own numbers with `_number`, and says
    how the simulation is built. The parameters are described there.

    Attributes
    ----------
    name : str
        For messages.
    units : dict of str to str
        The parameters that are one number, and their units, in the order in which they were checked.

    Raises
    ------
    InputError
        A number outside its range, or a material that cannot be.
    """

    name: str
    #: What the last `run` gave; after an error in the friction law, too: what there was until then.
    result: FormingResult | None = None
    #: Ways to get the product off the tools; the first is the usual one.
    ejections: tuple[str, ...] = ()
    _simulation: Simulation | None = None

    def __init__(
        self,
        speed: float,
        T_billet: float,
        T_tool: float,
        material: MaterialSource,
        n_points: int,
        tool_heating: bool,
        tool_material: MaterialSource,
        htc: float,
        T_ambient: float,
        h_ambient: float,
    ) -> None:
        self.units: dict[str, str] = {}
        self.speed = self._number("speed", speed, 0.01, 2000.0, "mm/s")
        self.T_billet = self._number("T_billet", T_billet, -50.0, 700.0, "degC")
        self.T_tool = self._number("T_tool", T_tool, -50.0, 700.0, "degC")
        check_range(self.name, "n_points", n_points, 8, 2000, "")
        self.n_points = int(n_points)
        self.tool_heating = check_flag(self.name, "tool_heating", tool_heating)
        self.material = as_material(material)
        self.material.check_start(self.name, T_billet)
        self.heat_input = HeatInput(self.name, tool_material, htc, T_ambient, h_ambient)
        self.units |= {name: unit for name, (_, _, unit) in RANGES.items()}

    def _number(self, name: str, value: float, low: float, high: float, unit: str) -> float:
        """Return a parameter that is one number, checked, and remember its unit."""
        self.units[name] = unit
        check_range(self.name, name, value, low, high, unit)
        return value

    def _optional(self, name: str, value: float | None, low: float, high: float, unit: str) -> float | None:
        """Do the same for a number that may be left out (None)."""
        self.units[name] = unit
        return None if value is None else self._number(name, value, low, high, unit)

    def ejection_stage(self, how: str, number: int, state: State) -> Stage | None:
        """Return the stage of an ejection that starts from a state; None when there is no further one."""
        raise NotImplementedError(self.name)

    @abstractmethod
    def _build(self) -> Simulation:
        """Return the simulation at stroke 0."""

    @property
    @abstractmethod
    def max_stroke(self) -> float:
        """Largest stroke [mm]."""

    def _check_stroke(self, billet_length: float) -> None:
        """Raise when the billet is too short for any stroke."""
        if self.max_stroke < 0.1:
            shortest = billet_length - self.max_stroke + 0.1
            raise InputError(
                f"{self.name}: billet_length = {billet_length:g} mm; allowed: at least {shortest:.3g} mm in these tools"
            )

    def start(self, mu: Friction = 0.08) -> None:
        """Put the billet between the tools; `mu` acts until `set_mu` is called."""
        first = start_mu(mu, self.n_points, self.T_billet)
        try:
            self._simulation = self._build()
        except MeshError as error:
            raise InputError(
                f"{self.name}: billet or tools cannot be meshed ({error}); allowed: a smaller mesh_size, or radii "
                "and a land that are not far below it"
            ) from None
        self._simulation.state.mu = first

    @property
    def simulation(self) -> Simulation:
        """The running simulation.

        Raises
        ------
        InputError
            `start` has not been called.
        """
        if self._simulation is None:
            raise InputError(f"{self.name}: not started; call start() before anything else")
        return self._simulation

    def advance(
        self, communication_step: float = 0.1, observer: Callable[[Simulation], bool] | None = None
    ) -> bool:
        """Move the punch by `communication_step` [mm] with the friction set last.

        `observer` sees the simulation after each increment, a `field_recorder.FieldRecorder` for example; it must
        not change it, and returns False.

        Returns
        -------
        bool
            False when the run has stopped; `status` and `message` say why, and nothing moves any more.
        """
        check_range(self.name, "communication_step", communication_step, 1e-4, 10.0, "mm")
        target = self.stroke + communication_step
        if target > self.max_stroke + 1e-6:
            raise InputError(
                f"{self.name}: stroke {target:.3f} mm; allowed: at most {self.max_stroke:.3f} mm, "
                "where the punch would come too close to the die"
            )
        return self.simulation.advance_to(target, observer)

    def loads(self) -> FloatArray:
        """Return v_rel, T, sigma_n, sd, psi of the material markers, shape (n_points, 5).

        Markers out of contact keep v_rel, T and sigma_n of their last contact (start: 0, T_billet, 0).
        """
        return self.simulation.state.markers.loads()

    @property
    def active(self) -> npt.NDArray[np.bool_]:
        """Which markers are in contact, shape (n_points,)."""
        return self.simulation.state.markers.active.copy()

    @property
    def marker_position(self) -> FloatArray:
        """r, z of the markers [mm], shape (n_points, 2)."""
        state = self.simulation.state
        return state.markers.points(state.body.surface)

    def set_mu(self, mu: npt.ArrayLike) -> None:
        """Set the coefficients of friction at the markers, shape (n_points,) or one number.

        Raises
        ------
        InputError
            NaN, negative, too large, or of another shape.
        """
        self.simulation.state.mu = checked_mu(mu, self.n_points, self.stroke)

    @property
    def stroke(self) -> float:
        """Travel of the ram [mm]; that of the punch, too, where press and punch are rigid."""
        return self.simulation.state.stroke

    @property
    def compression(self) -> float:
        """How much punch and press are shortened by the force [mm]."""
        return self.simulation.state.compression

    @property
    def expansion(self) -> float:
        """How far the bore of the die has moved outward [mm]."""
        return max(
            (float(t.offset[0]) for t in self.simulation.state.tools if t.flexibility > 0.0), default=0.0
        )

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.simulation.state.time

    @property
    def force(self) -> float:
        """Punch force [kN]."""
        return self.simulation.force * 1e-3

    @property
    def work(self) -> float:
        """Work of the ram so far [J]."""
        return self.simulation.state.ram_work * 1e-3

    @property
    def max_tau_over_k(self) -> float:
        """Highest friction stress over shear yield stress in the last increment."""
        history = self.simulation.state.history
        return history[-1].max_tau_over_k if history else 0.0

    @property
    def status(self) -> str:
        """``"ok"`` or ``"stopped"``."""
        return self.simulation.state.status

    @property
    def warnings(self) -> tuple[str, ...]:
        """Where the run so far has left what is known of the material."""
        history = self.simulation.state.history
        highest = (
            max((getattr(h, n) for h in history), default=0.0) for n in ("strain_max", "rate_max", "T_max")
        )
        return self.material.left_range(*highest)

    @property
    def message(self) -> str:
        """Where and why the run stopped, or empty."""
        return self.simulation.state.message

    def snapshot(self) -> State:
        """Return the complete state; `restore` continues from it exactly."""
        return self.simulation.snapshot()

    def restore(self, snapshot: State) -> None:
        """Go back to a snapshot of this process."""
        self.simulation.restore(snapshot)

    def run(
        self,
        friction: Friction = 0.08,
        stroke: float = 20.0,
        progress: Callable[[float], None] | None = None,
        communication_step: float = 0.1,
        snapshots: int | Sequence[float] | None = None,
        eject: bool | str = False,
    ) -> FormingResult:
        """Extrude by `stroke` [mm] from a fresh billet.

        Parameters
        ----------
        friction : float or callable
            Coefficient of friction, or ``friction(loads[n, 5], t) -> mu[n]``, evaluated after each
            communication step and used in the next: a lag of one step.
        progress : callable, optional
            Called with the share of the stroke done.
        communication_step : float
            Travel between two evaluations of the friction [mm].
        snapshots : int or sequence of float, optional
            Keep the fields: so many times, evenly from the start to the end, or at these strokes [mm].
        eject : bool or str
            After the stroke, withdraw the punch and get the product off the tools: True, or one of `ejections`.
            `result.ejection` holds what it took; a stroke that stops is not followed by it.

        Raises
        ------
        InputError
            An impossible stroke, or friction that is NaN or negative; `result` then holds what there was
            until then.
        """
        check_range(self.name, "stroke", stroke, 1e-3, self.max_stroke, "mm")
        check_range(self.name, "communication_step", communication_step, 1e-4, 10.0, "mm")
        how = ejection_choice(self, eject) if eject else None
        self.start(friction)
        steps = max(1, math.ceil(stroke / communication_step - 1e-9))
        recorder = None if snapshots is None else recorder_for(snapshots, stroke, self.name)
        log = RunLog(self, recorder)
        for k in range(steps):
            mu = self.simulation.state.mu
            log.end = stroke * (k + 1) / steps
            going = self.advance(log.end - self.stroke, log.observe)
            log.add(mu)
            if not going:
                break
            if callable(friction):
                try:
                    self.set_mu(friction(self.loads(), self.time))
                except Exception as error:
                    message = f"stopped at stroke {self.stroke:.3f} mm: {error}"
                    self.result = replace(log.result(), status="stopped", message=message)
                    raise
            if progress is not None:
                progress((k + 1) / steps)
        self.result = log.result()
        if how is not None and self.result.status == "ok":
            ejection = Ejection(self, how)
            try:
                ejection.run(friction, communication_step)
            finally:
                self.result = replace(self.result, ejection=ejection.result())
        return self.result
