"""An upsetting run of the laboratory: contact area, expansion, pressure and height over the force.

The deformation comes from the finite-element solver. What is read from it, and how, is the laboratory's own: forces of
the nodes, places of the nodes, and the motion between two increments.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

from forming.fe.contact import PRESSURE
from forming.fe.heat.properties import value_at
from forming.fe.remesh import body_within
from forming.fe.simulation import Simulation
from forming.fe.state import RemeshPolicy, StepControl
from forming.fe.tooling import Tool, flat_punch, plate, sleeve
from forming.materials.materials import Material
from forming.tools.punch_geometry import PunchGeometry
from friction_models.common import InputError
from friction_models.loads import FloatArray

from .material_points import MaterialPoints

#: Radii over the contact radius at which the pressure is kept.
FRACTION = np.linspace(0.0, 1.0, 41)
#: Sizes of elements that are tried where a fold closes badly, over the one that is asked for.
SIZES = (1.0, 1.1, 0.9, 1.25, 0.8)
#: Largest increments: of the tool [mm], and of the force over the highest.
TRAVEL, FORCE_STEP = 0.18, 1.0 / 30.0
#: Largest share of the height that a specimen may lose.
MOST = 0.9


@dataclass(frozen=True)
class SpecimenCase:
    """What a run depends on: specimen and punch, highest force [N], elements [mm], material, friction, temperatures
    [degC] and punch speed [mm/s]."""

    punch: PunchGeometry
    force: float
    mesh_size: float
    material: Material
    mu: float
    T_specimen: float
    T_tool: float
    speed: float


@dataclass(frozen=True, eq=False)
class SpecimenRun:
    """The contact with the plate after each increment; n increments, m radii."""

    #: Force [N], contact area [mm2], mean surface expansion, height [mm], each of shape (n,).
    force: FloatArray
    area: FloatArray
    psi: FloatArray
    height: FloatArray
    #: By how much the heat released so far would have warmed the specimen, had it lost none [K], shape (n,).
    rise: FloatArray
    #: Contact pressure [MPa] at `FRACTION` of the contact radius, shape (n, m).
    pressure: FloatArray


def upset_specimen(case: SpecimenCase) -> SpecimenRun:
    """Upset a specimen until the force is reached. Raises InputError: it cannot carry the force."""
    message = ""
    largest = case.punch.specimen_diameter / 8.0
    for factor in SIZES:
        run = _Run(case, min(factor * case.mesh_size, largest))
        if run.carry_out():
            return run.result()
        message = message or run.message
    raise InputError(
        f"virtual laboratory: upsetting to {case.force * 1e-3:.1f} kN {message}; allowed: forces the specimen can carry"
    )


class _Run:
    """One attempt with elements of one size."""

    def __init__(self, case: SpecimenCase, mesh_size: float) -> None:
        self.case = case
        punch, height = case.punch, case.punch.specimen_height
        self._fine = 0.4 * mesh_size
        self._coarse = mesh_size
        self._edge = 0.5 * (punch.tip_diameter or punch.specimen_diameter)
        self._bore = 0.5 * (punch.bore_diameter or math.inf)
        widest = 0.5 * punch.specimen_diameter / math.sqrt(1.0 - MOST)
        tools: list[Tool] = [
            plate(0.0, case.T_tool, widest=widest),
            flat_punch(height, case.speed, case.T_tool, widest=widest),
        ]
        if punch.bore_diameter is not None:
            tools.append(sleeve(self._bore, height, case.speed, case.T_tool))
        body = body_within(punch.outline(), self._size, tools, case.T_specimen)
        body.velocity = np.column_stack([0.5 * body.x[:, 0], -body.x[:, 1]]) * case.speed / height
        self._points = MaterialPoints(punch.outline(), body.surface)
        control = StepControl(
            first=0.005,
            largest=min(TRAVEL, 0.4 * mesh_size),
            slip=0.5 * self._fine,
            force_change=case.force / 15.0,
        )
        self._simulation = Simulation(
            body,
            tools,
            case.material,
            # The solver's own markers carry the friction; nothing is read from them.
            np.linspace(0.0, 1.0, 41) * float(np.hypot(*np.diff(punch.outline(), axis=0).T).sum()),
            mu=case.mu,
            size=lambda stroke: self._size,
            control=control,
            policy=RemeshPolicy(every=15, quality=0.35, strain=0.4),
        )
        capacity = float(value_at(case.material.heat_capacity, case.T_specimen))
        self._capacity = capacity * body.volume()
        self._time = 0.0
        self._rows: list[tuple[float, float, float, float, float]] = []
        self._profiles: list[FloatArray] = []
        self.message = ""

    def carry_out(self) -> bool:
        """Upset; return whether the force was reached."""
        simulation = self._simulation
        done = simulation.advance_to(MOST * self.case.punch.specimen_height, self._observe, self._travel)
        if not done:
            self.message = simulation.state.message
        elif simulation.force < self.case.force:
            self.message = f"stopped: the specimen is upset by {100.0 * MOST:g} % before the force is reached"
        return not self.message

    def result(self) -> SpecimenRun:
        """Return what was read, with rising forces."""
        table, profiles = np.array(self._rows), np.array(self._profiles)
        rises = table[:, 0] > np.append(0.0, np.maximum.accumulate(table[:-1, 0]))
        force, area, psi, height, rise = table[rises].T
        return SpecimenRun(force, area, psi, height, rise, profiles[rises])

    def _size(self, points: FloatArray) -> FloatArray:
        """Return the size of the elements at points, shape (n, 2): fine around the edge of the contact."""
        away = np.hypot(points[:, 0] - self._edge, points[:, 1]) - 2.0 * self._fine
        return np.clip(self._fine + 0.2 * away, self._fine, self._coarse)

    def _travel(self, simulation: Simulation) -> float:
        """Return the largest next increment [mm], from the rise of the force."""
        past, control = simulation.state.history, simulation.control
        if len(past) < 2:
            return control.first
        slope = (past[-1].force - past[-2].force) / (past[-1].stroke - past[-2].stroke)
        return max(FORCE_STEP * self.case.force / max(slope, 1e-9), 4.0 * control.smallest)

    def _observe(self, simulation: Simulation) -> bool:
        state = simulation.state
        body, surface = state.body, state.body.surface
        before = surface - body.velocity[body.chain] * (state.time - self._time)
        self._time = state.time
        self._points.follow(before, surface)
        assert state.tables is not None
        forces = 2.0 * math.pi * state.weights * state.tables[0][:, PRESSURE]
        if simulation.force > 0.0 and forces.max() > 0.0:
            length, radius = contact_edge(surface, forces > 0.0, self._bore)
            self._edge = radius
            on = np.flatnonzero(forces > 0.0)
            psi = self._points.mean_expansion(length, surface)
            height = self.case.punch.specimen_height - state.stroke
            rise = state.energy.heat_generated / self._capacity
            self._rows.append((simulation.force, math.pi * radius**2, psi, height, rise))
            self._profiles.append(pressure(surface[on, 0], forces[on], radius))
        return simulation.force >= self.case.force


def contact_edge(surface: FloatArray, touches: npt.NDArray[np.bool_], bore: float) -> tuple[float, float]:
    """Return how far along the surface the contact with the plate at z = 0 ends, and at which radius [mm].

    The height of the first three free nodes over the length of the surface, a parabola, tells where it was zero.

    - `surface`, shape (n, 2): nodes from the lower axis point on; `touches`, shape (n,): whether the plate carries them.
    """
    last = int(np.flatnonzero(touches)[np.argmax(surface[touches, 0])])
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(surface, axis=0).T)))
    end = float(along[last])
    if last + 3 < len(surface):
        s, z = along[last + 1 : last + 4], surface[last + 1 : last + 4, 1]
        if z[0] > 0.0 and z[1] > z[0]:
            end = _root_below(s, z, end)
    radius = min(float(np.interp(end, along, surface[:, 0])), bore)
    return end, radius


def _root_below(s: FloatArray, z: FloatArray, lowest: float) -> float:
    """Return where a parabola through three points was last zero before them, at least `lowest`."""
    roots = np.roots(np.polyfit(s - s[0], z, 2))
    real = roots[np.abs(roots.imag) < 1e-9].real
    found = real[real <= 1e-12]
    if not len(found):  # the parabola turns before it reaches zero: the line through the first two points
        found = np.array([-z[0] * (s[1] - s[0]) / (z[1] - z[0])])
    return float(np.clip(s[0] + found.max(), lowest, s[0]))


def pressure(r: FloatArray, forces: FloatArray, radius: float) -> FloatArray:
    """Return the pressure [MPa] at `FRACTION` of a contact radius, from forces of nodes [N] at radii [mm].

    The force inside a circle is known where the area inside it is that which the nodes up to there stand for: a node
    stands for its share of the linear shape functions, a third of L (2 r_i + r_i+1) times pi of an element of length L beside it. The pressure is
    the slope of the curve through these points. It carries the force by itself.
    """
    order = np.argsort(r, kind="stable")
    r, forces = r[order], np.maximum(forces[order], 0.0)
    between = np.sqrt(r[:-1] ** 2 + np.diff(r) * (2.0 * r[:-1] + r[1:]) / 3.0)
    ends = np.concatenate([[0.0], between[between < radius], [radius]])
    carried = np.concatenate([[0.0], np.cumsum(forces)[: len(ends) - 2], [forces.sum()]])
    rises = np.append(True, np.diff(ends) > 1e-9 * radius)
    slope = PchipInterpolator(math.pi * ends[rises] ** 2, carried[rises]).derivative()
    return np.maximum(np.asarray(slope(math.pi * (FRACTION * radius) ** 2)), 0.0)
