"""`FrictionModel`: what every friction model offers, whatever its family."""

from __future__ import annotations

import os
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeAlias

import numpy as np
import numpy.typing as npt
import pandas as pd
from sklearn.base import BaseEstimator

from ..common import InputError, unknown_name
from ..expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ..expressions.scaling import not_told_apart
from ..loads import MEASURED_MU, FloatArray, TriboLoads, check_column, missing_column, require_loads
from .calibrated import Calibrated
from .domain import Domain
from .intervals import PredictionInterval
from .measures import error_measures
from .seen import test_digests
from .variables import StateVariable, SystemVariable

if TYPE_CHECKING:
    import plotly.graph_objects as go

Groups: TypeAlias = npt.NDArray[np.str_] | None
#: What `predict` takes: `TriboLoads`, a table with the contract's columns, or an array of shape (n, 5).
LoadsLike: TypeAlias = TriboLoads | pd.DataFrame | npt.ArrayLike
#: Most test names that a card lists; above that it only counts them.
LISTED_TESTS = 1000


def as_loads(loads: LoadsLike) -> TriboLoads:
    """Return checked loads from `TriboLoads`, a table (by column names) or an array of shape (n, 5)."""
    if isinstance(loads, TriboLoads):
        return loads
    return TriboLoads.from_frame(loads) if isinstance(loads, pd.DataFrame) else TriboLoads.from_array(loads)


