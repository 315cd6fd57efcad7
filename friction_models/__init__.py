"""Friction models of the five tribological loads; knows nothing of FMI.

Attributes are imported on first use: `friction_models.loads` alone costs no scikit-learn or torch.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .loads import TriboLoads as TriboLoads

_EXPORTS = {"TriboLoads": "loads", "DataSet": "loads", "InputError": "loads"}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
