"""`compare`: models against the same measurements, with intervals that treat a test as the unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt
import pandas as pd

from ..common import InputError
from ..common.imports.drawn import Drawn
from ..common.wording import counted, listed
from ..estimation.campaign.binned_tests import BinnedTests
from ..estimation.campaign.binning import prepare
from ..families.refinement_history import faults_of
from ..loads import FloatArray
from ..models.measures import predict_points
from ..models.model_card import Seen, seen_in_training
from .resampling import SAME, as_list, interval_of, is_clear, resampled


@dataclass(frozen=True)
class ModelErrors:
    """Errors of one model.

    Attributes
    ----------
    mae, rmse, bias : float
        Over all points; bias is predicted minus measured.
    mae_interval, rmse_interval, bias_interval : tuple of float
        95 % intervals from resampling whole tests; NaN for a single test.
    wins : float
        Share of the tests on which this model has the smallest RMSE; models with the same one share a test.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> from friction_models.discovery import compare
    >>> data = pd.DataFrame({"test_id": list("abcdef"), "sigma_n": [100.0 * k for k in range(4, 10)], "mu": 0.25})
    >>> errors = compare({"constant": ConstantFriction(0.5)}, data).errors["constant"]
    >>> errors.mae, errors.bias, errors.wins
    (0.25, 0.25, 1.0)
    """

    mae: float
    rmse: float
    bias: float
    mae_interval: tuple[float, float]
    rmse_interval: tuple[float, float]
    bias_interval: tuple[float, float]
    wins: float


class ComparisonNumbers(TypedDict):
    """Errors of all models by name, and the RMSE of every model in each test."""

    tests: int
    points: int
    ranking: list[str]
    clear: bool
    models: dict[str, dict[str, object]]
    per_test: list[dict[str, str | float]]


@dataclass(frozen=True)
class Comparison(Drawn):
    """Errors of several models on the same tests, and their order.

    Attributes
    ----------
    errors : dict of str to ModelErrors
    ranking : list of str
        By RMSE, best first.
    clear : bool
        Whether the best beats the second in 97.5 % of the resampled sets of tests, of at least `FEWEST_TESTS`.
    tests, points : int
    per_test : pandas.DataFrame
        RMSE, one row a test, one column a model.
    synthetic : bool
        Whether the data says of itself that it is synthetic (``data.attrs["synthetic"]``).
    seen : dict of str to Seen
        Models that were trained on some of the tests.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> from friction_models.discovery import compare
    >>> data = pd.DataFrame({"test_id": list("abcdef"), "sigma_n": [100.0 * k for k in range(4, 10)], "mu": 0.1})
    >>> found = compare({"low": ConstantFriction(0.05), "high": ConstantFriction(0.11)}, data)
    >>> found.ranking, found.clear
    (['high', 'low'], True)
    """

    errors: dict[str, ModelErrors]
    ranking: list[str]
    clear: bool
    tests: int
    points: int
    per_test: pd.DataFrame
    synthetic: bool = False
    seen: Mapping[str, Seen] = field(default_factory=dict)
    faults: Mapping[str, Sequence[str]] = field(default_factory=dict)  #: Of the data, that a model knows of.

    def to_dict(self) -> ComparisonNumbers:
        """Return JSON-able data."""
        return {
            "tests": self.tests,
            "points": self.points,
            "ranking": self.ranking,
            "clear": self.clear,
            "models": {
                name: {
                    "mae": e.mae,
                    "rmse": e.rmse,
                    "bias": e.bias,
                    "mae_interval": as_list(e.mae_interval),
                    "rmse_interval": as_list(e.rmse_interval),
                    "bias_interval": as_list(e.bias_interval),
                    "wins": e.wins,
                    "trained_on_tests": self.seen[name].tests if name in self.seen else [],
                }
                for name, e in self.errors.items()
            },
            "per_test": [
                {"test_id": str(test), **{str(k): float(v) for k, v in row.items()}}
                for test, row in self.per_test.iterrows()
            ],
        }

    def remarks(self) -> list[str]:
        """Return a sentence for each model that was trained on tests that it is judged by, or whose predictions are without a fault of the data."""
        return [
            *(self.seen[name].sentence(name) for name in self.ranking if name in self.seen),
            *(
                f"{name}: the measurements hold {listed(self.faults[name])}, which its predictions leave out; refine judges it without"
                for name in self.ranking
                if name in self.faults
            ),
        ]

    def __repr__(self) -> str:
        errors = ", ".join(f"{n}: {self.errors[n].rmse:.4g}" for n in self.ranking)
        return f"Comparison(RMSE of {errors}; {self.tests} tests, {self.points} points)"

    def report(self) -> str:
        """Return a text table, best model first."""
        best = self.ranking[0]
        if len(self.ranking) == 1:
            head = f"{best}: RMSE {self.errors[best].rmse:.5f} on {counted(self.tests, 'test')}"
        else:
            how = "is clearly ahead of" if self.clear else "is ahead, but not clearly, of"
            if self.errors[self.ranking[1]].rmse - self.errors[best].rmse <= SAME * self.errors[best].rmse:
                how = "has the same error as"
            head = f"{best} {how} {self.ranking[1]} on {counted(self.tests, 'test')} ({counted(self.points, 'point')})"
        width = max(len(n) for n in self.ranking)
        lines = [
            head,
            *(["(synthetic data)"] if self.synthetic else []),
            "",
            f"{'model':<{width}}  RMSE [95 %]                  MAE [95 %]                   bias [95 %]                    best on",
        ]
        for name in self.ranking:
            e = self.errors[name]
            lines.append(
                f"{name:<{width}}  {e.rmse:.5f} {_shown(e.rmse_interval)}  {e.mae:.5f} {_shown(e.mae_interval)}  "
                f"{e.bias:+.5f} {_shown(e.bias_interval, '+')}  {100 * e.wins:3.0f} % of tests"
            )
        return "\n".join([*lines, *([""] if self.seen or self.faults else []), *self.remarks()]) + "\n"


def compare(
    models: Mapping[str, Any], data: pd.DataFrame, tests: pd.DataFrame | None = None, seed: int = 0
) -> Comparison:
    """Compare models with measurements.

    Parameters
    ----------
    models : mapping of str to model
        Anything with ``predict_frame(data, tests)`` or ``predict(array[n, 5])``.
    data : pandas.DataFrame
        Points in the columns of the contract.
    tests : pandas.DataFrame, optional
        Metadata, for models with system variables.
    seed : int
        Of the resampling.

    Raises
    ------
    InputError
        No model, bad data, or a prediction that is not one finite value a point.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> data = pd.DataFrame({"test_id": list("abcdef"), "sigma_n": [100.0 * k for k in range(4, 10)], "mu": 0.1})
    >>> found = compare({"low": ConstantFriction(0.05), "high": ConstantFriction(0.11)}, data)
    >>> print(found.report().splitlines()[0])
    high is clearly ahead of low on 6 tests (6 points)
    """
    if not isinstance(models, Mapping):
        raise InputError(
            f"compare: models is a {type(models).__name__}; allowed: a mapping from names to models"
        )
    if not models:
        raise InputError("compare: no model was given; allowed: at least one")
    campaign = prepare(data, tests)
    errors, seen, faults = {}, {}, {}
    ids, measured = _as_given(data)
    for name, model in models.items():
        predicted = predict_points(f"model {name!r}", model, campaign.loads, tests)
        errors[str(name)] = predicted - campaign.mu
        trained = seen_in_training(model, ids, measured)
        if trained is not None:
            seen[str(name)] = trained
        if known := faults_of(model):
            faults[str(name)] = known
    result = _compare(campaign, errors, np.random.default_rng(seed))
    return replace(result, synthetic=bool(data.attrs.get("synthetic", False)), seen=seen, faults=faults)


def _as_given(data: pd.DataFrame) -> tuple[npt.NDArray[Any], FloatArray]:
    """Return test and measured mu of each point of the given data; empty without test names."""
    if "test_id" not in data.columns:
        return np.empty(0, dtype=str), np.empty(0)
    return data["test_id"].to_numpy(), data["mu"].to_numpy(dtype=float)


def _compare(campaign: BinnedTests, errors: Mapping[str, FloatArray], rng: np.random.Generator) -> Comparison:
    tests = len(campaign.tests)
    group = campaign.point_test
    points = np.bincount(group, minlength=tests).astype(float)
    table = pd.DataFrame(
        {name: np.sqrt(np.bincount(group, e**2, tests) / points) for name, e in errors.items()},
        index=pd.Index(campaign.tests, name="test_id"),
    )
    in_tests = table.to_numpy()
    best = in_tests <= (1.0 + SAME) * in_tests.min(axis=1, keepdims=True)
    won = np.mean(best / best.sum(axis=1, keepdims=True), axis=0)
    draws = resampled(errors, group, rng)
    results = {
        name: ModelErrors(
            float(np.mean(np.abs(error))),
            float(np.sqrt(np.mean(error**2))),
            float(np.mean(error)),
            interval_of(draws[name].mae, tests),
            interval_of(draws[name].rmse, tests),
            interval_of(draws[name].bias, tests),
            float(won[k]),
        )
        for k, (name, error) in enumerate(errors.items())
    }
    ranking = sorted(results, key=lambda n: results[n].rmse)
    clear = len(ranking) > 1 and is_clear(draws[ranking[0]].rmse, draws[ranking[1]].rmse, tests)
    return Comparison(results, ranking, clear, tests, len(group), table)


def _shown(interval: tuple[float, float], sign: str = "") -> str:
    low, high = interval
    return (
        f"{'[not known]':<{18 + 2 * len(sign)}}" if np.isnan(low) else f"[{low:{sign}.5f}, {high:{sign}.5f}]"
    )
