"""Couples friction FMUs with forming FMUs, compares forces, runs the whole loop; the only package that knows all others.

Attributes are imported on first use, so that `tribofmu --help` answers at once.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import SimulationError as SimulationError
    from .forces import ForceComparison as ForceComparison
    from .forces import compare_force as compare_force
    from .master import Master as Master
    from .runs import Run as Run
    from .sct_prediction import predict_sct as predict_sct
    from .system import System as System

_EXPORTS = {
    "ForceComparison": "forces",
    "Master": "master",
    "Run": "runs",
    "SimulationError": "errors",
    "System": "system",
    "compare_force": "forces",
    "predict_sct": "sct_prediction",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
