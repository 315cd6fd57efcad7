"""`FrictionModel`: the base class of all friction models. It learns from data, explains itself, and is saved."""

from __future__ import annotations

import inspect
import os
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt
import pandas as pd
from sklearn.base import clone

from ..common import InputError
from ..common.imports.drawn import Drawn
from ..common.wording import counted
from ..expressions.scaling import not_told_apart
from ..loads import MEASURED_MU, FloatArray, TriboLoads, check_column, missing_column
from .domain import Domain
from .effective_variance import FitWeights, Refit, by_polynomial, checked_weights, load_weights
from .intervals.between_levels import Widening
from .intervals.calibration import FOLDS, calibrated, folds_of, thinned
from .intervals.left_out_levels import widenings
from .intervals.prediction_interval import LEAST_TESTS, LEVEL, check_level
from .law import FrictionLaw, Groups, LoadsLike, Weights, as_loads
from .measures import error_measures
from .model_card import LISTED_TESTS, UNTRAINED, DataFacts, Splits, Training, test_digests, versions
from .tangent import MeasuredPoints, Tangent, bends, out_of_fold, polynomial_columns

if TYPE_CHECKING:
    import plotly.graph_objects as go


class FrictionModel(FrictionLaw, Drawn):
    """Coefficient of friction as a function of the five tribological loads.

    Follows scikit-learn: `__init__` only stores, `fit` returns self, learned attributes end in ``_``,
    `sklearn.base.clone` gives an unfitted copy. A family implements `_fit`, `formula`, `formula_text`,
    `_learned` and `_restore`; a model with memory also `states` and `state_update`. A family whose `_fit` takes
    `sample_weight`, too, can be fitted with weights, and honours uncertain loads.

    Examples
    --------
    Every family fits and predicts alike. Here mu falls by 0.01 from 500 to 1000 MPa:

    >>> from friction_models import LinearFriction
    >>> loads = [[50, 20, 500, 0, 1], [50, 20, 1000, 0, 1], [50, 20, 1500, 0, 1]]
    >>> model = LinearFriction().fit(loads, [0.10, 0.09, 0.08])
    >>> model.predict([[50, 20, 750, 0, 1]]).round(6).tolist()
    [0.095]
    >>> model.domain_.to_dict()["sigma_n"]
    [500.0, 1500.0]

    A physical effect is added with a plus sign; the sum is a new model, to be fitted:

    >>> from friction_models.effects import Stribeck
    >>> (model + Stribeck()).name
    'linear + stribeck'
    """

    #: How the formula depends on the coefficients that a fit finds. `linear`: base and effects are solved in one step;
    #: `smooth`: `tangent` stands for the formula; `flexible`: the formula could take the shape of an effect, so that a
    #: polynomial stands in for it while effects are fitted.
    form: ClassVar[Literal["linear", "smooth", "flexible"]] = "flexible"
    #: Whether a fit weighs points by the stated uncertainties of their loads where no weights are given.
    honours_uncertain_loads: ClassVar[bool] = True

    #: Makes a model of a base and effects; `friction_models.families`, which stands above this module, enters it.
    _compose: ClassVar[Callable[[FrictionModel, list[Any]], FrictionModel]]

    # --- what a family implements beside the law --------------------------------------------------------

    @abstractmethod
    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups) -> None:
        """Learn from checked data; `groups` holds the test of each point, whole tests stay together.

        A further argument ``sample_weight: Weights = None`` receives the weight of each point, mean 1.
        """
        raise self._without("_fit", "learns from data")

    def tangent(self, data: MeasuredPoints) -> Tangent:
        """Return what may still change in the model where effects are fitted together with it.

        By default the model is taken as flexible: an offset and a straight share of each load may change, and a factor on
        predictions of each test by copies that did not see it. Beside these, smooth curves could follow what it follows in steps.
        """
        columns = [polynomial_columns(data.loads, 1), out_of_fold(self, data)]
        return Tangent(np.column_stack(columns), np.zeros(len(data.mu)), beside=bends(data.loads))

    # --- fit --------------------------------------------------------------------------------------------

    def fit(
        self,
        loads: LoadsLike,
        mu: npt.ArrayLike,
        groups: npt.ArrayLike | None = None,
        sample_weight: npt.ArrayLike | None = None,
    ) -> Self:
        """Learn mu from loads.

        Points whose loads state uncertainties (`TriboLoads.uncertainty`) weigh by their effective variance, see
        `models.effective_variance`; ``loads.without_uncertainty()`` weigh alike.

        Parameters
        ----------
        loads : TriboLoads or array_like, shape (n, 5)
            Loads in the order and units of the contract.
        mu : array_like, shape (n,)
            Measured coefficient of friction.
        groups : array_like, shape (n,), optional
            Test of each point, by default that of `loads`: data is split by whole tests only.
        sample_weight : array_like, shape (n,), optional
            Weight of each point; takes the place of what uncertain loads say.

        Raises
        ------
        InputError
            No points, unequal lengths, values outside the physical limits, a bad parameter, weights that are negative, all 0
            or that the family cannot take.

        Examples
        --------
        >>> from friction_models import ConstantFriction
        >>> model = ConstantFriction().fit([[50, 20, 500, 0, 1], [50, 20, 900, 0, 1]], [0.25, 0.75])
        >>> model.value
        0.5
        """
        return self._record_fit(*self._learn(loads, mu, groups, sample_weight))

    def _learn(
        self,
        loads: LoadsLike,
        mu: npt.ArrayLike,
        groups: npt.ArrayLike | None = None,
        sample_weight: npt.ArrayLike | None = None,
    ) -> tuple[TriboLoads, FloatArray, Groups, FitWeights]:
        """Learn mu from loads, as `fit` does, without a record; return what was learned from."""
        points, target, tests = self._checked(loads, mu, groups)
        weights = self._weights(points, target, tests, sample_weight)
        self._fit(points, target, tests, **weights.arguments)
        self.domain_ = Domain.of(points)
        return points, target, tests, weights

    def _checked(
        self, loads: LoadsLike, mu: npt.ArrayLike, groups: npt.ArrayLike | None
    ) -> tuple[TriboLoads, FloatArray, Groups]:
        """Return checked loads, mu and the test of each point; see `fit`."""
        points = as_loads(loads)
        target = check_column(np.asarray(mu), MEASURED_MU, "mu")
        if len(points) == 0 or len(points) != len(target):
            raise InputError(
                f"fit: {len(points)} loads and {len(target)} values of mu; allowed: equally many"
            )
        tests: Groups = points.test_id if groups is None else np.asarray(groups).astype(str)
        if tests is not None and len(tests) != len(target):
            raise InputError(f"fit: {len(tests)} groups for {len(target)} points; allowed: one a point")
        return points, target, tests

    @classmethod
    def takes_weights(cls) -> bool:
        """Whether the family can be fitted with weights."""
        return "sample_weight" in inspect.signature(cls._fit).parameters

    def _weights(
        self, points: TriboLoads, mu: FloatArray, tests: Groups, given: npt.ArrayLike | None
    ) -> FitWeights:
        """Return the weights of checked points: those given, or those of uncertain loads."""
        if given is not None:
            if not self.takes_weights():
                raise InputError(f"fit: the {self.family} family takes no sample_weight; allowed: None")
            return FitWeights(checked_weights(given, len(mu)))
        if points.uncertainty is None or not self.takes_weights() or not self.honours_uncertain_loads:
            return FitWeights(None)
        found = load_weights(points, mu, self._refit(mu, tests))
        return FitWeights(None if found is None else found.used, found)

    def _refit(self, mu: FloatArray, tests: Groups) -> Refit:
        """Return what fits copies of the model, or the polynomial that stands for a flexible one."""
        if self.form == "flexible":
            return by_polynomial(mu)

        def refit(places: Sequence[TriboLoads], weights: Weights) -> list[FloatArray]:
            copy = clone(self)
            copy._fit(places[0], mu, tests, **FitWeights(weights).arguments)
            copy.domain_ = Domain.of(places[0])
            return [copy.predict(p) for p in places]

        return refit

    def _record_fit(self, points: TriboLoads, mu: FloatArray, tests: Groups, weights: FitWeights) -> Self:
        """Record what the model was fitted to: facts, training error. An earlier interval is dropped."""
        self.training_ = self._training_facts(mu, tests)
        tied = not_told_apart(points.as_array()) if self.needed_loads else ()
        if tied:
            self.training_["data"]["not_told_apart"] = list(tied)
        if weights.by_loads is not None:
            self.training_["data"]["load_uncertainty"] = weights.by_loads.to_dict()
        self.errors_ = {}
        self.__dict__.pop("interval_", None)
        self.record_errors("train", error_measures(mu, self.predict(points), tests))
        return self

    def fit_frame(
        self,
        data: pd.DataFrame,
        tests: pd.DataFrame | None = None,
        info: Mapping[Any, Any] | None = None,
        load_uncertainty: bool = True,
    ) -> Self:
        """Learn from a table of points (columns of the contract and mu) and an optional table of tests.

        Columns `u_sigma_n`, `u_psi`, `u_T` with standard uncertainties of the loads are honoured (see `fit`) unless
        `load_uncertainty` is false.

        `info` is the provenance of the data set (`DataSet.info`), by default ``data.attrs``; its
        ``synthetic`` flag labels the card.

        Examples
        --------
        >>> from friction_models import ConstantFriction
        >>> data = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [500.0, 900.0], "mu": [0.25, 0.75]})
        >>> model = ConstantFriction().fit_frame(data)
        >>> model.value, model.training_["data"]["tests"]
        (0.5, 2)
        """
        if "mu" not in data.columns:
            raise missing_column("mu", data.columns)
        loads = TriboLoads.from_frame(data, tests)
        self.fit(loads if load_uncertainty else loads.without_uncertainty(), data["mu"].to_numpy())
        return self.record_data(data.attrs if info is None else info)

    def record_data(self, info: Mapping[Any, Any]) -> Self:
        """Record in the card where the training data come from; `info` as for `fit_frame`."""
        synthetic = info.get("synthetic")
        self.training_["data"]["synthetic"] = None if synthetic is None else bool(synthetic)
        self.training_["data"]["provenance"] = {
            str(k): v
            for k, v in info.items()
            if k != "synthetic" and (isinstance(v, (str, int)) or (isinstance(v, float) and np.isfinite(v)))
        }
        return self

    def record_tests(self, data: pd.DataFrame) -> Self:
        """Record the training tests as they stand in `data`, where the fit has seen them repaired."""
        known = self.training_["splits"].get("digests")
        if known and "test_id" in data.columns:
            given = test_digests(data["test_id"], data["mu"].to_numpy(dtype=np.float64))
            self.training_["splits"]["digests"] = {t: given.get(t, d) for t, d in known.items()}
        return self

    # --- prediction interval ---------------------------------------------------------------------------

    def calibrate(
        self,
        loads: LoadsLike,
        mu: npt.ArrayLike,
        groups: npt.ArrayLike | None = None,
        level: float = LEVEL,
        seed: int = 0,
    ) -> Self:
        """Give a fitted model its prediction interval, from the data it was fitted to.

        Parameters
        ----------
        loads, mu, groups
            As in `fit`; the tests must be known, at least four.
        level : float
            Share of the points of new tests that the interval is to hold, 0.5 to 0.999.
        seed : int
            Of the folds.

        Raises
        ------
        InputError
            The model is not fitted, the tests are not known or too few, a fold cannot be fitted.

        Examples
        --------
        >>> from friction_models import ConstantFriction
        >>> loads = [[50, 20, 100 * k, 0, 1] for k in range(1, 9)]
        >>> mu = [0.07, 0.09] * 4
        >>> tests = [f"test{k}" for k in range(8)]
        >>> model = ConstantFriction(0.08).fit(loads, mu, tests).calibrate(loads, mu, tests, level=0.8)
        >>> low, high = model.predict_interval([[50, 20, 500, 0, 1]])
        >>> round(float(low[0]), 6), round(float(high[0]), 6)
        (0.07, 0.09)
        """
        self.require_fitted()
        points, target, tests = self._checked(loads, mu, groups)
        check_level(level)
        count = 0 if tests is None else len(np.unique(tests))
        if tests is None or count < LEAST_TESTS:
            raise InputError(
                f"interval: {counted(count, 'test')}, allowed: at least {LEAST_TESTS} (points of one test are not independent)"
            )
        predicted, source = self.left_out(points, target, tests, FOLDS, seed)
        interval = calibrated(predicted, source, points, target, tests, self.domain, level)
        self.interval_ = replace(interval, between=self.between_levels(points, target, tests, predicted))
        return self

    def between_levels(
        self, loads: TriboLoads, mu: FloatArray, groups: npt.NDArray[np.str_], predicted: FloatArray
    ) -> tuple[Widening, ...]:
        """Return how much wider the interval is between the levels of a plan; see `widenings`.

        `predicted` is what `left_out` returned. A family that trains long overrides this.
        """
        rows = thinned(groups)
        return widenings(self, loads.take(rows), mu[rows], groups[rows], predicted[rows], self.domain)

    def left_out(
        self, loads: TriboLoads, mu: FloatArray, groups: npt.NDArray[np.str_], folds: int, seed: int
    ) -> tuple[FloatArray, str]:
        """Return mu of points predicted without their tests, shape (n,), NaN where there is none; and how, in words.

        The points are those the model was fitted to. A family that leaves tests out while it trains overrides this.
        """
        return folds_of(self, loads, mu, groups, folds, seed)

    # --- words and files ------------------------------------------------------------------------------

    def record_errors(self, split: str, measures: Mapping[str, float | None]) -> None:
        """Keep error measures of a split (``train``, ``test``, ...) for the card."""
        self.errors_ = getattr(self, "errors_", {}) | {split: dict(measures)}

    def view(self) -> go.Figure:
        """Return a figure of mu against each load, the others at the centre of the domain."""
        from .response_curves import response_curves

        return response_curves(self)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write `model.onnx`, `card.json`, `card.md` and `parameters.npz` into `folder`; return it."""
        from .saving import save_model

        return save_model(self, folder)

    def to_onnx(self, path: str | os.PathLike[str]) -> Path:
        """Write the model as a float64 ONNX file; return the path."""
        from .onnx_export import export

        return export(self, path)

    def __add__(self, effect: Any) -> FrictionModel:
        """Return an unfitted model of this family with a physical effect on top."""
        if not hasattr(FrictionModel, "_compose"):
            raise InputError(
                "model + effect: import friction_models.families first, which knows how to fit the sum"
            )
        return FrictionModel._compose(clone(self), [effect])

    def _training_facts(self, mu: FloatArray, groups: Groups) -> Training:
        digests = {} if groups is None else test_digests(groups, mu)
        splits: Splits = {"by": "whole tests", "train": len(digests)}
        if len(digests) <= LISTED_TESTS:
            splits |= {"train": list(digests), "digests": digests}
        facts: DataFacts = {**UNTRAINED, "points": len(mu), "tests": len(digests) or None, "provenance": {}}
        return {"data": facts, "splits": splits, "versions": versions()}
