"""Settings of a simulation, its state while it runs, and the energy account of the workpiece.

Forces and stresses of an increment count in the account with the mean of its two ends (trapezoidal rule), on both sides
of the balance. What is left over is then hardly a matter of the increment's length: it shows forces out of equilibrium, a
term that is missing, and what a remeshing loses.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .body import Body
from .contact import NORMAL_R, NORMAL_Z, PRESSURE, SHEAR
from .markers import SurfaceMarkers
from .mesh.shape import FloatArray
from .surface_loads import SurfaceLoads
from .tooling import Tool


class Loading(NamedTuple):
    """Contact at one end of an increment."""

    #: Contact tables of the tools, shape (n_s, 7).
    tables: list[FloatArray]
    #: Surface area per radian of the surface nodes [mm2], shape (n_s,).
    weights: FloatArray
    #: Forces on the tools [N], shape (n_tools, 2).
    forces: FloatArray

    def carried_over(self, arc: FloatArray, new_arc: FloatArray, weights: FloatArray) -> Loading:
        """Return the contact on other surface nodes, for the energy account: stresses in between, the same forces.

        - `arc`, shape (n_s,): arc lengths of the nodes; `new_arc`, shape (m,): those of the new ones on the same surface.
        - `weights`, shape (m,): surface area per radian of the new nodes [mm2].
        """
        tables = [
            np.column_stack([np.interp(new_arc, arc, column) for column in table.T]) for table in self.tables
        ]
        return Loading(tables, weights, self.forces)


@dataclass
class Energy:
    """Energy account of the workpiece [N mm]."""

    #: Work of the tool surfaces on the workpiece; what deforms the tools themselves is no part of it.
    external: float = 0.0
    #: Where it went.
    plastic: float = 0.0
    friction: float = 0.0
    elastic: float = 0.0
    #: Work against the springs that keep the workpiece out of the tools (penalty): some 5 N/mm of contact at
    #: 1000 MPa. It is summed up from the motion, because a contact that grows makes the energy stored in them
    #: grow by itself.
    contact: float = 0.0
    #: Heat released in the workpiece: of plastic work, and its share of the friction.
    heat_generated: float = 0.0
    #: Heat that left it by conduction, and by convection and radiation.
    heat_to_tools: float = 0.0
    heat_to_environment: float = 0.0
    #: Heat in it above `heat_reference` [degC] now and at the start.
    heat_content: float = 0.0
    heat_start: float = 0.0
    heat_reference: float | None = None

    @property
    def heat_imbalance(self) -> float:
        """Heat risen + heat left - heat generated, over the largest of them: what remeshing and compression cost."""
        rise = self.heat_content - self.heat_start
        parts = (rise, self.heat_to_tools, self.heat_to_environment, -self.heat_generated)
        largest = max(map(abs, parts))
        return sum(parts) / largest if largest > 0.0 else 0.0

    @property
    def imbalance(self) -> float:
        """(plastic + friction + elastic + contact) / external - 1."""
        if self.external <= 0.0:
            return 0.0
        return (self.plastic + self.friction + self.elastic + self.contact) / self.external - 1.0

    def add_contact(self, du: FloatArray, moves: list[FloatArray], ends: list[Loading]) -> None:
        """Add the work of the tools in an increment, and what friction and the springs of the contact took of it.

        - `du`, shape (n_s, 2): displacement of the surface nodes [mm].
        - `moves`, shape (2,): displacements of the tools [mm].
        - `ends`: start and end of the increment; where the start is not known, the end alone.
        """
        for tables, weights, forces in ends:
            share = weights / len(ends)
            for table, force, move in zip(tables, forces, moves):
                relative, normal = du - move, table[:, [NORMAL_R, NORMAL_Z]]
                along = relative[:, 0] * normal[:, 1] - relative[:, 1] * normal[:, 0]
                across = (relative * normal).sum(axis=1)
                self.external -= float(force @ move) / len(ends)
                self.friction -= 2.0 * np.pi * float((table[:, SHEAR] * along) @ share)
                self.contact -= 2.0 * np.pi * float((table[:, PRESSURE] * across) @ share)


#: Scales of the size field that a remeshing tries, one after the other.
SCALES = (1.0, 0.85, 0.7)


@dataclass(frozen=True)
class StepControl:
    """Limits of the increments, in mm of tool travel."""

    #: First and largest increment.
    first: float = 0.02
    largest: float = 0.1
    #: Below this the run stops.
    smallest: float = 0.1 / 256.0
    #: Largest sliding of a contact node in one increment.
    slip: float = 0.2
    #: Sliding in the increment with which a node arrives at the end of a rounding of a tool [mm]; 0: as it comes.
    arrival: float = 0.0
    #: Share of the largest increment allowed after a remeshing.
    after_remesh: float = 0.4
    #: Largest change of the force in one increment [N]; larger ones are repeated in halves.
    force_change: float = np.inf
    #: Increments, failed ones included, after which a run stops: a run that creeps must end, too.
    attempts: int = 5000


@dataclass(frozen=True)
class RemeshPolicy:
    """When to remesh: as soon as one of three limits is passed; `Simulation` looks after every increment.

    Processes pass limits of their own.
    """

    every: int = 14  #: Increments since the last mesh, at least.
    quality: float = 0.3  #: The worst element is below this quality.
    strain: float = 0.4  #: Somewhere plastic strain has grown by more than this since the last mesh.
    #: That limit while the tools have travelled less than `first_travel` [mm], if smaller.
    first_strain: float = np.inf
    first_travel: float = 0.0

    def largest_strain(self, travel: float) -> float:
        """Return how much plastic strain may grow while a mesh lasts, after `travel` of the tools [mm]."""
        return min(self.strain, self.first_strain) if travel < self.first_travel else self.strain


@dataclass
class Record:
    """One increment in the history of a run."""

    stroke: float
    time: float
    force: float
    iterations: int
    residual: float
    T_max: float
    strain_max: float
    volume_change: float
    max_tau_over_k: float
    share_above_0_6k: float
    contact_area: float
    nodes: int
    rate_max: float = 0.0
    #: Thickest cell at the surface over how far heat moves in the increment: below 1 where the layer is resolved.
    layer_cell: float = 0.0


@dataclass
class OldMesh:
    """The body before a remeshing, kept until the new mesh has carried an increment."""

    body: Body
    tables: list[FloatArray] | None
    marker_track: FloatArray
    strain_at_remesh: FloatArray
    trial: int


@dataclass
class State:
    """All that changes during a run; a deep copy of it is a snapshot.

    Where punch and press give way, `stroke` is that of the ram, the tools travel `compression` [mm] less, and
    `resistance_slope` is how fast the force last rose over their travel [N/mm]. `ram_work` is in N mm.
    """

    body: Body
    tools: list[Tool]
    markers: SurfaceMarkers
    mu: FloatArray
    strain_at_remesh: FloatArray
    next_dt: float
    stroke: float = 0.0
    time: float = 0.0
    increments: int = 0
    iterations: int = 0
    failures: int = 0
    failures_in_row: int = 0
    remeshes: int = 0
    since_remesh: int = 0
    old_mesh: OldMesh | None = None
    tables: list[FloatArray] | None = None
    #: Contact before a remeshing, on the new surface nodes, until the next increment.
    carried: Loading | None = None
    forces: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    weights: FloatArray = field(default_factory=lambda: np.zeros(0))
    #: Loads on the surface after the last increment; None after a remeshing.
    loads: SurfaceLoads | None = None
    compression: float = 0.0
    resistance_slope: float = 0.0
    ram_work: float = 0.0
    energy: Energy = field(default_factory=Energy)
    history: list[Record] = field(default_factory=list)
    status: str = "ok"
    message: str = ""

    @property
    def travel(self) -> float:
        """Travel of the tools [mm]."""
        return self.stroke - self.compression
