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
    "best_parameters": "search",
    "fit_all": "search",
    "growing_sets": "learning_curve",
    "lowest_error": "learning_curve",
    "needed_with_interval": "learning_curve",
    "percentile_curve": "learning_curve",
    "share_fewer": "learning_curve",
    "needed_tests": "learning_curve",
    "train": "evaluation",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(f".{_EXPORTS[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