class FrictionModel(Calibrated, BaseEstimator):
    """Coefficient of friction as a function of the five tribological loads.

    Follows scikit-learn: `__init__` only stores, `fit` returns self, learned attributes end in ``_``,
    `sklearn.base.clone` gives an unfitted copy. A family implements `_fit`, `formula`, `formula_text`,
    `_learned` and `_restore`; a model with memory also `states` and `state_update`.

    Attributes
    ----------
    domain_ : Domain
        Range of each load in the training data.
    training_ : dict
        What it was trained on: counts, tests, versions.
    errors_ : dict
        Error measures by the name of the split (``train``, ``test``, ...).
    """

    family: ClassVar[str] = ""

    # --- what a family implements ---------------------------------------------------------------------

    @abstractmethod
    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups) -> None:
        """Learn from checked data; `groups` holds the test of each point, whole tests stay together."""

    @abstractmethod
    def formula(
        self,
        x: Ops,
        L: LoadColumns,
        S: Sequence[Value] | None = None,
        system: Mapping[str, Value] | None = None,
    ) -> Value:
        """Return raw mu [n, 1], before the clip at 0, with either back end.

        Parameters
        ----------
        x : Ops
            Back end.
        L : LoadColumns
            The five loads, each [n, 1].
        S : sequence of Value, optional
            One column [n, 1] a state, in the order of `states`; None means the start values.
        system : mapping, optional
            System variables by name, each [n, 1] or [1, 1]; a missing one takes its start value.
        """

    @abstractmethod
    def formula_text(self) -> str:
        """Return the law in one line of plain text (with numbers where they are few)."""

    @abstractmethod
    def _learned(self) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
        """Return what was learned: JSON-able values and arrays."""

    @abstractmethod
    def _restore(self, values: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Take back what `_learned` returned; raise `InputError` where it does not fit."""

    @property
    def states(self) -> tuple[StateVariable, ...]:
        """Internal states, one set a material contact point; none for a model without memory."""
        return ()

    @property
    def system_variables(self) -> tuple[SystemVariable, ...]:
        """System variables that the model depends on."""
        return ()

    def state_update(
        self, x: Ops, L: LoadColumns, S: Sequence[Value], mu: Value, dt: Value
    ) -> tuple[list[Value], list[Value] | None]:
        """Advance the states by `dt` [s] under the raw loads and the model's own (clipped) `mu`.

        Returns
        -------
        state_next : list of Value
            One column [n, 1] a state.
        state_der : list of Value or None
            Time derivatives [unit/s], where all states obey an ODE.
        """
        return [], None

    @property
    def needed_loads(self) -> tuple[str, ...]:
        """The loads without which the model cannot be evaluated: those it was given in training."""
        return self.domain.measured

    def check_alone(self) -> None:
        """Raise `InputError` where what was learned is no friction by itself, only as a part of a sum."""

    # --- what every model does ------------------------------------------------------------------------

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the internal states."""
        return tuple(s.name for s in self.states)

    def fit(self, loads: LoadsLike, mu: npt.ArrayLike, groups: npt.ArrayLike | None = None) -> Self:
        """Learn mu from loads.

        Parameters
        ----------
        loads : TriboLoads or array_like, shape (n, 5)
            Loads in the order and units of the contract.
        mu : array_like, shape (n,)
            Measured coefficient of friction.
        groups : array_like, shape (n,), optional
            Test of each point, by default that of `loads`: data is split by whole tests only.

        Raises
        ------
        InputError
            No points, unequal lengths, values outside the physical limits, a bad parameter.
        """
        points, target, tests = self._checked(loads, mu, groups)
        self._fit(points, target, tests)
        return self._record_fit(points, target, tests)

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

    def _record_fit(self, points: TriboLoads, mu: FloatArray, tests: Groups) -> Self:
        """Note what the model has just been fitted to: facts, domain, training error; an interval is gone."""
        self.training_: dict[str, Any] = self._training_facts(mu, tests)
        self.domain_ = Domain.of(points)
        tied = not_told_apart(points.as_array()) if self.needed_loads else ()
        if tied:
            self.training_["data"]["not_told_apart"] = list(tied)
        self.errors_: dict[str, dict[str, float]] = {}
        self.__dict__.pop("interval_", None)
        self.record_errors("train", error_measures(mu, self.predict(points), tests))
        return self

    def fit_frame(
        self, data: pd.DataFrame, tests: pd.DataFrame | None = None, info: Mapping[str, Any] | None = None
    ) -> Self:
        """Learn from a table of points (columns of the contract and mu) and an optional table of tests.

        `info` is the provenance of the data set (`DataSet.info`), by default ``data.attrs``; its
        ``synthetic`` flag labels the card.
        """
        if "mu" not in data.columns:
            raise missing_column("mu", data.columns)
        self.fit(TriboLoads.from_frame(data, tests), data["mu"].to_numpy())
        return self.record_data(data.attrs if info is None else info)

    def record_data(self, info: Mapping[Any, Any]) -> Self:
        """Let the card say where the data come from that the model is fitted to; `info` as for `fit_frame`."""
        self.training_["data"] |= data_facts(info)
        return self

    def record_tests(self, data: pd.DataFrame) -> Self:
        """Let the card know the tests it was trained on as they stand in `data`, where a fit saw them repaired."""
        known = self.training_["splits"].get("digests")
        if known and "test_id" in data.columns:
            given = test_digests(data["test_id"], data["mu"].to_numpy(dtype=np.float64))
            self.training_["splits"]["digests"] = {t: given.get(t, d) for t, d in known.items()}
        return self

    def predict(self, loads: LoadsLike) -> FloatArray:
        """Return mu at `loads`, shape (n,): finite, never negative, also outside the domain.

        Raises
        ------
        InputError
            The model is not fitted, loads are not finite or outside the physical limits, or one was not measured that the
            model needs.
        """
        points = self._evaluable(loads)
        x = NumpyOps()
        columns = LoadColumns(*(c[:, None] for c in points.as_array().T)).without(x, self.domain.absent)
        return x.relu(self.formula(x, columns))[:, 0]

    def _evaluable(self, loads: LoadsLike) -> TriboLoads:
        """Return checked loads that the fitted model can be evaluated at; see `predict`."""
        points = as_loads(loads)
        self.require_fitted()
        require_loads(points, self.needed_loads, f"the {self.name} model")
        return points

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> FloatArray:
        """Return mu for a table with the columns of the contract (mu itself is not needed)."""
        return self.predict(TriboLoads.from_frame(data, tests))

    # --- words and files ------------------------------------------------------------------------------

    @property
    def is_fitted(self) -> bool:
        """Whether `predict` works."""
        return hasattr(self, "domain_")

    def require_fitted(self) -> None:
        """Raise `InputError` for a model that has not been fitted."""
        if not self.is_fitted:
            raise InputError(f"the {self.family} model is not fitted; call fit or fit_frame first")

    @property
    def domain(self) -> Domain:
        """Range of each load that the model was trained on."""
        self.require_fitted()
        return getattr(self, "domain_", None) or Domain.physical()

    @property
    def name(self) -> str:
        """Name for reports: the family, with its effects where it has some."""
        return self.family

    @property
    def card(self) -> dict[str, Any]:
        """The model card: law, data, splits, errors, domain, versions."""
        from .model_card import build_card

        return build_card(self)

    def record_errors(self, split: str, measures: Mapping[str, float]) -> None:
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
        from sklearn.base import clone

        from ..effects import make_effect
        from ..families.composed import ComposedFriction

        # A misspelt effect is refused here, not at the fit.
        make_effect(effect)
        return ComposedFriction(clone(self), [effect])

    def parts(self) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
        """Return everything that makes the model: a JSON-able dict and arrays."""
        self.require_fitted()
        values, arrays = self._learned()
        content = {
            "family": self.family,
            "params": self._plain_params(),
            "learned": values,
            "domain": self.domain.to_dict(),
            "training": getattr(self, "training_", {}),
            "errors": getattr(self, "errors_", {}),
        }
        if self.interval is not None:
            content["interval"] = self.interval.to_dict()
        return content, arrays

    @classmethod
    def from_parts(cls, content: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> Self:
        """Build a model from `parts`.

        Raises
        ------
        InputError
            A parameter is unknown, or shapes and values do not fit.
        """
        params = dict(content["params"])
        for name in params:
            if name not in cls._get_param_names():
                raise unknown_name("parameter", name, cls._get_param_names(), cls.family)
        model = cls(**params)
        return model._restored(content, arrays)

    def _restored(self, content: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> Self:
        """Take back what `parts` returned."""
        self._restore(content["learned"], arrays)
        self.domain_ = Domain.from_dict(content["domain"])
        self.training_ = dict(content.get("training", {}))
        self.errors_ = {str(k): dict(v) for k, v in content.get("errors", {}).items()}
        if content.get("interval") is not None:
            self.interval_ = PredictionInterval.from_dict(content["interval"], self.domain_)
        return self

    def _plain_params(self) -> dict[str, Any]:
        """Return the constructor's parameters as JSON holds them."""
        params = self.get_params(deep=False)
        return {k: list(v) if isinstance(v, tuple) else v for k, v in params.items()}

    def _training_facts(self, mu: FloatArray, groups: Groups) -> dict[str, Any]:
        from .model_card import versions

        digests = {} if groups is None else test_digests(groups, mu)
        splits: dict[str, Any] = {"by": "whole tests", "train": len(digests)}
        if len(digests) <= LISTED_TESTS:
            splits |= {"train": list(digests), "digests": digests}
        facts: dict[str, Any] = {
            "points": len(mu),
            "tests": len(digests) or None,
            "synthetic": None,
            "provenance": {},
        }
        return {"data": facts, "splits": splits, "versions": versions()}


def data_facts(info: Mapping[Any, Any]) -> dict[str, Any]:
    """Return what a card says of a data set: the synthetic label and plain provenance."""
    synthetic = info.get("synthetic")
    plain = {
        str(k): v
        for k, v in info.items()
        if k != "synthetic" and (isinstance(v, (str, int)) or (isinstance(v, float) and np.isfinite(v)))
    }
    return {"synthetic": None if synthetic is None else bool(synthetic), "provenance": plain}
