"""Couples friction FMUs with forming FMUs, compares forces, runs the whole loop; the only package that knows all others.

Attributes are imported on first use, so that `tribofmu --help` answers at once.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fmus.runtime.errors import SimulationError as SimulationError

    from .cosim.master import Master as Master
    from .cosim.ready_made import extrusion_system as extrusion_system
    from .cosim.run_folders import Run as Run
    from .cosim.system import System as System
    from .force_curves.forces import ForceComparison as ForceComparison
    from .force_curves.forces import compare_force as compare_force
    from .prediction.predict_sct import predict_sct as predict_sct

_EXPORTS = {
    "ForceComparison": "force_curves.forces",
    "Master": "cosim.master",
    "Run": "cosim.run_folders",
    "SimulationError": "cosim.master",
    "System": "cosim.system",
    "extrusion_system": "cosim.ready_made",
    "compare_force": "force_curves.forces",
    "predict_sct": "prediction.predict_sct",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
