"""Loads on the workpiece surface, and material markers on it: the same material points through every remeshing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .contact import FACING, NORMAL_R, PRESSURE, SHEAR, SLIP
from .mesh.polyline import arc_length
from .mesh.shape import FloatArray, IntArray
from .tooling import Tool


@dataclass
class SurfaceLoads:
    """Contact quantities at the surface nodes, the tools joined; each of shape (n_s,)."""

    pressure: FloatArray
    shear: FloatArray
    slip: FloatArray
    tool_T: FloatArray
    active: npt.NDArray[np.bool_]


class SurfaceMarkers:
    """A fixed number of material points on the surface, ordered from the lower to the upper axis point.

    Between remeshings a marker stays at its place within its edge, because nodes move with the material;
    at a remeshing it keeps its arc length. The sliding distance is summed at the marker. The surface
    expansion is the area between neighbouring markers over that area in the undeformed billet, so no
    error accumulates.

    - `surface`, shape (n_s, 2): undeformed surface.
    - `arc`, shape (n,): increasing arc lengths of the markers on it [mm].
    """

    def __init__(self, surface: FloatArray, arc: FloatArray, T: float) -> None:
        n = len(arc)
        self.position = _index_coordinate(arc, arc_length(surface))
        self.reference_area = np.diff(self._area_below(surface))
        self.start_arc = arc.copy()
        self.sd = np.zeros(n)
        self.psi = np.ones(n)
        self.v_rel = np.zeros(n)
        self.sigma_n = np.zeros(n)
        self.T = np.full(n, float(T))
        self.active = np.zeros(n, dtype=bool)

    def __len__(self) -> int:
        return len(self.position)

    def _edges(self) -> tuple[npt.NDArray[np.int64], FloatArray]:
        last = int(np.floor(self.position[-1] - 1e-9))
        k = np.minimum(self.position.astype(np.int64), last)
        return k, self.position - k

    def at_markers(self, nodal: FloatArray) -> FloatArray:
        """Return a nodal quantity of the surface at the markers."""
        k, u = self._edges()
        return (1.0 - u) * nodal[k] + u * nodal[k + 1]

    def at_nodes(self, values: FloatArray, n_nodes: int) -> FloatArray:
        """Return a quantity of the markers at the `n_nodes` surface nodes."""
        return np.interp(np.arange(n_nodes), self.position, values)

    def points(self, surface: FloatArray) -> FloatArray:
        """Return the positions of the markers, shape (n, 2) [mm]."""
        return np.column_stack([self.at_markers(surface[:, 0]), self.at_markers(surface[:, 1])])

    def _area_below(self, surface: FloatArray) -> FloatArray:
        """Return the surface area from the start of the chain to each marker [mm2]."""
        r = surface[:, 0]
        length = np.diff(arc_length(surface))
        below = np.concatenate([[0.0], np.cumsum(length * (r[1:] + r[:-1]) * np.pi)])
        k, u = self._edges()
        return below[k] + 2.0 * np.pi * length[k] * u * (r[k] + 0.5 * u * (r[k + 1] - r[k]))

    def update(self, surface: FloatArray, T: FloatArray, loads: SurfaceLoads, dt: float) -> None:
        """Take over the state at the end of an increment `dt` [s]; `T` are the temperatures of the surface nodes.

        Markers in contact get new loads; the others keep v_rel, sigma_n and T of their last contact. The
        contact temperature is the mean of workpiece and tool surface.
        """
        k, u = self._edges()
        w0, w1 = (1.0 - u) * loads.active[k], u * loads.active[k + 1]
        weight = w0 + w1
        pressure = (1.0 - u) * loads.pressure[k] + u * loads.pressure[k + 1]
        self.active = (weight >= 0.5) & (pressure > 0.0)
        on = self.active
        slip, tool_T = (
            (w0[on] * f[k[on]] + w1[on] * f[k[on] + 1]) / weight[on]
            for f in (np.abs(loads.slip), loads.tool_T)
        )
        self.v_rel[on] = slip
        self.sigma_n[on] = pressure[on]
        self.T[on] = 0.5 * (self.at_markers(T)[on] + tool_T)
        self.sd[on] += slip * dt
        area = np.diff(self._area_below(surface))
        total = np.concatenate([area[:1], area[:-1] + area[1:], area[-1:]])
        first = self.reference_area
        self.psi = total / np.concatenate([first[:1], first[:-1] + first[1:], first[-1:]])

    def move_to(self, old_surface: FloatArray, old_arc_of_new_nodes: FloatArray) -> None:
        """Follow a remeshing: new nodes stood at `old_arc_of_new_nodes` on the old surface."""
        arc = self.at_markers(arc_length(old_surface))
        self.position = _index_coordinate(arc, old_arc_of_new_nodes)

    def loads(self) -> FloatArray:
        """Return v_rel, T, sigma_n, sd, psi of the markers, shape (n, 5)."""
        return np.column_stack([self.v_rel, self.T, self.sigma_n, self.sd, self.psi])


def _index_coordinate(arc: FloatArray, node_arc: FloatArray) -> FloatArray:
    """Return node index plus fraction of the edge for points at given arc lengths."""
    return np.interp(arc, node_arc, np.arange(len(node_arc), dtype=np.float64))


#: Least share of a nodal area that a contact is taken to have, where its force becomes a traction.
LEAST_SHARE = 0.25


def bore_pressure(table: FloatArray, weights: FloatArray, spread: float = 0.0) -> float:
    """Return the mean contact pressure of a tool over its contact area seen in radial direction [MPa].

    A short contact is carried by the tool around it: the force counts over an area of at least `spread`.
    """
    area = np.where(table[:, PRESSURE] > 0.0, np.abs(table[:, NORMAL_R]) * weights, 0.0)
    total = max(float(area.sum()), spread)
    return float(area @ table[:, PRESSURE]) / total if total > 0.0 else 0.0


def along_contact(values: FloatArray, weights: FloatArray, tool: IntArray) -> FloatArray:
    """Return values of the surface nodes averaged with their neighbours under the same tool (1 : 2 : 1, by area).

    Node-wise contact pressures alternate from node to node by some percent around the traction that they
    stand for; the average takes that away and keeps the resultant force to 0.1 %.

    - `tool`, shape (n,): which tool the node touches; -1: none.
    """
    joined = ((tool[1:] == tool[:-1]) & (tool[1:] >= 0)).astype(np.float64)
    sums = []
    for quantity in (values * weights, weights):
        flow = 0.25 * joined * np.diff(quantity)
        sums.append(quantity + np.append(flow, 0.0) - np.append(0.0, flow))
    return np.where(tool >= 0, sums[0] / np.maximum(sums[1], 1e-300), values)


def surface_loads(
    surface: FloatArray, tables: list[FloatArray], tools: list[Tool], weights: FloatArray
) -> SurfaceLoads:
    """Join the contact tables: at each node the tool that presses hardest counts.

    Nodal forces become tractions over the part of the nodal areas `weights` that faces the tool; at the edge of a
    contact the rest belongs to the free side. The pressure is averaged along the contact.
    """
    pressures = np.array([table[:, PRESSURE] for table in tables])
    hardest = pressures.argmax(axis=0)
    nodes = np.arange(pressures.shape[1])
    joined = np.array(tables)[hardest, nodes]
    temperatures = np.array([tool.surface_temperature(surface) for tool in tools])
    share = np.maximum(joined[:, FACING], LEAST_SHARE)
    pressure = np.maximum(joined[:, PRESSURE], 0.0) / share
    return SurfaceLoads(
        pressure=along_contact(pressure, weights * share, np.where(pressure > 0.0, hardest, -1)),
        shear=joined[:, SHEAR] / share,
        slip=joined[:, SLIP],
        tool_T=temperatures[hardest, nodes],
        active=joined[:, PRESSURE] > 0.0,
    )
