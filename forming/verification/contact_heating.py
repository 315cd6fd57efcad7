"""Contact temperature of a forming run against the closed form of two bodies that rub, in contact over a film.

The run gives pressure, sliding speed, stretch and place of its markers; plastic work is not turned into heat. Then every
marker is a half space that stretches with the surface, and every place of the tool another one at rest. A flux q(t) through
the surface of a half space raises its temperature by (Duhamel; Carslaw and Jaeger, section 2.9)::

    T = sqrt(a / pi) / k  *  integral of q / s d tau' / sqrt(tau - tau'),    d tau = s^2 dt,

where s(t) is how much the area has grown. On a cylinder of radius R the first correction is +- a / (2 k R) times the
integral of q. Nothing of the solver's heat is used: no mesh, no kernel, no temperature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..materials.materials import steel_16MnCr5
from ..processes.backward_cup_extrusion import BackwardCupExtrusion
from ..processes.base import Extrusion
from ..processes.forward_rod_extrusion import ForwardRodExtrusion
from .case import Case, Row, Unfinished, case

GROUP = "Heat"
MU, T_START = 0.08, 20.0
#: Conductance of the contact [N/(mm s K)], share of the friction heat in the workpiece, v0 of the friction law over the
#: speed; k [N/(s K)] and a [mm2/s] of the tools, 1.2379.
HTC, SHARE, V0 = 35.0, 0.5, 0.02
TOOL_K, TOOL_A = 20.0, 20.0 / (7700.0 * 460e-6)
#: Steps of the closed form in one increment; distance between the places of the tool, and how far from a marker in
#: contact they still touch [mm].
PARTS, SPACING, NEAR = 3, 0.2, 0.4
#: Speeds [mm/s] with the strokes of rod and cup after which they are compared [mm]: as long as the layer is thin enough
#: for half spaces. Speed and stroke without a closed form.
STROKES = {100.0: (5.0, 3.0), 300.0: (8.0, 5.0), 1000.0: (8.0, 5.0), 2000.0: (8.0, 5.0)}
SLOW, SLOW_STROKE = 5.0, 4.0
SOURCE = "Duhamel: two half spaces over a film, driven by the run's pressure and speed"
#: Allowed deviation of the mean rise [%].
TOLERANCE = 5.0
CASES: list[Case] = []


@dataclass(frozen=True)
class Rubbing:
    """What the markers did in each increment: time [s], places [mm], and the friction power on them [N/(mm s)]."""

    time: FloatArray
    points: FloatArray
    power: FloatArray
    active: npt.NDArray[np.bool_]
    #: Contact temperature as the run gives it [degC].
    T: FloatArray
    #: Where the tools stood [mm], shape (n, n_tools, 2).
    offset: FloatArray
    #: Area that belongs to each marker over that at the start.
    stretch: FloatArray


def run(process: Extrusion, stroke: float) -> Rubbing:
    """Form a billet without plastic heat and record the markers increment by increment."""
    seen: list[tuple[object, ...]] = []

    def see(sim: Simulation) -> bool:
        m = sim.state.markers
        offsets = [tool.offset for tool in sim.state.tools]
        points = m.points(sim.state.body.surface)
        found = (sim.state.time, points, m.v_rel, m.sigma_n, m.active, m.T, offsets)
        seen.append(tuple(np.array(part) for part in found))
        return False

    process.start(MU)
    first = _rings(process.marker_position)
    while process.stroke < stroke - 1e-9:
        if not process.advance(min(0.1, stroke - process.stroke), see):
            raise Unfinished(f"{process.name}: {process.message}")
    time, points, v, p, active, T, offset = (np.array(column) for column in zip(*seen))
    v0 = V0 * process.speed
    power = MU * p * v * v / np.sqrt(v * v + v0 * v0) * active
    stretch = np.array([_rings(x) for x in points]) / first
    return Rubbing(time, points, power, active, T, offset, stretch)


def _rings(x: FloatArray) -> FloatArray:
    """Return the area of the two cones beside each marker."""
    cones = (x[1:, 0] + x[:-1, 0]) * np.hypot(*np.diff(x, axis=0).T)
    return np.concatenate([cones[:1], cones[1:] + cones[:-1], cones[-1:]])


def place_on(face: FloatArray, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far along a polyline each point is, and how far away from it."""
    along = np.diff(face, axis=0)
    length = np.hypot(*along.T)
    t = np.clip(((x[:, None] - face[:-1]) * along).sum(axis=2) / length**2, 0.0, 1.0)
    away = np.linalg.norm(x[:, None] - face[:-1] - t[..., None] * along, axis=2)
    k, i = away.argmin(axis=1), np.arange(len(x))
    return np.append(0.0, np.cumsum(length))[k] + t[i, k] * length[k], away[i, k]


