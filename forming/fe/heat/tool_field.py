"""Temperature field of a rigid tool, on a mesh of its own, coupled to the workpiece through the contact."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit

from ..mesh.mesher import quad_mesh
from ..mesh.polyline import SizeField, arc_length, at_arc_length, spaced
from ..mesh.shape import FloatArray, IntArray
from .properties import Property
from .surface_layer import Exchange, SurfaceLayer

#: Points of Gauss, from 0 to 1, on each piece of a tool edge that the contact covers.
GAUSS: FloatArray = np.array([0.5 - 0.5 / 3.0**0.5, 0.5 + 0.5 / 3.0**0.5])


@dataclass(frozen=True)
class ToolSteel:
    """Heat data of a tool steel; by default 1.2379 (handbook values)."""

    #: [W/(m K)].
    conductivity: Property = 20.0
    #: Heat capacity of a volume [N/(mm2 K)].
    capacity: Property = 7700.0 * 460.0 * 1e-6


@njit(cache=True)
def nearest_on_chain(points: FloatArray, chain: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return for each point the nearest edge of a polyline, the fraction along it, and the distance."""
    edge = np.zeros(points.shape[0], np.int64)
    fraction = np.zeros(points.shape[0])
    distance = np.zeros(points.shape[0])
    lengths = np.hypot(chain[1:, 0] - chain[:-1, 0], chain[1:, 1] - chain[:-1, 1])
    for p in range(points.shape[0]):
        best = 1e30
        # Neighbours are close to each other: the edge of the last point tells how near the edge of this one must be.
        start = chain[edge[p - 1]] if p > 0 else chain[0]
        reach = 1.000001 * np.hypot(points[p, 0] - start[0], points[p, 1] - start[1])
        for k in range(chain.shape[0] - 1):
            pr = points[p, 0] - chain[k, 0]
            pz = points[p, 1] - chain[k, 1]
            # No point of the edge is closer to its start than its length.
            if pr * pr + pz * pz > (reach + lengths[k]) ** 2:
                continue
            er = chain[k + 1, 0] - chain[k, 0]
            ez = chain[k + 1, 1] - chain[k, 1]
            t = min(1.0, max(0.0, (pr * er + pz * ez) / (er * er + ez * ez + 1e-30)))
            d = (pr - t * er) ** 2 + (pz - t * ez) ** 2
            if d < best:
                best = d
                edge[p] = k
                fraction[p] = t
        distance[p] = np.sqrt(best)
    return edge, fraction, distance


@njit(cache=True)
def covered(
    surface: FloatArray,
    body: FloatArray,
    touching: np.ndarray,
    facing: FloatArray,
    T: FloatArray,
    power: FloatArray,
) -> FloatArray:
    """Return contact area per radian, that times the workpiece's temperature, and heat at tool nodes, shape (3, n_s).

    Each edge of the workpiece in contact is laid onto the tool, and its area spread over what it covers there. So all three
    follow the positions without a jump, and sum up to what the workpiece has. An edge with one end in contact counts by half.

    - `surface`, shape (n_s, 2): tool surface nodes; the others are as in `ToolField.step`.
    """
    n_edges = body.shape[0] - 1
    edges = np.empty(n_edges, np.int64)
    starts, ends = np.empty(n_edges), np.empty(n_edges)
    points = np.empty((2 * n_edges, 2))
    count = 0
    for e in range(n_edges):
        if facing[e] <= 0.0 or not (touching[e] or touching[e + 1]):
            continue
        edges[count] = e
        starts[count] = 0.0 if touching[e] else 0.5
        ends[count] = 1.0 if touching[e + 1] else 0.5
        for i in range(2):
            points[2 * count, i] = body[e, i] + starts[count] * (body[e + 1, i] - body[e, i])
            points[2 * count + 1, i] = body[e, i] + ends[count] * (body[e + 1, i] - body[e, i])
        count += 1
    at_nodes = np.zeros((3, surface.shape[0]))
    below, fraction, _ = nearest_on_chain(points[: 2 * count], surface)
    arc = np.zeros(surface.shape[0])
    for k in range(surface.shape[0] - 1):
        arc[k + 1] = arc[k] + np.hypot(surface[k + 1, 0] - surface[k, 0], surface[k + 1, 1] - surface[k, 1])
    for j in range(count):
        e = edges[j]
        k0, k1 = below[2 * j], below[2 * j + 1]
        first = arc[k0] + fraction[2 * j] * (arc[k0 + 1] - arc[k0])
        last = arc[k1] + fraction[2 * j + 1] * (arc[k1 + 1] - arc[k1])
        length = np.hypot(body[e + 1, 0] - body[e, 0], body[e + 1, 1] - body[e, 1])
        # Where only one end touches, its values hold.
        start = e if touching[e] else e + 1
        end = e + 1 if touching[e + 1] else e
        way = last - first
        if abs(way) < 1e-12:
            k1 = k0
        for k in range(min(k0, k1), max(k0, k1) + 1):
            # Places on the edge, 0 at the first and 1 at the last, between which it covers this edge of the tool.
            low, high = 0.0, 1.0
            if k0 != k1:
                a, b = (arc[k] - first) / way, (arc[k + 1] - first) / way
                low, high = max(0.0, min(a, b)), min(1.0, max(a, b))
            for g in GAUSS:
                t = low + g * (high - low)
                u = starts[j] + t * (ends[j] - starts[j])
                v = (first + t * way - arc[k]) / (arc[k + 1] - arc[k])
                radius = body[e, 0] + u * (body[e + 1, 0] - body[e, 0])
                area = 0.5 * (high - low) * (ends[j] - starts[j]) * facing[e] * length * radius
                warm = area * (T[start] + u * (T[end] - T[start]))
                heat = area * (power[start] + u * (power[end] - power[start]))
                at_nodes[0, k] += (1.0 - v) * area
                at_nodes[0, k + 1] += v * area
                at_nodes[1, k] += (1.0 - v) * warm
                at_nodes[1, k + 1] += v * warm
                at_nodes[2, k] += (1.0 - v) * heat
                at_nodes[2, k + 1] += v * heat
    return at_nodes


