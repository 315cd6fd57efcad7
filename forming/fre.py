"""Forward rod extrusion: a run with given friction, or step by step for a co-simulation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from friction_models.loads import InputError

from .fe.body import Body
from .fe.contact import gap_and_normal
from .fe.polyline import distance_to_segment
from .fe.resample import mesh_inside, resample
from .fe.shape import FloatArray
from .fe.simulation import Simulation
from .fe.state import State, StepControl
from .friction_input import Friction, checked_mu, start_mu
from .material import HenselSpittel, steel_16MnCr5
from .result import ContactHistory, FormingResult
from .tooling import ExtrusionDie, Tool, block_field, flat_punch

#: Gap between billet and container, so that the first touch is at the die shoulder [mm].
CLEARANCE = 0.05


@dataclass(frozen=True)
class _DieSize:
    """Element size: fine along cone and land, finest at the edge into the land, coarse elsewhere."""

    finest: float
    base: float
    die: ExtrusionDie
    cone_end_z: float

    def __call__(self, points: FloatArray) -> FloatArray:
        die = self.die
        low = np.array([die.exit_radius, die.land - 0.5])
        high = np.array([die.container_radius, self.cone_end_z])
        edge = (die.exit_radius + 0.2 * die.edge_radius, die.land + 0.4 * die.edge_radius)
        along = self.base + 0.12 * np.maximum(0.0, distance_to_segment(points, low, high) - 1.0)
        to_edge = np.hypot(points[:, 0] - edge[0], points[:, 1] - edge[1]) - 0.7 * die.edge_radius - 0.3
        near_edge = self.finest + 0.2 * np.maximum(0.0, to_edge)
        largest = 2.25 * self.base
        rod = min(largest, max(die.exit_radius / 4.0, self.base))
        return np.minimum(np.minimum(along, near_edge), np.where(points[:, 1] < die.land, rod, largest))


class ForwardRodExtrusion:
    """Axisymmetric forward rod extrusion with rigid tools that take up heat.

    Parameters
    ----------
    diameter, exit_diameter : float
        Container and land diameter [mm].
    half_angle : float
        Half the die opening angle [degrees]: 45 for 2 alpha = 90.
    billet_length : float
        Length of the billet [mm].
    speed : float
        Punch speed [mm/s].
    T_billet, T_tool : float
        Temperatures of billet and tools at the start [degC]. The contact temperature at a marker is the mean
        of the workpiece and the tool surface.
    material : HenselSpittel, optional
        Billet; 16MnCr5 by default.
    mesh_size : float
        Element size in the die [mm]; smaller where the exit radius asks for it.
    n_points : int
        Number of material markers on the billet surface.
    entry_radius, edge_radius, land : float
        Roundings and land of the die [mm].
    tool_heating : bool
        Conduct heat in the tools; False holds their surfaces at `T_tool`.

    Raises
    ------
    InputError
        A dimension, speed or temperature that cannot be; the message names it, its value and what is allowed.
    """

    def __init__(
        self,
        diameter: float = 20.0,
        exit_diameter: float = 14.14,
        half_angle: float = 45.0,
        billet_length: float = 30.0,
        speed: float = 5.0,
        T_billet: float = 20.0,
        T_tool: float = 20.0,
        material: HenselSpittel | None = None,
        mesh_size: float = 0.4,
        n_points: int = 80,
        entry_radius: float = 2.0,
        edge_radius: float = 1.5,
        land: float = 2.0,
        tool_heating: bool = True,
    ) -> None:
        _check("diameter", diameter, 2.0, 200.0, "mm")
        _check("exit_diameter", exit_diameter, 0.2 * diameter, 0.97 * diameter, "mm")
        _check("half_angle", half_angle, 10.0, 80.0, "degrees")
        _check("billet_length", billet_length, 0.5 * diameter, 10.0 * diameter, "mm")
        _check("speed", speed, 0.01, 2000.0, "mm/s")
        _check("T_billet", T_billet, -50.0, 700.0, "degC")
        _check("T_tool", T_tool, -50.0, 700.0, "degC")
        _check("mesh_size", mesh_size, 0.005 * diameter, 0.05 * diameter, "mm")
        _check("n_points", n_points, 8, 2000, "")
        _check("entry_radius", entry_radius, 0.05, 0.5 * diameter, "mm")
        _check("edge_radius", edge_radius, 0.05, 0.5 * diameter, "mm")
        _check("land", land, 0.1, diameter, "mm")
        self.die = ExtrusionDie(
            0.5 * diameter, 0.5 * exit_diameter, half_angle, entry_radius, edge_radius, land
        )
        self.billet_length = billet_length
        self.speed = speed
        self.T_billet, self.T_tool = T_billet, T_tool
        self.material = material or steel_16MnCr5()
        self.mesh_size = mesh_size
        self.n_points = int(n_points)
        self.tool_heating = bool(tool_heating)
        self._cone_end = self.die.segments(1.0)[1]
        self._billet_bottom = self._first_touch()
        self._simulation: Simulation | None = None

    @property
    def max_stroke(self) -> float:
        """Largest stroke [mm]: the punch stays 1 mm above the cone."""
        return self._billet_bottom + self.billet_length - self._cone_end - 1.0

    def _first_touch(self) -> float:
        """Return z of the billet's lower end when it touches the die shoulder [mm]."""
        segments, cone_end = self.die.segments(1.0)
        radius = self.die.container_radius - CLEARANCE
        heights = np.linspace(self.die.land, cone_end + 0.5, 6000)
        gaps = np.array([gap_and_normal(radius, z, segments, 0.0, 0.0)[0] for z in heights])
        return float(heights[np.flatnonzero(gaps <= 0.0).max()])

    def start(self, mu: Friction = 0.08) -> None:
        """Put the billet on the die shoulder; `mu` acts until `set_mu` is called."""
        die, radius = self.die, self.die.container_radius - CLEARANCE
        segments, cone_end = die.segments(self.billet_length + 60.0)
        bottom = self._billet_bottom
        top = bottom + self.billet_length
        tools = [
            Tool("die", segments, reach=0.5, temperature=self.T_tool),
            flat_punch(top, self.speed, self.T_tool),
        ]
        base = min(self.mesh_size, die.exit_radius / 7.0)
        finest = max(0.375 * self.mesh_size, min(base, 0.35 * die.edge_radius))
        size = _DieSize(finest, base, die, cone_end)
        if self.tool_heating:
            tools[0].heat_field = die.heat_field(top + 2.0, size, self.T_tool)
            depth = 1.5 * die.container_radius
            tools[1].heat_field = block_field(die.container_radius, top, depth, size, self.T_tool)
        outline = np.array([[0.0, bottom], [radius, bottom], [radius, top], [0.0, top]])
        surface = resample(outline, size, tools, None).points
        mesh = mesh_inside(surface, size)
        body = Body.at_rest(
            mesh.x, mesh.quads, np.ascontiguousarray(mesh.loop[: len(surface)]), self.T_billet
        )
        body.velocity[:, 1] = -self.speed
        control = StepControl(slip=0.5 * base)
        arc = self._marker_arc(radius)
        self._simulation = Simulation(body, tools, self.material, arc, size=size, control=control)
        self._simulation.state.mu = start_mu(mu, self.n_points, self.T_billet)

    def _marker_arc(self, radius: float) -> FloatArray:
        """Return where the markers start: densest on the side, which the die works on."""
        corners = np.cumsum([0.0, radius, self.billet_length, radius])
        counted = np.cumsum([0.0, 0.5 * radius, self.billet_length, 0.25 * radius])
        return np.interp(np.linspace(0.0, counted[-1], self.n_points), counted, corners)

    @property
    def simulation(self) -> Simulation:
        """The running simulation.

        Raises
        ------
        InputError
            `start` has not been called.
        """
        if self._simulation is None:
            raise InputError("forward rod extrusion: not started; call start() before anything else")
        return self._simulation

    def advance(self, communication_step: float = 0.1) -> bool:
        """Move the punch by `communication_step` [mm] with the friction set last.

        Returns
        -------
        bool
            False when the run has stopped; `status` and `message` say why, and nothing moves any more.
        """
        _check("communication_step", communication_step, 1e-4, 10.0, "mm")
        target = self.stroke + communication_step
        if target > self.max_stroke + 1e-6:
            raise InputError(
                f"forward rod extrusion: stroke {target:.3f} mm; allowed: at most {self.max_stroke:.3f} mm, "
                "where the punch would reach the die cone"
            )
        return self.simulation.advance_to(target)

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
        """Punch travel [mm]."""
        return self.simulation.state.stroke

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
        """Work of the punch so far [J]."""
        return self.simulation.state.energy.external * 1e-3

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

        Raises
        ------
        InputError
            An impossible stroke, or friction that is NaN or negative.
        """
        _check("stroke", stroke, 1e-3, self.max_stroke, "mm")
        self.start(friction)
        steps = max(1, math.ceil(stroke / communication_step - 1e-9))
        log = _Log(self)
        for k in range(steps):
            mu = self.simulation.state.mu
            going = self.advance(stroke * (k + 1) / steps - self.stroke)
            log.add(mu)
            if not going:
                break
            if callable(friction):
                self.set_mu(friction(self.loads(), self.time))
            if progress is not None:
                progress((k + 1) / steps)
        return log.result()


class _Log:
    """Collects a run step by step."""

    def __init__(self, process: ForwardRodExtrusion) -> None:
        self.process = process
        self.scalars: list[tuple[float, float, float]] = [(0.0, 0.0, 0.0)]
        self.loads: list[FloatArray] = []
        self.active: list[npt.NDArray[np.bool_]] = []
        self.mu: list[FloatArray] = []
        self.position: list[FloatArray] = []

    def add(self, mu: FloatArray) -> None:
        p = self.process
        if p.stroke <= self.scalars[-1][0]:
            return
        self.scalars.append((p.stroke, p.force, p.work))
        self.loads.append(p.loads())
        self.active.append(p.active)
        self.mu.append(mu.copy())
        self.position.append(p.marker_position)

    def result(self) -> FormingResult:
        state, n = self.process.simulation.state, self.process.n_points
        stroke, force, work = np.array(self.scalars).T
        history = state.history
        travel = np.diff([0.0, *(h.stroke for h in history)])
        area = np.array([h.contact_area for h in history]) * travel
        share = np.array([h.share_above_0_6k for h in history])
        return FormingResult(
            stroke=stroke,
            force=force,
            work=work,
            max_tau_over_k=max((h.max_tau_over_k for h in history), default=0.0),
            share_above_0_6k=float(area @ share / area.sum()) if area.sum() > 0.0 else 0.0,
            energy_balance=state.energy.imbalance,
            volume_change=history[-1].volume_change if history else 0.0,
            increments=state.increments,
            remeshes=state.remeshes,
            failed_increments=state.failures,
            contact=ContactHistory(
                stroke=stroke[1:],
                loads=np.array(self.loads).reshape(-1, n, 5),
                active=np.array(self.active).reshape(-1, n),
                mu=np.array(self.mu).reshape(-1, n),
                position=np.array(self.position).reshape(-1, n, 2),
            ),
            status=state.status,
            message=state.message,
        )


def _check(name: str, value: float, low: float, high: float, unit: str) -> None:
    """Raise when a parameter is not a finite number in its range."""
    if not (isinstance(value, (int, float, np.floating, np.integer)) and low <= value <= high):
        raise InputError(
            f"forward rod extrusion: {name} = {value!r} {unit}; allowed: {low:g} to {high:g} {unit}"
        )
