"""C functions of an FMU: one class for FMI 2.0, one for FMI 3.0, with the same methods."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .fmi2 import Fmi2Slave
from .fmi3 import Fmi3Slave
from .slave import Slave


def load(archive: Path, raw: Any, unpacked: Path) -> Slave:
    """Load the binary of a co-simulation FMU; the arguments are those of `Slave`."""
    return (Fmi2Slave if raw.fmiVersion == "2.0" else Fmi3Slave)(archive, raw, unpacked)


__all__ = ["Slave", "load"]
