"""Upsetting of the cylinder of a sliding compression test: contact pressure and surface expansion by force."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.common.ranges import check_range

from ..fe.mesh.polyline import arc_length, distance_to_point
from ..fe.mesh.shape import FloatArray
from ..fe.remesh import body_within
from ..fe.simulation import Simulation
from ..fe.state import RemeshPolicy, StepControl
from ..fe.tooling import Tool, flat_punch, plate, sleeve
from ..materials.materials import Material, MaterialSource, as_material
from ..tools.punch_geometry import PunchGeometry
from .friction_input import Friction, checked_mu, start_mu
from .plate_contact import plate_contact

#: Highest force, forces, or (instants, forces).
Force = float | npt.ArrayLike | tuple[npt.ArrayLike, npt.ArrayLike]


#: Elements at the edge of the contact, as a share of those away from it: where the side folds onto the plate, psi rises
#: within an element. Over five geometries its mean is 1 % (rms) above the one of finer meshes, 2 % with a share of 0.35, at
#: the same cost.
AT_EDGE = 0.25
#: Largest share of the height that the specimen may lose.
MOST = 0.9


class ContactEdgeSize:
    """Element size: `mesh_size`, finer around the edge of the contact, which it follows.

    - `mesh_size`: size away from the edge [mm].
    - `edge`: radius of the contact edge now [mm]; to be kept up to date.

    Examples
    --------
    >>> size = ContactEdgeSize(mesh_size=1.0, edge=6.0)
    >>> size(np.array([[6.0, 0.0], [6.0, 50.0]])).tolist()
    [0.25, 1.0]
    """

    def __init__(self, mesh_size: float, edge: float) -> None:
        self.mesh_size = mesh_size
        self.finest = min(AT_EDGE * mesh_size, edge / 6.0)
        self.edge = edge

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return the element size at points of shape (n, 2)."""
        distance = distance_to_point(points, self.edge, 0.0)
        growth = np.maximum(0.0, distance - 2.0 * self.finest)
        return np.minimum(self.mesh_size, self.finest + 0.2 * growth)


@dataclass(frozen=True)
class UpsettingResult:
    """Contact with the plate over the force history; n instants, m radii.

    Attributes
    ----------
    time, force : ndarray, shape (n,)
        As asked for [s], [N]; without a history: of the increments.
    contact_radius : ndarray, shape (n,)
        Radius of the contact [mm]: where the gap, extrapolated from the first two nodes out of contact, closes.
    radius_fraction : ndarray, shape (m,)
        r over contact radius, 0 to 1.
    sigma_n, psi : ndarray, shape (n, m)
        Contact pressure [MPa] at ``radius_fraction * contact_radius``, and surface expansion dA/dA0 of the ring
        half-way to the neighbouring radii.
    sigma_n_mean, psi_mean : ndarray, shape (n,)
        Means over the contact, by area as it is now: friction acts on that area. Over the area at the start the mean
        expansion would be the smaller area ratio of the material in contact.
    area_ratio : ndarray, shape (n,)
        Contact area over the area of the undeformed lower face.
    T_contact : ndarray, shape (n,)
        Mean contact temperature [degC], mean of workpiece and plate surface.
    height : ndarray, shape (n,)
        Height of the specimen [mm].
    status, message : str
        ``"ok"``, or ``"stopped"`` and where and why the force was not reached; what was computed is kept.

    Examples
    --------
    A run makes it; here one instant by hand, a contact of 5 mm radius under an even pressure:

    >>> one = np.ones(1)
    >>> result = UpsettingResult(
    ...     time=0.0 * one,
    ...     force=np.array([78540.0]),
    ...     contact_radius=5.0 * one,
    ...     radius_fraction=np.array([0.0, 1.0]),
    ...     sigma_n=np.full((1, 2), 1000.0),
    ...     psi=np.ones((1, 2)),
    ...     sigma_n_mean=1000.0 * one,
    ...     psi_mean=one,
    ...     area_ratio=one,
    ...     T_contact=20.0 * one,
    ...     height=15.0 * one,
    ... )
    >>> result.status, round(float(result.force[0] / (math.pi * result.contact_radius[0] ** 2)))
    ('ok', 1000)
    """

    time: FloatArray
    force: FloatArray
    contact_radius: FloatArray
    radius_fraction: FloatArray
    sigma_n: FloatArray
    psi: FloatArray
    sigma_n_mean: FloatArray
    psi_mean: FloatArray
    area_ratio: FloatArray
    T_contact: FloatArray
    height: FloatArray
    status: str = "ok"
    message: str = ""

    @property
    def r(self) -> FloatArray:
        """Radii of the profiles, shape (n, m) [mm]."""
        return self.contact_radius[:, None] * self.radius_fraction

    def at_force(self, force: npt.ArrayLike, time: npt.ArrayLike | None = None) -> UpsettingResult:
        """Return the state at given forces; where the force falls, the contact stays as at the highest before.

        Pressure scales with the force while it falls (elastic unloading). Forces above the last one
        computed give the last state.
        """
        wanted = np.atleast_1d(np.asarray(force, dtype=np.float64))
        peak = np.maximum.accumulate(wanted)
        known = np.maximum.accumulate(self.force)
        scale = np.divide(wanted, peak, out=np.zeros_like(wanted), where=peak > 0.0)

        def at(values: FloatArray) -> FloatArray:
            if values.ndim == 1:
                return np.interp(peak, known, values)
            return np.column_stack([np.interp(peak, known, column) for column in values.T])

        times = at(self.time) if time is None else np.atleast_1d(np.asarray(time, dtype=np.float64))
        return replace(
            self,
            time=times,
            force=wanted,
            sigma_n=at(self.sigma_n) * scale[:, None],
            sigma_n_mean=at(self.sigma_n_mean) * scale,
            contact_radius=at(self.contact_radius),
            psi=at(self.psi),
            psi_mean=at(self.psi_mean),
            area_ratio=at(self.area_ratio),
            T_contact=at(self.T_contact),
            height=at(self.height),
        )


