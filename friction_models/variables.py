"""Variables of a model beside the five loads: internal states (memory) and system variables (metadata)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class StateVariable:
    """One internal state, kept once per material contact point.

    Attributes
    ----------
    name, unit : str
        Identifier and unit (``"1"`` for a number).
    start : float
        Value of fresh, never loaded contact.
    ode : bool
        Whether the state obeys an ODE whose derivative the model gives.
    """

    name: str
    unit: str
    start: float
    ode: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of `tribofmu.state`."""
        return asdict(self)


@dataclass(frozen=True)
class SystemVariable:
    """One property of the tribological system that test metadata may hold (tool roughness, batch).

    Attributes
    ----------
    name, unit : str
        Identifier and unit.
    start : float
        Value used where the metadata lacks it.
    min, max : float
        Range seen in training.
    """

    name: str
    unit: str
    start: float
    min: float
    max: float

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of `tribofmu.system`."""
        return asdict(self)
