"""Cross-validation and grid search, both by whole tests."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from sklearn.base import clone

from ..common import InputError, unknown_name
from ..families.ffnn import FeedForwardFriction, fit_together
from ..loads import MEASURED_MU, FloatArray, TriboLoads, check_column, missing_column
from ..loads.splits import k_fold
from ..models.base import FrictionModel, LoadsLike
from ..models.measures import error_measures

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class CrossValidation:
    """Out-of-fold predictions: every test predicted by a model that has not seen it."""

    #: Shape (n,).
    predicted: FloatArray = field(repr=False)
    #: Errors over all points.
    measures: dict[str, float]
    #: Errors of each fold.
    folds: list[dict[str, float]]


@dataclass(frozen=True)
class GridSearch:
    """Result of `grid_search`.

    Attributes
    ----------
    best_params : dict
    model : FrictionModel
        Fitted to all data with the best parameters.
    table : pandas.DataFrame
        One row a combination, best first: parameters, `mae`, `rmse`, `mae_std` (over folds).

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> data = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [500.0, 900.0], "mu": [0.08, 0.07]})
    >>> found = grid_search(ConstantFriction(), {"mu": [0.05, 0.075, 0.1]}, data, folds=2)
    >>> found.model.formula_text()
    'mu = 0.075'
    """

    best_params: dict[str, object]
    model: FrictionModel
    table: pd.DataFrame = field(repr=False)


def cross_validate(
    model: FrictionModel,
    data: pd.DataFrame,
    tests: pd.DataFrame | None = None,
    folds: int = 5,
    seed: int = 0,
) -> CrossValidation:
    """Fit clones of `model` on all folds but one and predict that one; folds are whole tests.

    Raises
    ------
    InputError
        `mu` or `test_id` is missing, or there are fewer tests than folds.

    Examples
    --------
    The mean of one test predicts the other one:

    >>> from friction_models import ConstantFriction
    >>> data = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [500.0, 900.0], "mu": [0.5, 0.25]})
    >>> found = cross_validate(ConstantFriction(), data, folds=2)
    >>> found.predicted.tolist(), found.measures["mae"]
    ([0.25, 0.5], 0.25)
    """
    return _cross_validate([model], data, tests, folds, seed)[0]


def _cross_validate(
    models: Sequence[FrictionModel], data: pd.DataFrame, tests: pd.DataFrame | None, folds: int, seed: int
) -> list[CrossValidation]:
    """Cross-validate several models with the same folds; all their fits are made together."""
    for name in ("test_id", "mu"):
        if name not in data.columns:
            raise missing_column(name, data.columns)
    mu = check_column(data["mu"].to_numpy(), MEASURED_MU)
    ids = data["test_id"].to_numpy().astype(str)
    loads = TriboLoads.from_frame(data, tests)
    splits = list(k_fold(ids, folds, seed))
    fitted = [clone(model) for model in models for _ in splits]
    lessons = [(loads.take(train), mu[train], ids[train]) for train, _ in splits]
    fit_all(fitted, lessons * len(models))
    results = []
    for k in range(len(models)):
        predicted = np.empty(len(mu))
        measures = []
        for (_, held), one in zip(splits, fitted[k * len(splits) : (k + 1) * len(splits)]):
            predicted[held] = one.predict(loads.take(held))
            measures.append(error_measures(mu[held], predicted[held], ids[held]))
        results.append(CrossValidation(predicted, error_measures(mu, predicted, ids), measures))
    return results


def fit_all(
    models: Sequence[FrictionModel], data: Sequence[tuple[LoadsLike, npt.ArrayLike, npt.ArrayLike | None]]
) -> None:
    """Fit each model to its own (loads, mu, groups); networks are trained together in one batched product."""
    networks = [k for k, model in enumerate(models) if isinstance(model, FeedForwardFriction)]
    if networks:
        fit_together([m for m in models if isinstance(m, FeedForwardFriction)], [data[k] for k in networks])
    for k, model in enumerate(models):
        if k not in networks:
            model.fit(*data[k])


def grid_search(
    model: FrictionModel,
    grid: Mapping[str, Sequence[Any]],
    data: pd.DataFrame,
    tests: pd.DataFrame | None = None,
    folds: int = 5,
    seed: int = 0,
    progress: Progress | None = None,
) -> GridSearch:
    """Try every combination of parameters by cross-validation over whole tests; refit the best.

    Parameters
    ----------
    model : FrictionModel
        Its other parameters stay.
    grid : mapping
        Values to try by parameter, e.g. ``{"hidden": [(16,), (32, 32)], "weight_decay": [1e-4, 1e-2]}``.
    data, tests : pandas.DataFrame
        As in `FrictionModel.fit_frame`.
    folds, seed : int
        As in `k_fold`.
    progress : callable, optional
        Called with (combinations done, all combinations).

    Raises
    ------
    InputError
        A parameter is unknown, or has no value to try.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> data = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [500.0, 900.0], "mu": [0.08, 0.07]})
    >>> found = grid_search(ConstantFriction(), {"mu": [0.05, 0.075, 0.1]}, data, folds=2)
    >>> found.best_params
    {'mu': 0.075}
    >>> found.table["mae"].round(6).tolist()
    [0.005, 0.025, 0.025]
    """
    best, table = best_parameters(model, grid, data, tests, folds, seed, progress)
    return GridSearch(best, clone(model).set_params(**best).fit_frame(data, tests), table)


def best_parameters(
    model: FrictionModel,
    grid: Mapping[str, Sequence[Any]],
    data: pd.DataFrame,
    tests: pd.DataFrame | None = None,
    folds: int = 5,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[dict[str, object], pd.DataFrame]:
    """Return the best combination and the table of all without fitting a model to all data; see `grid_search`."""
    for name, values in grid.items():
        if name not in model._get_param_names():
            raise unknown_name(f"parameter of {model.family}", name, model._get_param_names())
        if len(values) == 0:
            raise InputError(f"grid search: no value to try for {name!r}; allowed: one or more")
    combinations = [dict(zip(grid, values)) for values in itertools.product(*grid.values())]
    models = [clone(model).set_params(**params) for params in combinations]
    # Networks of all combinations go together; other models one combination at a time, with progress.
    step = len(models) if isinstance(model, FeedForwardFriction) else 1
    results: list[CrossValidation] = []
    for start in range(0, len(models), step):
        results += _cross_validate(models[start : start + step], data, tests, folds, seed)
        if progress is not None:
            progress(len(results), len(models))
    table = pd.DataFrame(
        [
            {k: str(v) if isinstance(v, (list, tuple)) else v for k, v in params.items()}
            | {name: r.measures[name] for name in ("mae", "rmse")}
            | {"mae_std": float(np.std([f["mae"] for f in r.folds]))}
            for params, r in zip(combinations, results)
        ]
    ).sort_values("rmse", kind="stable")
    return combinations[int(table.index[0])], table.reset_index(drop=True)