def upset(
    punch: PunchGeometry | None = None,
    force: Force = 519e3,
    material: MaterialSource = None,
    mu: Friction = 0.08,
    T0: float = 20.0,
    T_tool: float = 20.0,
    mesh_size: float = 0.6,
    speed: float = 10.0,
    n_radii: int = 25,
) -> UpsettingResult:
    """Upset a specimen up to a force and report its contact with the plate.

    Parameters
    ----------
    punch : PunchGeometry, optional
        Specimen and punch.
    force : float or (t, F)
        Highest force [N], or a force history: instants [s] and forces [N], each of shape (n,). An
        array of forces alone gives the states at these forces.
    material : Material, name or path, optional
        Workpiece; 16MnCr5 by default.
    mu : float or callable
        Coefficient of friction, or ``mu(loads[n, 5], t) -> mu[n]`` evaluated at material markers after each
        increment and used in the next.
    T0, T_tool : float
        Temperatures of specimen and tools [degC]; the tools stay at theirs.
    mesh_size : float
        Element size [mm]: 0.6 for the twin, 0.3 for reference runs.
    speed : float
        Punch speed [mm/s]: it sets strain rate and cooling; the force history only picks the states.
    n_radii : int
        Number of radii of the profiles.

    Raises
    ------
    InputError
        Impossible geometry, forces, speed or friction.
    """
    punch = punch or PunchGeometry()
    times, forces = _force_history(force)
    check_range("upset", "speed", speed, 1e-3, 1e5, "mm/s")
    check_range("upset", "mesh_size", mesh_size, 0.1, punch.specimen_diameter / 8.0, "mm")
    check_range("upset", "T0", T0, -273.15, 2000.0, "degC")
    check_range("upset", "T_tool", T_tool, -273.15, 2000.0, "degC")
    check_range("upset", "n_radii", n_radii, 2, 10_000, "")
    highest = float(forces.max())
    steel = as_material(material)
    steel.check_start("upset", T0, "T0")
    simulation, size = _build(punch, steel, T0, T_tool, mesh_size, speed, highest)
    n_markers = len(simulation.state.markers)
    simulation.state.mu = start_mu(mu, n_markers, T0)
    fraction = np.linspace(0.0, 1.0, int(n_radii))
    rows = [plate_contact(simulation, punch, fraction)]

    def observe(sim: Simulation) -> bool:
        state = sim.state
        if callable(mu):
            state.mu = checked_mu(mu(state.markers.loads(), state.time), n_markers, state.stroke)
        rows.append(plate_contact(sim, punch, fraction))
        size.edge = float(rows[-1]["contact_radius"])
        return sim.force >= highest

    def force_step(sim: Simulation) -> float:
        past = sim.state.history
        if len(past) < 2:
            return sim.control.first
        stiffness = (past[-1].force - past[-2].force) / (past[-1].stroke - past[-2].stroke)
        return max(highest / 30.0 / max(stiffness, 1e-9), 4.0 * sim.control.smallest)

    reached = simulation.advance_to(MOST * punch.specimen_height, observe, force_step)
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    message = simulation.state.message
    if reached and simulation.force < highest:
        reached, message = (
            False,
            f"stopped: the specimen is upset by {100.0 * MOST:g} % before the force is reached",
        )
    result = UpsettingResult(
        radius_fraction=fraction, status="ok" if reached else "stopped", message=message, **columns
    )
    if isinstance(force, (int, float)):
        return result.at_force(
            np.append(result.force[result.force < highest], min(highest, result.force.max()))
        )
    return result.at_force(forces, times)


