"""Settings of a simulation, and its state while it runs."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .body import Body
from .energy import Energy
from .markers import SurfaceMarkers
from .mesh.shape import FloatArray
from .tooling import Tool

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
    #: Share of the largest increment allowed after a remeshing.
    after_remesh: float = 0.3
    #: Largest change of the force in one increment [N]; larger ones are repeated in halves.
    force_change: float = np.inf
    #: Increments, failed ones included, after which a run stops: a run that creeps must end, too.
    attempts: int = 5000


@dataclass(frozen=True)
class RemeshPolicy:
    """When to remesh: after so many increments, at this element quality, at this plastic strain since."""

    every: int = 10
    quality: float = 0.3
    strain: float = 0.4


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


@dataclass
class OldMesh:
    """The body before a remeshing, kept until the new mesh has carried an increment."""

    body: Body
    tables: list[FloatArray] | None
    marker_position: FloatArray
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
    forces: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    weights: FloatArray = field(default_factory=lambda: np.zeros(0))
    compression: float = 0.0
    resistance_slope: float = 0.0
    ram_work: float = 0.0
    energy: Energy = field(default_factory=Energy)
    history: list[Record] = field(default_factory=list)
    status: str = "ok"
    message: str = ""
