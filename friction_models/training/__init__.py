"""Training and its measurement: cross-validation by whole tests, errors per test, search of parameters, learning curves."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..loads.splits import hold_out as hold_out
    from ..loads.splits import k_fold as k_fold
    from ..models.measures import error_measures as error_measures
    from .evaluation import Evaluation as Evaluation
    from .evaluation import evaluate as evaluate
    from .evaluation import train as train
    from .learning_curve import growing_sets as growing_sets
    from .learning_curve import lowest_error as lowest_error
    from .learning_curve import needed_tests as needed_tests
    from .learning_curve import needed_with_interval as needed_with_interval
    from .learning_curve import percentile_curve as percentile_curve
    from .learning_curve import share_fewer as share_fewer
    from .search import GridSearch as GridSearch
    from .search import best_parameters as best_parameters
    from .search import cross_validate as cross_validate
    from .search import fit_all as fit_all
    from .search import grid_search as grid_search

_EXPORTS = {
    "Evaluation": ".evaluation",
    "GridSearch": ".search",
    "best_parameters": ".search",
    "cross_validate": ".search",
    "error_measures": "..models.measures",
    "evaluate": ".evaluation",
    "fit_all": ".search",
    "grid_search": ".search",
    "growing_sets": ".learning_curve",
    "hold_out": "..loads.splits",
    "k_fold": "..loads.splits",
    "lowest_error": ".learning_curve",
    "needed_tests": ".learning_curve",
    "needed_with_interval": ".learning_curve",
    "percentile_curve": ".learning_curve",
    "share_fewer": ".learning_curve",
    "train": ".evaluation",
}

__all__ = sorted(_EXPORTS)


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return getattr(importlib.import_module(_EXPORTS[name], __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