def contact_temperature(rub: Rubbing, tool: int, face: FloatArray, cylinder: bool) -> FloatArray:
    """Return the rise of the contact temperature at the markers after the last increment [K]; NaN: not on this tool.

    - `face`: surface of the tool, in its own frame, as a polyline.
    - `cylinder`: the surfaces are curved like the bore, 1 / r; else plane.
    """
    steel = steel_16MnCr5()
    k, a = float(steel.conductivity), float(steel.conductivity) / float(steel.heat_capacity)  # type: ignore[arg-type]
    n = rub.points.shape[1]
    places = np.arange(0.0, np.hypot(*np.diff(face, axis=0).T).sum() + SPACING, SPACING)
    steps = PARTS * len(rub.time)
    starts = np.append(0.0, rub.time)
    t = np.append(
        0.0, (starts[:-1, None] + np.diff(starts)[:, None] * np.arange(1, PARTS + 1) / PARTS).ravel()
    )
    tau = np.zeros((steps + 1, n))
    q, q_tool = np.zeros((steps, n)), np.zeros((steps, len(places)))
    bend, bend_tool = np.zeros(n), np.zeros(len(places))
    rise = np.full(n, np.nan)
    for m in range(steps):
        j = m // PARTS
        dt, s = t[m + 1] - t[m], rub.stretch[j]
        tau[m + 1] = tau[m] + s * s * dt
        kernel = _kernel(tau[: m + 2], k, a)
        kernel_tool = _kernel(t[: m + 2], TOOL_K, TOOL_A)
        old = (kernel[:m] * q[:m]).sum(axis=0) + bend
        old_tool = kernel_tool[:m] @ q_tool[:m] - bend_tool
        at, away = place_on(face, rub.points[j] - rub.offset[j, tool])
        on = np.flatnonzero(rub.active[j] & (away < 0.1))
        on = on[np.argsort(at[on])]
        if len(on) < 3:
            continue
        # Linear interpolation from the places to the markers and back, where markers cover them.
        to_markers, to_places = _linear(places, at[on]), _linear(at[on], places)
        covered = np.abs(places[:, None] - at[on]).min(axis=1) < NEAR
        to_places[~covered] = 0.0
        own, own_tool = kernel[m] / s, kernel_tool[m]
        heat = SHARE * rub.power[j, on]
        # q = heat + HTC (T_tool - T), and the other way round, with T = old + own q on both sides.
        size = len(on)
        matrix = np.eye(size + len(places))
        matrix[:size, :size] += np.diag(HTC * own[on])
        matrix[:size, size:] = -HTC * own_tool * to_markers
        matrix[size:, size:] += np.diag(HTC * own_tool * covered)
        matrix[size:, :size] = -HTC * to_places * own[on]
        right = np.concatenate(
            [
                heat + HTC * (to_markers @ old_tool - old[on]),
                to_places @ ((1.0 - SHARE) / SHARE * heat + HTC * old[on]) - HTC * covered * old_tool,
            ]
        )
        flux = np.linalg.solve(matrix, right)
        q[m, on], q_tool[m] = flux[:size] / s[on], flux[size:]
        if cylinder:
            r = np.maximum(rub.points[j, :, 0], 1.0)
            bend += 0.5 * a / k * q[m] * s * dt / r
            bend_tool += 0.5 * TOOL_A / TOOL_K * q_tool[m] * dt / float(r.max())
        rise[:] = np.nan
        tool_T = old_tool + own_tool * q_tool[m]
        rise[on] = 0.5 * (old[on] + kernel[m, on] * q[m, on] + to_markers @ tool_T)
    return rise


def _kernel(tau: FloatArray, k: float, a: float) -> FloatArray:
    """Return the rise at the last of the times `tau` for a unit flux in each interval between them."""
    back = np.sqrt(tau[-1] - tau)
    return 2.0 / k * math.sqrt(a / math.pi) * (back[:-1] - back[1:])


def _linear(known: FloatArray, wanted: FloatArray) -> FloatArray:
    """Return the matrix of linear interpolation from sorted points to others, shape (n_wanted, n_known)."""
    k = np.clip(np.searchsorted(known, wanted) - 1, 0, len(known) - 2)
    u = np.clip((wanted - known[k]) / np.maximum(known[k + 1] - known[k], 1e-12), 0.0, 1.0)
    matrix = np.zeros((len(wanted), len(known)))
    rows = np.arange(len(wanted))
    matrix[rows, k] += 1.0 - u
    matrix[rows, k + 1] += u
    return matrix


def _cold_working() -> dict[str, object]:
    """Return what both processes have in common: no plastic heat, no air, many markers."""
    return {"material": replace(steel_16MnCr5(), taylor_quinney=0.0), "h_ambient": 0.0}


