"""All laws by name: importing this module fills the list."""

from __future__ import annotations

from benchmarks.blind import laws_outside, laws_pressure_path, laws_speed_heat, laws_system
from benchmarks.blind.law import LAWS, Law

__all__ = ["FILES", "LAWS", "Law"]
FILES = (laws_speed_heat, laws_pressure_path, laws_system, laws_outside)
