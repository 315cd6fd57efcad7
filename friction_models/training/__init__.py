"""Training and its measurement: cross-validation by whole tests, errors per test, search of parameters, learning curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..common.imports.lazy_names import lazily

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

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