def rod(speed: float, stroke: float, **more: float) -> dict[str, tuple[float, float]]:
    """Return the mean rise at container and cone of a forward rod extrusion: closed form, run [K]."""
    process = ForwardRodExtrusion(speed=speed, n_points=120, **_cold_working(), **more)  # type: ignore[arg-type]
    rub = run(process, stroke)
    d = process.die
    half = math.radians(d.half_angle)
    reach = d.entry_radius * math.tan(0.5 * half)
    corner = d.land + d.edge_radius * math.tan(0.5 * half)
    top = corner + (d.container_radius - d.exit_radius) / math.tan(half)
    face = [(d.container_radius, top + process.container_length)]
    middle = (d.container_radius - d.entry_radius, top + reach)
    face += [
        (middle[0] + d.entry_radius * math.cos(b), middle[1] - d.entry_radius * math.sin(b))
        for b in np.linspace(0.0, half, 12)
    ]
    face += [(d.exit_radius, d.land), (d.exit_radius, 0.0)]
    expected = contact_temperature(rub, 0, np.array(face), cylinder=True)
    r, z = rub.points[-1].T
    bottom, upper = top + reach + 1.0, float(z.max()) - 1.5
    places = {
        "container": (r > d.container_radius - 0.1) & (z > bottom) & (z < upper),
        "cone": (z > corner + 0.5) & (z < top - reach) & (r > d.exit_radius),
    }
    return _means(expected, rub, places)


def cup(speed: float, stroke: float, **more: float) -> dict[str, tuple[float, float]]:
    """Return the mean rise at wall and nose of a backward cup extrusion: closed form, run [K]."""
    process = BackwardCupExtrusion(speed=speed, n_points=200, **_cold_working(), **more)  # type: ignore[arg-type]
    rub = run(process, stroke)
    radius, punch = process.container_radius, process.punch
    flat = punch.radius - punch.edge_radius
    wall = contact_temperature(rub, 0, np.array([(radius, 0.0), (radius, 60.0)]), cylinder=True)
    edge = [
        (flat + punch.edge_radius * math.sin(b), punch.edge_radius * (1.0 - math.cos(b)))
        for b in np.linspace(0.0, 0.5 * math.pi, 16)
    ]
    land = (punch.radius, punch.edge_radius + punch.land)
    face = np.array([(0.0, 0.0), *edge, land])
    nose = contact_temperature(rub, 1, face, cylinder=False)
    r, z = rub.points[-1].T
    tip = float(rub.offset[-1, 1, 1])
    on_wall = (
        (r > radius - 0.1) & (z > tip + 0.5) & (rub.power[-1] > 0.3 * rub.power[-1][r > radius - 0.1].max())
    )
    on_nose = (r > 0.1 * radius) & (r < flat - 0.2) & (abs(z - tip) < 0.1)
    return _means(wall, rub, {"wall": on_wall}) | _means(nose, rub, {"nose": on_nose})


def _means(
    expected: FloatArray, rub: Rubbing, places: dict[str, npt.NDArray[np.bool_]]
) -> dict[str, tuple[float, float]]:
    found = {}
    for name, there in places.items():
        at = there & rub.active[-1] & np.isfinite(expected)
        found[name] = float(expected[at].mean()), float((rub.T[-1][at] - T_START).mean())
    return found


@case(CASES, "contact-heating", GROUP, fast=False)
def fast_rows() -> list[Row]:
    """Friction heats rod and cup at mu 0.08, no plastic heat; mean rise of the contact temperature at the markers."""
    rows = []
    for speed, (rod_stroke, cup_stroke) in STROKES.items():
        for name, found in (("rod", rod(speed, rod_stroke)), ("cup", cup(speed, cup_stroke))):
            rows += [_row(name, where, speed, *pair, SOURCE) for where, pair in found.items()]
    return rows


@case(CASES, "contact-heating-slow", GROUP, fast=False)
def slow_rows() -> list[Row]:
    """The same at 5 mm/s and 4 mm stroke, where the layer is as thick as the workpiece."""
    # Heat moves further than half spaces allow: elements of half the size take the place of the closed form.
    rows = []
    for name, of, size in (("rod", rod, 0.4), ("cup", cup, 0.35)):
        usual, fine = (of(SLOW, SLOW_STROKE, mesh_size=h) for h in (size, 0.5 * size))
        source = f"elements of {0.5 * size:g} mm"
        rows += [_row(name, where, SLOW, fine[where][1], usual[where][1], source) for where in usual]
    return rows


def _row(process: str, where: str, speed: float, reference: float, ours: float, source: str) -> Row:
    what = f"{process}, {where}: rise of the contact temperature at {speed:g} mm/s"
    return Row(what, "K", reference, source, ours, TOLERANCE)
