"""A forming process step by step: loads at the material markers out, friction in."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.common.ranges import check_range

from ..fe.mesh.mesher import MeshError
from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..fe.state import State
from ..materials.materials import MaterialSource, as_material
from ..tools.ejection_tools import Stage
from .friction_input import Friction, checked_mu, start_mu
from .thermal_conditions import RANGES, ThermalConditions

#: How many markers there may be.
FEWEST, MOST = 8, 2000


class StepwiseProcess(ABC):
    """A forming process that a co-simulation drives step by step.

    A subclass checks its own numbers with `_number` and says in `_build` how its simulation starts.

    Parameters
    ----------
    speed : float
        Punch speed [mm/s].
    material : Material, name or path, optional
        Billet; 16MnCr5 by default. See `forming.materials.materials.load`.
    n_points : int
        Number of material markers on the billet surface.
    thermal : ThermalConditions
        Temperatures at the start and exchange of heat; every process takes these as the keywords below.
    T_billet : float
        Temperature of the billet at the start [degC].
    T_tool : float
        Temperature of the tools at the start [degC].
    tool_heating : bool
        Conduct heat in the tools; False holds their surfaces at `T_tool`.
    tool_material : Material, name or path
        Heat data of the tools.
    htc : float
        Heat transfer coefficient of the contact [kW/(m2 K)].
    T_ambient : float
        Temperature of the air around free surfaces [degC].
    h_ambient : float
        Heat transfer coefficient of the air around free surfaces [W/(m2 K)], which also radiate; 0 insulates them.
    friction_heat_share : float
        Share of the friction heat that is released on the side of the workpiece; the rest on that of the tool.

    Attributes
    ----------
    name : str
        For messages.
    numbers : dict of str to float
        The parameters that are one number.
    units : dict of str to str
        The parameters that are one number, and their units, in the order in which they were checked.
    ranges : dict of str to (float, float)
        What is allowed, given the other parameters.

    Raises
    ------
    InputError
        A number outside its range, or a material that cannot be.
    """

    name: str
    #: Ways to get the product off the tools; the first is the usual one.
    ejections: tuple[str, ...] = ()
    #: Elements are so many times as large as the parameters say; see `forming.results.local_errors`.
    coarsening = 1.0
    _simulation: Simulation | None = None

    def __init__(
        self, speed: float, material: MaterialSource, n_points: int, thermal: ThermalConditions
    ) -> None:
        self.units: dict[str, str] = {}
        self.numbers: dict[str, float] = {}
        self.ranges: dict[str, tuple[float, float]] = {}
        self.speed = self._number("speed", speed, 0.01, 2000.0, "mm/s")
        for name, (low, high, unit) in RANGES.items():
            self._number(name, getattr(thermal, name), low, high, unit)
        self.ranges["n_points"] = FEWEST, MOST
        check_range(self.name, "n_points", n_points, FEWEST, MOST, "")
        if n_points != int(n_points):
            raise InputError(f"{self.name}: n_points = {n_points!r}; allowed: a whole number")
        self.n_points = int(n_points)
        self.thermal = thermal.resolved(self.name)
        self.T_billet, self.T_tool = thermal.T_billet, thermal.T_tool
        self.tool_heating = self.thermal.tool_heating
        self.material = as_material(material)
        self.material.check_start(self.name, thermal.T_billet)

    def _number(self, name: str, value: float, low: float, high: float, unit: str) -> float:
        """Return a parameter that is one number, checked, and remember it, its unit and range."""
        self.units[name], self.ranges[name] = unit, (low, high)
        check_range(self.name, name, value, low, high, unit)
        self.numbers[name] = float(value)
        return value

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
        """Where the run so far has left the range of the flow curve, or was too fast for its thermal boundary layer."""
        history = self.simulation.state.history
        highest = (
            max((getattr(h, n) for h in history), default=0.0) for n in ("strain_max", "rate_max", "T_max")
        )
        coarsest = max((h.layer_cell for h in history), default=0.0)
        return self.material.left_range(*highest) + too_fast(coarsest)

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


def too_fast(layer_cell: float) -> tuple[str, ...]:
    """Return a warning where the cells at the surface are thicker than heat moves in one increment, `layer_cell` times.

    Examples
    --------
    >>> from forming.processes.stepwise import too_fast
    >>> too_fast(0.4)
    ()
    """
    if layer_cell <= 1.0:
        return ()
    return (
        f"thermal boundary layer: cells at the surface up to {layer_cell:.1f} times as thick as heat moves in one "
        f"increment (resolved: at most 1); contact temperatures are too low for the first {layer_cell**2:.0f} increments "
        "of a contact; a smaller mesh_size helps",
    )
