"""Causes of a deviation between measured and simulated forces."""

from __future__ import annotations

from dataclasses import dataclass

from friction_models.effects import CATALOGUE

#: Parameter by which a friction FMU with effects scales mu.
FACTOR = "mu_factor"
KINDS = ("friction", "flow stress", "heat", "machine")


@dataclass(frozen=True)
class Cause:
    """Something that changes a force-stroke curve.

    Examples
    --------
    >>> cause = Cause("tool_temperature", "tool temperature", "heat", "K", 15.0)
    >>> cause.key, Cause("static_peak", "static peak", "friction", "1", column="a").key
    ('tool_temperature', 'static_peak.a')
    """

    name: str
    title: str
    kind: str  # one of `KINDS`
    unit: str  # of the strength
    step: float = 0.0  # how far it is moved for the sensitivity; 0 where no run is needed
    sign: int = 0  # physical sign of the strength; 0: both
    column: str = ""  # tells two strengths of one cause apart; empty for most
    #: Of the FMU, that moves it; empty for what is packed into the forming FMU, and where no run is needed.
    parameter: str = ""

    @property
    def key(self) -> str:
        """Name of the run."""
        return f"{self.name}.{self.column}" if self.column else self.name


#: A node that touches at another increment moves the force by up to 0.5 %. The step of the flow stress makes the force change
#: by twenty times as much, so that its fingerprint shows the flow stress and not such a node; the force is in proportion to it.
FORMING = (
    Cause("flow_stress", "flow stress of the workpiece, relative", "flow stress", "1", 0.1),
    Cause("tool_temperature", "tool temperature", "heat", "K", 15.0, parameter="T_tool"),
    Cause("billet_temperature", "billet temperature", "heat", "K", 15.0, parameter="T_billet"),
    Cause("heat_transfer", "heat transfer to the tools, relative", "heat", "1", 0.5, parameter="htc"),
)
FRICTION_LEVEL = Cause(
    "friction_level", "friction as a whole, relative", "friction", "1", 0.2, parameter=FACTOR
)
#: Seen in the simulated curve itself.
MACHINE = (
    Cause("compliance", "elastic give of press and tools", "machine", "mm/kN", sign=1),
    Cause("stroke_zero", "zero of the stroke", "machine", "mm"),
    Cause("force_gain", "gain of the force cell, relative", "machine", "1"),
)


def all_causes() -> list[str]:
    """Return the names of all causes.

    Examples
    --------
    >>> all_causes()[:4]
    ['flow_stress', 'tool_temperature', 'billet_temperature', 'heat_transfer']
    """
    physics = [e.name for e in CATALOGUE.values() if e.kind == "physics" and not e.metadata]
    return [c.name for c in (*FORMING, FRICTION_LEVEL, *MACHINE)] + physics
