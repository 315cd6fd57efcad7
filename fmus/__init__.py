"""FMUs: friction models for any simulator, the forming solver and the tribometer twin for co-simulation.

Attributes are imported on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .checks.checking import CheckReport as CheckReport
    from .checks.checking import check as check
    from .runtime.fixed_friction import FmuModel as FmuModel
    from .runtime.fixed_friction import read_friction_fmu as read_friction_fmu
    from .ssp.packing import pack_ssp as pack_ssp
    from .targets.packing import pack as pack
    from .targets.signals import pack_signals as pack_signals
    from .targets.solvers import pack_forming as pack_forming
    from .targets.solvers import pack_twin as pack_twin

_EXPORTS = {
    "CheckReport": "checks.checking",
    "FmuModel": "runtime.fixed_friction",
    "check": "checks.checking",
    "pack": "targets.packing",
    "pack_forming": "targets.solvers",
    "pack_signals": "targets.signals",
    "pack_ssp": "ssp.packing",
    "pack_twin": "targets.solvers",
    "read_friction_fmu": "runtime.fixed_friction",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
