"""Fields of a forming run at one stroke: temperature, strain, stresses, contact, outlines of the tools."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from friction_models.common import unknown_name

from ..fe.body import nodal_shear_yield
from ..fe.mesh.shape import FloatArray, gauss_volumes
from ..fe.simulation import Simulation
from ..fe.surface_loads import surface_loads
from ..fe.tooling import polylines

Floats = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]


@dataclass(frozen=True)
class Field:
    """A field that can be shown: its name, what it is, its unit, and whether its sign matters."""

    name: str
    meaning: str
    unit: str
    signed: bool = False


#: Fields kept for each element: means over its Gauss points.
ELEMENT_FIELDS = (
    Field("strain", "equivalent plastic strain", "1"),
    Field("strain_rate", "equivalent plastic strain rate", "1/s"),
    Field("sigma_eq", "equivalent stress (von Mises)", "MPa"),
    Field("sigma_m", "mean stress", "MPa", True),
    Field("sigma_rr", "radial stress", "MPa", True),
    Field("sigma_zz", "axial stress", "MPa", True),
    Field("sigma_tt", "hoop stress", "MPa", True),
    Field("sigma_rz", "shear stress rz", "MPa", True),
)
#: Everything that a picture can show.
FIELDS = {
    f.name: f
    for f in (
        Field("T", "temperature", "degC"),
        *ELEMENT_FIELDS,
        Field("speed", "speed of the material", "mm/s"),
    )
}
#: Kept for each node of the surface. `tau` is the friction stress, k the shear yield stress kf / sqrt(3).
CONTACT_FIELDS = (
    Field("sigma_n", "contact normal pressure", "MPa"),
    Field("tau", "friction stress", "MPa"),
    Field("mu", "coefficient of friction", "1"),
    Field("tau_over_k", "friction stress over shear yield stress", "1"),
    Field("v_rel", "relative sliding speed", "mm/s"),
    Field("T_tool", "temperature of the tool surface", "degC"),
)


@dataclass(frozen=True)
class Snapshot:
    """Fields at one stroke, in single precision."""

    #: Stroke [mm] and time [s].
    stroke: float
    time: float
    #: Node positions r, z [mm], shape (n, 2).
    x: Floats
    #: Elements, shape (n_e, 4).
    quads: Ints
    #: Temperature at the nodes [degC], shape (n,).
    T: Floats
    #: Velocity at the nodes [mm/s], shape (n, 2).
    velocity: Floats
    #: `ELEMENT_FIELDS`, in their order, shape (n_e, 8).
    elements: Floats
    #: Nodes of the surface, from the lower to the upper end of the axis, shape (n_s,).
    chain: Ints
    #: `CONTACT_FIELDS` in their order; 0 where no tool touches (mu is always there), shape (n_s, 6).
    contact: Floats
    #: Surface of each tool as a chain of points with the workpiece on its left [mm], shape (m, 2).
    tools: dict[str, Floats]

    @classmethod
    def of(cls, simulation: Simulation) -> Snapshot:
        """Take the fields of a simulation as it is now."""
        state = simulation.state
        body = state.body
        mean = body.stress[:, :, :3].mean(axis=2)
        deviator = body.stress[:, :, :3] - mean[:, :, None]
        equivalent = np.sqrt(1.5 * ((deviator**2).sum(axis=2) + 2.0 * body.stress[:, :, 3] ** 2))
        rr, zz, tt, rz = np.moveaxis(body.stress, 2, 0)
        gauss = np.stack([body.strain, body.rate, equivalent, mean, rr, zz, tt, rz])
        w = gauss_volumes(body.x, body.quads)
        means = (gauss * w).sum(axis=2) / w.sum(axis=1)
        tools = {
            tool.name
            if sum(t.name == tool.name for t in state.tools) == 1
            else f"{tool.name} {number}": _chain(tool.segments, tool.offset)
            for number, tool in enumerate(state.tools, 1)
        }
        return cls(
            state.stroke,
            state.time,
            body.x.astype(np.float32),
            body.quads.astype(np.int32),
            body.T.astype(np.float32),
            body.velocity.astype(np.float32),
            np.ascontiguousarray(means.T, dtype=np.float32),
            body.chain.astype(np.int32),
            surface_contact(simulation).astype(np.float32),
            tools,
        )

    def nodal(self, name: str) -> FloatArray:
        """Return a field at the nodes, shape (n,); element fields as means of the elements around.

        Raises InputError: no such field; the message names the nearest.
        """
        if name == "T":
            return self.T.astype(np.float64)
        if name == "speed":
            return np.hypot(*self.velocity.astype(np.float64).T)
        names = [f.name for f in ELEMENT_FIELDS]
        if name not in names:
            raise unknown_name("field", name, FIELDS, "forming")
        values = np.repeat(self.elements[:, names.index(name)].astype(np.float64), 4)
        weights = np.repeat(
            gauss_volumes(self.x.astype(np.float64), self.quads.astype(np.int64)).sum(axis=1), 4
        )
        nodes = self.quads.ravel()
        total = np.bincount(nodes, weights * values, len(self.x))
        weight = np.bincount(nodes, weights, len(self.x))
        return total / np.where(weight > 0.0, weight, 1.0)


def surface_contact(simulation: Simulation) -> FloatArray:
    """Return `CONTACT_FIELDS` at the surface nodes, shape (n_s, 6), for the state as it is now.

    k belongs to the end of the increment. Right after a remeshing, before the next increment, nothing but
    mu is known.
    """
    state, body = simulation.state, simulation.state.body
    n = len(body.chain)
    columns = dict.fromkeys((f.name for f in CONTACT_FIELDS), np.zeros(n))
    columns["mu"] = state.markers.at_nodes(state.mu, n)
    if state.tables is not None:
        loads = state.loads or surface_loads(body.surface, state.tables, state.tools, state.weights)
        flow_curve = simulation.material.vector()
        k = nodal_shear_yield(body.quads, body.strain, body.rate, body.T, flow_curve)[body.chain]
        tau = np.abs(loads.shear)
        touching = {
            "sigma_n": loads.pressure,
            "tau": tau,
            "tau_over_k": tau / k,
            "v_rel": np.abs(loads.slip),
            "T_tool": loads.tool_T,
        }
        columns |= {name: np.where(loads.active, column, 0.0) for name, column in touching.items()}
    return np.column_stack([columns[f.name] for f in CONTACT_FIELDS])


def _chain(segments: FloatArray, offset: FloatArray) -> Floats:
    pieces = polylines(segments)
    points = np.concatenate([pieces[0], *(p[1:] for p in pieces[1:])]) + offset
    return points.astype(np.float32)


#: Arrays of a snapshot in the order of its attributes, with the type they are kept in.
ARRAYS: dict[str, type[np.float32 | np.int32]] = {
    "x": np.float32,
    "quads": np.int32,
    "T": np.float32,
    "velocity": np.float32,
    "elements": np.float32,
    "chain": np.int32,
    "contact": np.float32,
}


def checked(s: Snapshot) -> Snapshot:
    """Return a snapshot that was read; raise ValueError where its arrays do not fit together."""
    n, n_e, n_s = len(s.x), len(s.quads), len(s.chain)
    shapes = [(s.x, (n, 2)), (s.quads, (n_e, 4)), (s.T, (n,)), (s.velocity, (n, 2)), (s.chain, (n_s,))]
    shapes += [(s.elements, (n_e, len(ELEMENT_FIELDS))), (s.contact, (n_s, len(CONTACT_FIELDS)))]
    shapes += [(chain, (len(chain), 2)) for chain in s.tools.values()]
    if any(array.shape != shape for array, shape in shapes) or not n_e > 0:
        raise ValueError(f"wrong shapes at stroke {s.stroke:g} mm")
    for nodes in (s.quads, s.chain):
        if nodes.min() < 0 or nodes.max() >= n:
            raise ValueError(f"nodes out of range at stroke {s.stroke:g} mm")
    if not all(np.isfinite(array).all() for array, _ in shapes):
        raise ValueError(f"a number that is not finite at stroke {s.stroke:g} mm")
    return s
