"""Loads on the workpiece surface, recovered from the nodal forces of the contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba import njit

from .contact import NORMAL_R, NORMAL_Z, PRESSURE, SHEAR, SLIP
from .mesh.shape import FloatArray, IntArray
from .tooling import Tool

#: Least share of a nodal area that a contact is taken to have, where its force becomes a traction.
LEAST_SHARE = 0.25
#: An edge of the surface belongs to the tool that it faces, if the cosine between both normals is above this.
FACES = 0.5
#: Corrections of the lumped pressure. Each takes away what the lumping smears; many make the alternation of the
#: nodal forces from node to node three times as large.
SWEEPS = 1


@dataclass
class SurfaceLoads:
    """Contact quantities at the surface nodes, each tool for itself, shape (n_tools, n_s).

    A node at a corner touches two tools, or one tool and the air: what a point beside it sees is that of the
    tool which the edge of the surface with this point faces.
    """

    pressures: FloatArray
    shears: FloatArray
    slips: FloatArray
    temperatures: FloatArray
    #: Tool that each edge between two nodes faces; -1: none touches it, shape (n_s - 1,).
    faced: IntArray

    @property
    def hardest(self) -> IntArray:
        """The tool that presses hardest on each node, shape (n_s,)."""
        return np.asarray(self.pressures.argmax(axis=0))

    @property
    def pressure(self) -> FloatArray:
        """Pressure of the tool that presses hardest [MPa], shape (n_s,)."""
        return self._of_hardest(self.pressures)

    @property
    def shear(self) -> FloatArray:
        """Friction stress of the tool that presses hardest [MPa], shape (n_s,)."""
        return self._of_hardest(self.shears)

    @property
    def slip(self) -> FloatArray:
        """Slip velocity along the tool that presses hardest [mm/s], shape (n_s,)."""
        return self._of_hardest(self.slips)

    @property
    def tool_T(self) -> FloatArray:
        """Temperature of the surface of the tool that presses hardest [degC], shape (n_s,)."""
        return self._of_hardest(self.temperatures)

    @property
    def active(self) -> npt.NDArray[np.bool_]:
        """Whether a tool touches the node, shape (n_s,)."""
        return np.asarray((self.pressures > 0.0).any(axis=0))

    def _of_hardest(self, values: FloatArray) -> FloatArray:
        return np.asarray(values[self.hardest, np.arange(values.shape[1])])


@njit(cache=True)
def facing_of_edges(x: FloatArray, table: FloatArray) -> FloatArray:
    """Return the cosine between each edge's normal and the tool's at those of its ends that touch it; 0: neither does.

    - `x`, shape (n, 2): surface nodes, the body on their left.
    - `table`, shape (n, 7): contact table of the tool.
    """
    n = x.shape[0]
    facing = np.zeros(n - 1)
    for e in range(n - 1):
        tr = x[e + 1, 0] - x[e, 0]
        tz = x[e + 1, 1] - x[e, 1]
        length = np.sqrt(tr * tr + tz * tz) + 1e-300
        count = 0
        for i in range(e, e + 2):
            if table[i, PRESSURE] > 0.0:
                count += 1
                facing[e] -= (tz * table[i, NORMAL_R] - tr * table[i, NORMAL_Z]) / length
        if count > 0:
            facing[e] = max(0.0, facing[e] / count)
    return facing


@njit(cache=True)
def recovered(
    x: FloatArray, table: FloatArray, weights: FloatArray, sweeps: int
) -> tuple[FloatArray, FloatArray]:
    """Return the pressure whose nodal forces are those of the contact, shape (n,), and the areas it was lumped on.

    The pressure is linear along each edge, and int N_i p dA over the part of the surface that faces the tool is the
    nodal force f_i. It is found from the lumped p_i = f_i / int N_i dA by `sweeps` corrections with what is left of the
    force. On the edge where a contact ends the mass is lumped, so that the pressure carries the whole force.

    - `table`, shape (n, 7): contact table of a tool; `weights`, shape (n,): nodal areas per radian [mm2].
    """
    n = x.shape[0]
    closed = x[0, 0] == x[n - 1, 0] and x[0, 1] == x[n - 1, 1]
    facing = facing_of_edges(x, table)
    force, lumped, left = np.zeros(n), np.zeros(n), np.zeros(n)
    coupling = np.zeros(n - 1)
    area = weights.copy()
    for i in range(n):
        force[i] = max(table[i, PRESSURE], 0.0) * weights[i]
    for e in range(n - 1):
        length = facing[e] * np.hypot(x[e + 1, 0] - x[e, 0], x[e + 1, 1] - x[e, 1])
        lumped[e] += length * (2.0 * x[e, 0] + x[e + 1, 0]) / 6.0
        lumped[e + 1] += length * (x[e, 0] + 2.0 * x[e + 1, 0]) / 6.0
        if table[e, PRESSURE] > 0.0 and table[e + 1, PRESSURE] > 0.0:
            coupling[e] = length * (x[e, 0] + x[e + 1, 0]) / 12.0
    if closed:
        for values in (force, lumped, area):
            values[0] += values[n - 1]
            values[n - 1] = values[0]
    pressure = np.zeros(n)
    for i in range(n):
        lumped[i] = max(lumped[i], LEAST_SHARE * area[i])
        if force[i] > 0.0:
            pressure[i] = force[i] / lumped[i]
    for _ in range(sweeps):
        left[:] = 0.0
        for e in range(n - 1):
            flow = coupling[e] * (pressure[e + 1] - pressure[e])
            left[e] -= flow
            left[e + 1] += flow
        if closed:
            left[0] += left[n - 1]
            left[n - 1] = left[0]
        for i in range(n):
            if force[i] > 0.0:
                left[i] += force[i] - lumped[i] * pressure[i]
        for i in range(n):
            if force[i] > 0.0:
                # No pull from what is corrected: beside a steep rise the lumped pressure is small.
                pressure[i] = max(pressure[i] + left[i] / lumped[i], 0.25 * pressure[i])
    return pressure, lumped


def surface_loads(
    surface: FloatArray, tables: list[FloatArray], tools: list[Tool], weights: FloatArray
) -> SurfaceLoads:
    """Return the tractions of all tools from their contact tables.

    - `surface`, shape (n_s, 2); `weights`, shape (n_s,): nodal areas per radian [mm2].
    """
    facing = np.array([facing_of_edges(surface, table) for table in tables])
    faced = np.where(facing.max(axis=0) > FACES, facing.argmax(axis=0), -1)
    pressures, shears = [], []
    for table in tables:
        pressure, lumped = recovered(surface, table, weights, SWEEPS)
        pressures.append(pressure)
        shears.append(table[:, SHEAR] * weights / lumped)
    return SurfaceLoads(
        pressures=np.array(pressures),
        shears=np.array(shears),
        slips=np.array([table[:, SLIP] for table in tables]),
        temperatures=np.array([tool.surface_temperature(surface) for tool in tools]),
        faced=faced,
    )


def bore_pressure(table: FloatArray, weights: FloatArray, spread: float = 0.0) -> float:
    """Return the mean contact pressure of a tool over its contact area seen in radial direction [MPa].

    A short contact is carried by the tool around it: the force counts over an area of at least `spread`.
    """
    area = np.where(table[:, PRESSURE] > 0.0, np.abs(table[:, NORMAL_R]) * weights, 0.0)
    total = max(float(area.sum()), spread)
    return float(area @ table[:, PRESSURE]) / total if total > 0.0 else 0.0
