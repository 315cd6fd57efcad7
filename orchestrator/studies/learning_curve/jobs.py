"""The jobs of the learning-curve study: models fitted to growing training sets, judged on held-out tests."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NotRequired, TypedDict

import numpy as np
import pandas as pd

from friction_models.loads import LOAD_NAMES, FloatArray
from friction_models.models.base import FrictionModel
from friction_models.training import best_parameters, fit_all, growing_sets

from ...jobs.graph import JobResult
from ...jobs.job import Files, Needs
from ..measurements import load_measurements

#: The two ways to make training data of a test.
SERIES, AVERAGE = "time-series", "average"
#: No model: the mean of the training tests, to see what any model is worth.
MEAN = "mean"
#: A load whose averages differ by less than this share of their mean was not varied by the plan. What is left of it
#: follows other loads (a fast test slides a little further), and a model would take it for a cause.
NOT_VARIED = 0.15
FOLDS = 5


#: Parameters of models that are other than those of `train`, by model.
Parameters = Mapping[str, Mapping[str, object]]


class FactsInputs(TypedDict):
    """What `facts` gets: every `thin`-th point of a test is learned from, and every one."""

    models: list[str]
    parameters: Parameters
    thin: int
    seed: int


class LearnInputs(FactsInputs):
    """What `learn` gets; `search_thin` and `grid`, the values to try by model and parameter, are for the search."""

    collection: str
    sizes: list[int]
    repeats: int
    search_thin: int
    grid: dict[str, dict[str, list[Any]]]


class Point(TypedDict):
    """Errors of one model at one size of the training set."""

    model: str
    tests: int
    points: int
    parameters: dict[str, object]  # that the search chose
    #: For each repeat what every held-out test contributes by its time series; their mean is the MAE (`Collection.errors`).
    errors: list[list[float]]
    errors_averages: list[list[float]]  # the same by their averages
    search: NotRequired[list[dict[str, object]]]


class ThinningCost(TypedDict):
    """MAE of a model that learned from every point, and from every so many."""

    every_point: float
    thinned: float


class DataFacts(TypedDict):
    """What the data of a lubricant are."""

    synthetic: bool
    train: int
    held_out: int
    points: int
    roles: str | None
    plan: str | None
    mu_mean: float
    scatter_between_tests: float
    scatter_within_tests: float
    mae_mean_of_training: float
    mae_own_mean_of_test: float
    not_varied: list[str]
    thinning: dict[str, ThinningCost]


def learn(inputs: LearnInputs, files: Files, needs: Needs, folder: Path) -> dict[str, list[Point]]:
    """Fit models to training sets of some sizes, for all repeats; ``curves`` are the errors by model and size."""
    (result,) = needs.values()
    data = Collection.of(result, inputs["collection"], inputs["thin"])
    sets = growing_sets(data.tests, inputs["repeats"], inputs["seed"])
    sizes = sorted({min(size, len(data.tests)) for size in inputs["sizes"]})
    curves = [
        _point(data, model, [tests[:size] for tests in sets], inputs)
        for model in inputs["models"]
        for size in sizes
    ]
    return {"curves": curves}


def facts(inputs: FactsInputs, files: Files, needs: Needs, folder: Path) -> DataFacts:
    """Describe the data, and show what it costs to learn from every `thin`-th point only, where `thin` is not 1."""
    (result,) = needs.values()
    whole, thinned = (Collection.of(result, SERIES, thin) for thin in (1, inputs["thin"]))
    judge = whole.judge
    means = judge.groupby("test_id")["mu"].transform("mean")
    costs: dict[str, ThinningCost] = {}
    for name in inputs["models"] if inputs["thin"] > 1 else ():
        errors = []
        for data in (whole, thinned):
            model = _model(name, inputs, len(data.training), inputs["seed"])
            model.fit(*_lesson(data.training))
            errors.append(float(np.mean(data.errors(model))))
        costs[name] = {"every_point": errors[0], "thinned": errors[1]}
    values = result.values
    return {
        "synthetic": bool(values["synthetic"]),
        "train": len(whole.tests),
        "held_out": int(judge["test_id"].nunique()),
        "points": len(whole.training),
        "roles": values.get("roles"),
        "plan": values.get("plan"),
        "mu_mean": float(judge["mu"].mean()),
        "scatter_between_tests": float(judge.groupby("test_id")["mu"].mean().std()),
        "scatter_within_tests": float((judge["mu"] - means).std()),
        "mae_mean_of_training": float(np.mean(np.abs(judge["mu"] - whole.training["mu"].mean()))),
        "mae_own_mean_of_test": float(np.mean(np.abs(judge["mu"] - means))),
        "not_varied": Collection.of(result, AVERAGE, 1).not_varied,
        "thinning": costs,
    }


@dataclass(frozen=True)
class Collection:
    """Training points of one data collection, and the held-out tests that judge both."""

    training: pd.DataFrame  # thinned time series, or one average point a test
    judge: pd.DataFrame  # time series of the held-out tests
    averages: pd.DataFrame  # their averages
    not_varied: list[str] = field(default_factory=list)  # loads that the plan did not vary: constant

    @property
    def tests(self) -> list[str]:
        """Training tests."""
        return sorted(self.training["test_id"].astype(str).unique())

    @classmethod
    def of(cls, result: JobResult, collection: str, thin: int) -> Collection:
        """Read a collection of a lubricant."""
        series, judge = load_measurements(result).frames()
        means, averages = load_measurements(result, averages=True).frames()
        if collection == SERIES:
            chosen = series[series.groupby("test_id").cumcount() % thin == 0].reset_index(drop=True)
            return cls(chosen, judge, averages)
        loads = means[list(LOAD_NAMES)]
        spread = (loads.max() - loads.min()) / loads.mean().abs()
        same = [name for name in LOAD_NAMES if spread[name] < NOT_VARIED]
        return cls(means.assign(**{name: loads[name].mean() for name in same}), judge, averages, same)

    def errors(self, model: FrictionModel | float, averages: bool = False) -> list[float]:
        """Return what each held-out test contributes to the MAE of a model, or of a constant mu; their mean is the MAE.

        Loads are clamped to the trained domain as the FMUs do. A test counts by its number of points.
        """
        held = self.averages if averages else self.judge
        predicted: Any = model
        if not isinstance(model, float):
            predicted = model.predict(model.domain.clamp(held[list(LOAD_NAMES)].to_numpy()))
        wrong = (held["mu"] - predicted).abs().groupby(held["test_id"].astype(str), sort=True).sum()
        return (wrong * (len(wrong) / len(held))).tolist()


def _point(data: Collection, name: str, sets: list[list[str]], inputs: LearnInputs) -> Point:
    """Return the errors of one model at one size of the training set."""
    parts = [data.training[data.training["test_id"].isin(tests)] for tests in sets]
    laws: Sequence[FrictionModel | float]
    best: dict[str, object] = {}
    search: list[dict[str, object]] | None = None
    if name == MEAN:
        laws = [float(part["mu"].mean()) for part in parts]
    else:
        best, search = _search(name, parts[0], len(sets[0]), inputs)
        # One number for all repeats, so that they are alike and are trained in one batch.
        most = max(len(part) for part in parts)
        seeds = (1000 * k + inputs["seed"] for k in range(len(parts)))
        laws = models = [_model(name, inputs, most, seed).set_params(**best) for seed in seeds]
        fit_all(models, [_lesson(part) for part in parts])
    point: Point = {
        "model": name,
        "tests": len(sets[0]),
        "points": len(parts[0]),
        "parameters": {k: list(v) if isinstance(v, tuple) else v for k, v in best.items()},
        "errors": [data.errors(law) for law in laws],
        "errors_averages": [data.errors(law, averages=True) for law in laws],
    }
    return point if search is None else {**point, "search": search}


def _search(
    name: str, part: pd.DataFrame, tests: int, inputs: LearnInputs
) -> tuple[dict[str, object], list[dict[str, object]]]:
    """Return the best parameters by cross-validation over whole tests on the first repeat's training set."""
    grid = inputs["grid"].get(name, {})
    if not grid:
        return {}, []
    thin = inputs["search_thin"] if inputs["collection"] == SERIES else 1
    thinned = part[part.groupby("test_id").cumcount() % thin == 0].reset_index(drop=True)
    model = _model(name, inputs, len(thinned), inputs["seed"], searching=True)
    options = {key: [tuple(v) if isinstance(v, list) else v for v in grid[key]] for key in sorted(grid)}
    best, table = best_parameters(model, options, thinned, folds=min(FOLDS, tests), seed=inputs["seed"])
    return best, [{str(k): v for k, v in row.items()} for row in table.to_dict("records")]


def _model(name: str, inputs: FactsInputs, points: int, seed: int, searching: bool = False) -> FrictionModel:
    """Return an unfitted model with the study's parameters for a training set of so many points."""
    from friction_models.families.registry import make_model

    given: dict[str, Any] = dict(inputs["parameters"].get(name, {}))
    if name == "gradient_boosting":
        return make_model(name, seed=seed, **given)
    if name != "ffnn":
        return make_model(name, **given)
    from friction_models.families.network import epochs_for

    steps = int(given.pop("steps"))
    model = make_model(name, seed=seed, **given)
    # As many steps whatever the size, so that a small training set is learned as thoroughly as a large one.
    epochs = epochs_for(steps, points * (1.0 - model.validation_fraction), model.batch_size)
    model.set_params(epochs=epochs, patience=math.ceil(0.25 * epochs))
    return model.set_params(members=1) if searching else model


def _lesson(points: pd.DataFrame) -> tuple[FloatArray, FloatArray, np.ndarray]:
    return (
        points[list(LOAD_NAMES)].to_numpy(dtype=np.float64),
        points["mu"].to_numpy(dtype=np.float64),
        points["test_id"].to_numpy().astype(str),
    )
