"""C functions of an FMU: one class for FMI 2.0, one for FMI 3.0, with the same methods."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from .fmi2 import Fmi2Slave
from .fmi3 import Fmi3Slave
from .slave import Slave


def offer_interpreter() -> None:
    """Let solver FMUs that start Python as a process find this interpreter, unless the user chose one."""
    os.environ.setdefault("TRIBOFMU_PYTHON", sys.executable)


def load(archive: Path, raw: Any, unpacked: Path) -> Slave:
    """Load the binary of a co-simulation FMU; the arguments are those of `Slave`."""
    offer_interpreter()
    return (Fmi2Slave if raw.fmiVersion == "2.0" else Fmi3Slave)(archive, raw, unpacked)


__all__ = ["Slave", "load"]
