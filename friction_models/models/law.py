"""`FrictionLaw`: a friction model as it is evaluated, saved and exported; `FrictionModel` adds how it learns."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Self, TypeAlias, cast

import numpy as np
import numpy.typing as npt
import pandas as pd
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.exceptions import NotFittedError

from ..common import InputError, unknown_name
from ..common.json_values import JsonObject
from ..expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ..expressions.parameters import Arrays
from ..loads import MU, FloatArray, TriboLoads, require_loads
from .domain import Domain
from .intervals.prediction_interval import PredictionInterval, as_columns, bounds
from .measures import Measures
from .model_card import UNTRAINED, ModelCard, Splits, Training, versions
from .variables import StateVariable, SystemVariable

Groups: TypeAlias = npt.NDArray[np.str_] | None
#: Weight of each point, mean 1; None: all weigh alike.
Weights: TypeAlias = FloatArray | None
#: Columns of the states of a model, and of its system variables by name; None means their start values.
States: TypeAlias = Sequence[Value] | None
System: TypeAlias = Mapping[str, Value] | None
#: What a model has learned: values as JSON holds them, and arrays.
Learned: TypeAlias = tuple[dict[str, object], dict[str, npt.NDArray[Any]]]
#: What `predict` takes: `TriboLoads`, a table with the contract's columns, or an array of shape (n, 5).
LoadsLike: TypeAlias = TriboLoads | pd.DataFrame | npt.ArrayLike


def as_loads(loads: LoadsLike) -> TriboLoads:
    """Return checked loads from `TriboLoads`, a table (by column names) or an array of shape (n, 5).

    Examples
    --------
    >>> as_loads([[50, 20, 500, 0, 1]]).sigma_n.tolist()
    [500.0]
    """
    if isinstance(loads, TriboLoads):
        return loads
    return TriboLoads.from_frame(loads) if isinstance(loads, pd.DataFrame) else TriboLoads.from_array(loads)


class UnfittedError(InputError, NotFittedError):
    """A model that has to be fitted first; scikit-learn knows it as its own `NotFittedError`."""


class FrictionLaw(RegressorMixin, BaseEstimator):
    """Coefficient of friction as a function of the five tribological loads, with what predicting and saving need.

    `FrictionModel` is the class to derive from: it adds `fit`.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> law = ConstantFriction(0.08)
    >>> law.name, law.is_fitted, law.formula_text()
    ('constant', True, 'mu = 0.08')
    """

    family: ClassVar[str] = ""

    # What a fit leaves; not there before it.
    #: Range of each load in the training data.
    domain_: Domain
    #: What the model was trained on: counts, tests, versions.
    training_: Training
    #: Error measures by the name of the split (``train``, ``test``, ...).
    errors_: dict[str, Measures]
    interval_: PredictionInterval

    # --- what a family implements ---------------------------------------------------------------------

    @abstractmethod
    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
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
        raise self._without("formula", "computes mu")

    @abstractmethod
    def formula_text(self) -> str:
        """Return the law in one line of plain text (with numbers where they are few)."""
        raise self._without("formula_text", "describes the law")

    @abstractmethod
    def _learned(self) -> Learned:
        """Return what was learned: JSON-able values and arrays."""
        raise self._without("_learned", "says what is saved")

    @abstractmethod
    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        """Restore what `_learned` returned; raise `InputError` if values or shapes do not fit."""
        raise self._without("_restore", "takes back what was saved")

    def _without(self, method: str, what: str) -> InputError:
        # scikit-learn's base classes have no metaclass that would refuse such a class when it is made.
        return InputError(f"{type(self).__name__}: the method {method}, which {what}, is not written")

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
        """Raise `InputError` if the model may only stand in a sum with effects (a negative constant, for example)."""

    # --- what every law offers --------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name for reports: the family, with its effects where it has some."""
        return self.family

    @property
    def is_fitted(self) -> bool:
        """Whether `predict` works."""
        return hasattr(self, "domain_")

    def require_fitted(self) -> None:
        """Raise `InputError` for a model that has not been fitted."""
        if not self.is_fitted:
            raise UnfittedError(f"the {self.family} model is not fitted; call fit or fit_frame first")

    @property
    def domain(self) -> Domain:
        """Range of each load that the model was trained on; the physical limits for a law that was not."""
        self.require_fitted()
        return getattr(self, "domain_", Domain.physical())

    def predict(self, loads: LoadsLike) -> FloatArray:
        """Return mu at `loads`, shape (n,): finite, never negative, also outside the domain.

        Raises
        ------
        InputError
            The model is not fitted, loads are not finite or outside the physical limits, or one was not measured that the
            model needs.

        Examples
        --------
        >>> from friction_models import ConstantFriction
        >>> ConstantFriction(0.08).predict([[50, 20, 500, 0, 1], [50, 80, 900, 5, 1.2]]).tolist()
        [0.08, 0.08]
        """
        points = self._evaluable(loads)
        x = NumpyOps()
        columns = LoadColumns.from_matrix(x, points.as_array()).without(x, self.domain.absent)
        return x.relu(self.formula(x, columns))[:, 0]

    def _evaluable(self, loads: LoadsLike) -> TriboLoads:
        """Return checked loads that the fitted model can be evaluated at; see `predict`."""
        self.require_fitted()
        points = as_loads(loads)
        require_loads(points, self.needed_loads, f"the {self.name} model")
        return points

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> pd.Series[float]:
        """Return mu for a table with the columns of the contract (mu itself is not needed): its rows, its index.

        Examples
        --------
        >>> from friction_models import ConstantFriction
        >>> points = pd.DataFrame({"sigma_n": [500.0, 900.0]}, index=["soft", "hard"])
        >>> ConstantFriction(0.08).predict_frame(points).to_dict()
        {'soft': 0.08, 'hard': 0.08}
        """
        return pd.Series(self.predict(TriboLoads.from_frame(data, tests)), index=data.index, name=MU.name)

    @property
    def interval(self) -> PredictionInterval | None:
        """The calibrated prediction interval, None without one."""
        return getattr(self, "interval_", None)

    @property
    def interval_level(self) -> float | None:
        """Level of the prediction interval, None without one."""
        return None if self.interval is None else self.interval.level

    def predict_interval(self, loads: LoadsLike, level: float | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the lower and upper bound of mu of a new test at `loads`, each of shape (n,).

        Never negative; outside the trained domain the interval widens, but promises no coverage.

        Raises
        ------
        InputError
            The model has no interval, or a level outside 0.5 to 0.999.
        """
        points = as_loads(loads)
        mu = self.predict(points)
        if self.interval is None:
            raise InputError(f"the {self.name} model has no prediction interval; call calibrate first")
        margin = self.interval.margins(points.as_array(), self.domain, level)
        return bounds(mu, margin)

    def predict_interval_frame(
        self, data: pd.DataFrame, tests: pd.DataFrame | None = None, level: float | None = None
    ) -> tuple[pd.Series[float], pd.Series[float]]:
        """Return the bounds of `predict_interval` for a table with the columns of the contract: its rows, its index."""
        return as_columns(*self.predict_interval(TriboLoads.from_frame(data, tests), level), data.index)

    @property
    def card(self) -> ModelCard:
        """The model card: law, data, splits, errors, domain, versions."""
        self.require_fitted()
        training = getattr(self, "training_", Training())
        splits: Splits = {**training.get("splits", {})}
        if hasattr(self, "validation_tests_"):
            splits["validation"] = list(self.validation_tests_)
        card: ModelCard = {
            "name": self.name,
            "family": self.family,
            "formula": self.formula_text(),
            "parameters": self._plain_params(),
            "data": {**training.get("data", UNTRAINED)},
            "splits": splits,
            "errors": dict(getattr(self, "errors_", {})),
            "domain": self.domain.to_dict(),
            "states": [s.to_dict() for s in self.states],
            "system_variables": [v.to_dict() for v in self.system_variables],
            "versions": training.get("versions", versions()),
        }
        if self.interval is not None:
            card["interval"] = self.interval.summary()
        history = getattr(self, "error_history_", [])
        if history:
            card["refinement"] = [dict(entry) for entry in history]
        return card

    def parts(self) -> Learned:
        """Return everything that makes the model: a JSON-able dict and arrays."""
        self.require_fitted()
        values, arrays = self._learned()
        content = {
            "family": self.family,
            "params": self._plain_params(),
            "learned": values,
            "domain": self.domain.to_dict(),
            "training": getattr(self, "training_", {}),
            "errors": dict(getattr(self, "errors_", {})),
        }
        if self.interval is not None:
            content["interval"] = self.interval.to_dict()
        return content, arrays

    @classmethod
    def from_parts(cls, content: JsonObject, arrays: Arrays) -> Self:
        """Build a model from `parts`.

        Raises InputError: a parameter is unknown, or shapes and values do not fit.
        """
        params = dict(content["params"])
        for name in params:
            if name not in cls._get_param_names():
                raise unknown_name("parameter", name, cls._get_param_names(), cls.family)
        model = cls(**params)
        return model._restored(content, arrays)

    def _restored(self, content: JsonObject, arrays: Arrays) -> Self:
        """Restore what `parts` returned."""
        self._restore(content["learned"], arrays)
        self.domain_ = Domain.from_dict(content["domain"])
        self.training_ = cast(Training, dict(content.get("training", {})))
        self.errors_ = {str(k): dict(v) for k, v in content.get("errors", {}).items()}
        if content.get("interval") is not None:
            self.interval_ = PredictionInterval.from_dict(content["interval"], self.domain_)
        return self

    def _plain_params(self) -> dict[str, object]:
        """Return the constructor's parameters as JSON holds them."""
        params = self.get_params(deep=False)
        return {k: list(v) if isinstance(v, tuple) else v for k, v in params.items()}
