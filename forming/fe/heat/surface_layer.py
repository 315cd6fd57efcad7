"""Thermal boundary layer below a surface, which the elements are too coarse for.

Heat that enters a surface moves sqrt(a t) deep: 0.25 mm in the 5 ms of a fast stroke, less than one element. Each surface
node therefore has a column of thin cells below it, across some two elements. The temperature is the sum of two parts:

- that of the mesh, which sees the surface insulated, plastic heat and all that is already deeper than the columns;
- that of the columns, one-dimensional conduction with the flux through the surface above and nothing below: heat that
  reaches the lower end enters the mesh there.

Conduction is linear, so the sum obeys it, too; nothing is lost or counted twice. Columns are much finer than any layer
that matters, and a mesh that resolves the layer gives the same sum. For everything that asks the mesh for its temperature
(flow stress, pictures, account), the columns' heat is laid on the nodes around.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..mesh.polyline import arc_length
from ..mesh.shape import FloatArray, IntArray, surface_weights
from ..mesh.transfer import shape_weights
from .conduction import Coupling, heat_step
from .layer_kernels import before_step, column_depths, outward_normals, spread
from .properties import Property, mean_between, value_at

#: Cells of a column, and how much deeper each is than the one above: the first is a 340th of the column.
CELLS, GROWTH = 20, 1.25
FACES: FloatArray = np.asarray(
    (GROWTH ** np.arange(CELLS + 1) - 1.0) / (GROWTH**CELLS - 1.0), dtype=np.float64
)
#: Implicit steps of the columns in one increment.
STEPS = 2
#: Depth of a column in elements.
ELEMENTS = 2.0
#: Iterations for a temperature to which a heat belongs.
ITERATIONS = 8


class Exchange(NamedTuple):
    """What surface nodes exchange with bodies beside them, each of shape (n_s,)."""

    #: Sum of the conductances [N mm/(s K)] per radian, and of conductance times temperature of the body [N mm/s].
    conductance: FloatArray
    outside: FloatArray
    #: Further heat that enters [N mm/s] per radian.
    power: FloatArray
    #: Share of the nodes' areas through which that goes; None: all. At a corner heat comes in on one side: what lies beside the
    #: other is heated as in a body that goes on there.
    share: FloatArray | None = None


@dataclass(frozen=True)
class SurfaceLayer:
    """Columns below the nodes of a surface."""

    #: Nodes of the surface, shape (n_s,).
    chain: IntArray
    #: Nodes around the middle and around the lower end of each column, and their shares, shape (2, n_s, 4).
    nodes: IntArray
    shares: FloatArray
    #: Heat per volume in the cells [N/mm2], shape (n_s, CELLS).
    heat: FloatArray
    #: Depth of the columns [mm] and their area per radian [mm2], shape (n_s,).
    depth: FloatArray
    area: FloatArray
    #: Rise of the surface above the temperature of the mesh alone [K], shape (n_s,).
    rise: FloatArray
    #: What the columns add to the temperatures of the nodes [K], shape (n,).
    carried: FloatArray

    @classmethod
    def below(cls, x: FloatArray, quads: IntArray, chain: IntArray) -> SurfaceLayer:
        """Return a layer without heat below the nodes `chain` of a mesh."""
        area = _areas(x, chain)
        # As deep as elements are long there; smooth along the surface, for columns exchange no heat with each other.
        edge = np.hypot(*np.diff(x[chain], axis=0).T)
        ends = np.concatenate([edge[:1], edge[:1], edge, edge[-1:], edge[-1:]])
        depth = 0.25 * ELEMENTS * (ends[:-3] + ends[1:-2] + ends[2:-1] + ends[3:])
        inward = -outward_normals(x, chain)
        points = [x[chain] + share * depth[:, None] * inward for share in (0.5, 1.0)]
        n = len(chain)
        nodes, shares = shape_weights(np.concatenate(points), x, quads)
        nodes, shares = nodes.reshape(2, n, 4), shares.reshape(2, n, 4)
        depth = column_depths(x, chain, nodes[1], shares[1])
        return cls(chain, nodes, shares, np.zeros((n, CELLS)), depth, area, np.zeros(n), np.zeros(len(x)))

    def on(
        self, before: FloatArray, old_arc: FloatArray, x: FloatArray, quads: IntArray, chain: IntArray
    ) -> SurfaceLayer:
        """Return the layer on a new mesh of the same body; what it carries is left to `settle`.

        - `before`, shape (n_s, 2): surface nodes of the old mesh.
        - `old_arc`: arc lengths at which the new nodes stood on the old surface.
        """
        new = SurfaceLayer.below(x, quads, chain)
        share = self.area / _areas(before, np.arange(len(before)))
        fields = np.column_stack([self.heat, self.depth, self.rise, share])
        moved = PchipInterpolator(arc_length(before), fields, axis=0)(old_arc)
        heat, depth, rise = moved[:, :CELLS], moved[:, CELLS], moved[:, CELLS + 1]
        area = new.area * moved[:, CELLS + 2]
        return replace(new, heat=np.ascontiguousarray(heat), depth=depth, rise=rise, area=area)

    def settle(self, x: FloatArray, quads: IntArray, T: FloatArray, capacity: Property) -> SurfaceLayer:
        """Return the layer with its heat laid on the nodes, whose temperatures without it are `T`."""
        heat = spread(x, quads, self.heat, self.depth, FACES, self.area, self.chain, self.nodes, self.shares)
        carried = _warmed(capacity, T, heat) - T
        return SurfaceLayer(
            self.chain, self.nodes, self.shares, self.heat, self.depth, self.area, self.rise, carried
        )

    def surface(self, T: FloatArray) -> FloatArray:
        """Return the temperatures of the surface itself, shape (n_s,); `T` are those of all nodes."""
        return T[self.chain] - self.carried[self.chain] + self.rise

    def coarseness(self, capacity: Property, conductivity: Property, T: FloatArray, dt: float) -> float:
        """Return the thickest cell at the surface over the distance sqrt(a dt) that heat moves in `dt` [s]."""
        slowest = float((value_at(conductivity, T) / value_at(capacity, T)).min())
        return float(FACES[1] * self.depth.max() / np.sqrt(slowest * dt))

    def step(
        self,
        x: FloatArray,
        quads: IntArray,
        T: FloatArray,
        source: FloatArray,
        capacity: Property,
        conductivity: Property,
        dt: float,
        exchange: Exchange,
        film: tuple[IntArray, FloatArray, FloatArray] | None = None,
    ) -> tuple[SurfaceLayer, FloatArray]:
        """Advance mesh and columns by `dt` [s]; return the layer and the temperatures after.

        - `T`, shape (n,): temperatures of the nodes, with what the columns carry; `source` and `film` as in `heat_step`.
        """
        mesh_T = T - self.carried
        surface_T = mesh_T[self.chain] + 0.5 * self.rise
        depth, area, own, added, ends, entering = before_step(
            x,
            self.chain,
            self.nodes[1],
            self.shares[1],
            self.heat,
            self.depth,
            self.area,
            FACES,
            value_at(capacity, surface_T),
            value_at(conductivity, surface_T),
            dt,
            STEPS,
            *exchange[:3],
            np.ones(len(self.chain)) if exchange.share is None else exchange.share,
        )
        coupling = Coupling(self.chain, entering[0], entering[1], self.nodes[1], self.shares[1])
        mesh_T = heat_step(x, quads, mesh_T, source, capacity, conductivity, dt, film, coupling=coupling)
        q = ends[:, 2] - ends[:, 3] * mesh_T[self.chain]
        rise = ends[:, 0] + ends[:, 1] * q
        heat = own + q[:, None] * added
        layer = SurfaceLayer(self.chain, self.nodes, self.shares, heat, depth, area, rise, self.carried)
        layer = layer.settle(x, quads, mesh_T, capacity)
        return layer, mesh_T + layer.carried


def _areas(x: FloatArray, chain: IntArray) -> FloatArray:
    """Return the area per radian of the surface nodes [mm2]."""
    weights = np.zeros(len(chain))
    surface_weights(x, chain, weights)
    return weights


def _warmed(capacity: Property, T: FloatArray, heat: FloatArray) -> FloatArray:
    """Return the temperatures after `heat` per volume [N/mm2] at temperatures `T`."""
    after = T + heat / value_at(capacity, T)
    if isinstance(capacity, tuple):
        for _ in range(ITERATIONS):
            after = T + heat / mean_between(capacity, T, after)
    return after