@dataclass
class ToolField:
    """Temperatures of one tool, in the tool's own frame."""

    #: Mesh.
    x: FloatArray
    quads: IntArray
    #: Nodes along the working surface, shape (n_s,).
    surface: IntArray
    #: Nodes on the outside, held at `far_T`.
    far: IntArray
    far_T: float
    #: Temperature [degC], shape (n,).
    T: FloatArray
    steel: ToolSteel = field(default_factory=ToolSteel)
    #: Thermal boundary layer below the working surface; None before the first contact.
    layer: SurfaceLayer | None = None

    @classmethod
    def build(
        cls,
        working: list[FloatArray],
        back: FloatArray,
        size: SizeField,
        T: float,
    ) -> ToolField:
        """Mesh a tool between its working surface and its back.

        - `working`, shape (n, 2): polylines of the working surface, one behind the other; corners stand
          between them.
        - `back`, shape (m, 2): corners from the end of the working surface to its start, counter-clockwise
          all in all. The first and the last side are insulated, those between keep `T`.
        - `size`: wanted size at the working surface; it grows by 0.4 per mm of depth.
        """
        face = np.concatenate([piece[:-1] for piece in working] + [working[-1][-1:]])

        def graded(points: FloatArray) -> FloatArray:
            return np.minimum(size(points) + 0.4 * nearest_on_chain(points, face)[2], 6.0)

        def nodes(piece: FloatArray) -> FloatArray:
            return at_arc_length(spaced(piece, graded), arc_length(piece), piece)[:-1]

        front = [nodes(piece) for piece in working]
        rear = [nodes(back[k : k + 2]) for k in range(len(back) - 1)]
        mesh = quad_mesh(np.concatenate(front + rear), graded)
        n_front, n_first = sum(map(len, front)), len(rear[0])
        return cls(
            mesh.x,
            mesh.quads,
            np.ascontiguousarray(mesh.loop[: n_front + 1]),
            np.ascontiguousarray(mesh.loop[n_front + n_first : len(mesh.loop) - len(rear[-1]) + 1]),
            float(T),
            np.full(len(mesh.x), float(T)),
        )

    def surface_temperature(self, points: FloatArray) -> FloatArray:
        """Return the temperature of the working surface closest to each point, shape (n,) [degC]."""
        edge, fraction, _ = nearest_on_chain(points, self.x[self.surface])
        T = self.T[self.surface] if self.layer is None else self.layer.surface(self.T)
        return (1.0 - fraction) * T[edge] + fraction * T[edge + 1]

    def step(
        self,
        dt: float,
        body: FloatArray,
        touching: np.ndarray,
        facing: FloatArray,
        T: FloatArray,
        power: FloatArray,
        htc: float,
    ) -> None:
        """Advance by `dt` [s] in contact with a workpiece surface.

        Tool nodes are heated over that part of their area which the contact covers. Where it ends, half of the next edge
        counts, as far as this faces the tool: as much as the last workpiece node holds.

        - `body`, shape (n, 2): workpiece surface nodes in the tool's frame.
        - `touching`, shape (n,): which of them are in contact with this tool.
        - `facing`, shape (n - 1,): cosine between the normals of the edges between them and of the tool.
        - `T`, `power`, shape (n,): their temperature [degC] and the frictional heat that enters the tool
          [N/(mm s)].
        - `htc`: heat transfer coefficient [N/(mm s K)].
        """
        area, warm, heat = covered(self.x[self.surface], body, touching, facing, T, power)
        layer = self.layer or SurfaceLayer.below(self.x, self.quads, self.surface)
        self.layer, self.T = layer.step(
            self.x,
            self.quads,
            self.T,
            np.zeros((len(self.quads), 4)),
            self.steel.capacity,
            self.steel.conductivity,
            dt,
            Exchange(htc * area, htc * warm, heat),
            film=(self.far, np.full(len(self.far), 1e6), np.full(len(self.far), self.far_T)),
        )
