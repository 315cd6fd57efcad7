"""What changes during an ejection, in parts that a snapshot copies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from ..fe.mesh.shape import FloatArray
from ..fe.state import State
from ..tools.ejection_tools import GripPatch, Stage

#: First guesses of the velocity, as shares of the last one, and v0 of the friction law as shares of the tool
#: speed, tried one after the other: the slip turns round in single increments, which a sharp law with a poor
#: guess does not survive. A blunter law leaves some friction unused where the product hardly slips.
TRIALS = ((0.0, 0.02), (-1.0, 0.02), (0.0, 0.05), (-1.0, 0.1), (0.0, 0.2))


class EjectionRow(NamedTuple):
    """Travel, force, work and grip at the end of an increment."""

    stage: str
    travel: float
    force: float
    work: float
    grip: float


@dataclass
class StageUnderWay:
    """The stage under way; `stage` holds the tools as they stood at its start."""

    number: int
    stage: Stage
    #: Velocity of the nodes when the stage began [mm/s].
    incoming: FloatArray
    #: The last increment.
    last: EjectionRow
    #: Which of `TRIALS` is in use.
    trial: int = 0
    #: Travel at which something was last held [mm], and the highest load so far [N].
    last_touch: float = 0.0
    start_load: float = 0.0


@dataclass
class EjectionProgress:
    """Result of all stages so far."""

    rows: list[EjectionRow] = field(default_factory=list)
    patches: tuple[GripPatch, ...] = ()
    travel: float = 0.0
    #: v0 of the bluntest friction law that was needed, as a share of the tool speed.
    regularisation: float = TRIALS[0][1]
    finished: bool = False


class EjectionState(NamedTuple):
    """All that changes during an ejection."""

    motion: StageUnderWay
    progress: EjectionProgress
    simulation: State