def _force_history(force: Force) -> tuple[FloatArray | None, FloatArray]:
    times: FloatArray | None = None
    try:
        given = [
            np.asarray(part, dtype=np.float64) for part in (force if isinstance(force, tuple) else (force,))
        ]
    except (TypeError, ValueError):
        given = []
    if len(given) != (2 if isinstance(force, tuple) else 1):
        raise InputError(
            f"upset: force = {force!r:.60}; allowed: a number, numbers, or (instants, forces), in s and N"
        )
    if isinstance(force, tuple):
        times, forces = given
        if times.shape != forces.shape:
            raise InputError(
                f"upset: {times.size} instants and {forces.size} forces; allowed: as many of each"
            )
    else:
        forces = np.atleast_1d(given[0])
    highest = float(forces.max(initial=-np.inf))
    if forces.ndim != 1 or not np.isfinite(forces).all() or not 1e3 <= highest <= 1e7:
        raise InputError(
            f"upset: highest force = {highest:g} N; allowed: finite forces whose highest is between 1e3 and 1e7 N"
        )
    return times, forces


def _build(
    punch: PunchGeometry,
    material: Material,
    T0: float,
    T_tool: float,
    mesh_size: float,
    speed: float,
    highest: float,
) -> tuple[Simulation, ContactEdgeSize]:
    height = punch.specimen_height
    size = ContactEdgeSize(mesh_size, math.sqrt(punch.first_contact_area / math.pi))
    widest = 0.5 * punch.specimen_diameter / math.sqrt(1.0 - MOST)
    tools: list[Tool] = [
        plate(0.0, T_tool, widest=widest),
        flat_punch(height, speed, T_tool, widest=widest),
    ]
    if punch.bore_diameter is not None:
        tools.append(sleeve(0.5 * punch.bore_diameter, height, speed, T_tool))
    body = body_within(punch.outline(), size, tools, T0)
    body.velocity = np.column_stack([0.5 * body.x[:, 0], -body.x[:, 1]]) * speed / height
    lengths = arc_length(punch.outline())
    face, top = lengths[-3] if punch.tip_diameter is None else lengths[2], lengths[-2]
    fine = np.linspace(0.0, face, 33)
    side = np.linspace(face, top, 17)[1:]
    arc = np.concatenate([fine, side, np.linspace(top, lengths[-1], 7)[1:]])
    control = StepControl(
        first=0.005, largest=min(0.2, 0.4 * mesh_size), slip=0.5 * size.finest, force_change=highest / 15.0
    )
    policy = RemeshPolicy(every=15, quality=0.35, strain=0.4)
    simulation = Simulation(
        body, tools, material, arc, size=lambda state: size, control=control, policy=policy
    )
    return simulation, size
