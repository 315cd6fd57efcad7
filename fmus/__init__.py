"""FMUs: friction models for any simulator, the forming solver and the tribometer twin for co-simulation.

Attributes are imported on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .checking import CheckReport as CheckReport
    from .checking import check as check
    from .packing import pack as pack
    from .reading import FmuModel as FmuModel
    from .reading import read_friction_fmu as read_friction_fmu
    from .signal_fmu import pack_signals as pack_signals
    from .solver_fmus import pack_forming as pack_forming
    from .solver_fmus import pack_twin as pack_twin
    from .ssp import pack_ssp as pack_ssp

_EXPORTS = {
    "CheckReport": "checking",
    "FmuModel": "reading",
    "check": "checking",
    "pack": "packing",
    "pack_forming": "solver_fmus",
    "pack_signals": "signal_fmu",
    "pack_ssp": "ssp",
    "pack_twin": "solver_fmus",
    "read_friction_fmu": "reading",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
