"""Training and its honest measurement: splits by whole tests, errors per test, search of parameters."""

from __future__ import annotations

import importlib
from typing import Any

_EXPORTS = {
    "error_measures": "measures",
    "hold_out": "splits",
    "k_fold": "splits",
    "Evaluation": "evaluation",
    "evaluate": "evaluation",
    "grid_search": "search",
    "GridSearch": "search",
    "cross_validate": "search",
    "train": "evaluation",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
