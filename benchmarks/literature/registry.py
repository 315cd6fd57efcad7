"""All laws; importing this module fills the register."""

from __future__ import annotations

from . import (  # noqa: F401
    laws_memory,
    laws_outside,
    laws_path,
    laws_pressure,
    laws_speed,
    laws_system,
    laws_temperature,
)
from .law import REGISTER, Law, get

__all__ = ["REGISTER", "Law", "catalogue_laws", "faults", "get", "outside_laws"]


def catalogue_laws() -> list[Law]:
    """Laws with a right name that are physics."""
    return [law for law in REGISTER.values() if not law.outside and not law.fault]


def faults() -> list[Law]:
    """Laws that are faults of the measurement."""
    return [law for law in REGISTER.values() if law.fault]


def outside_laws() -> list[Law]:
    """Laws without a right name."""
    return [law for law in REGISTER.values() if law.outside]
