"""The constant coefficient of friction: the baseline of forming simulation."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from ..common import InputError
from ..expressions.ops import LoadColumns, Ops, Value
from ..expressions.parameters import check_number
from ..loads import MU, FloatArray, TriboLoads
from ..models.base import FrictionModel
from ..models.law import Arrays, Groups, JsonObject, Learned, States, System, Weights
from ..models.tangent import MeasuredPoints, Tangent


class ConstantFriction(FrictionModel):
    """mu = constant.

    Parameters
    ----------
    mu : float, optional
        The value; then the model predicts without a fit, and a fit changes only its domain. Common
        in simulation: 0.08 (median of 64 literature sources) and 0.04 (average of 13
        zinc-phosphate-free lubricants, ICFG 2023). None: the mean of the training data.

    Examples
    --------
    >>> from friction_models import ConstantFriction
    >>> ConstantFriction(0.08).predict([[50, 20, 500, 0, 1]]).tolist()
    [0.08]

    Without a value, the mean of the training data:

    >>> loads = [[50, 20, 500, 0, 1], [50, 20, 900, 0, 1]]
    >>> ConstantFriction().fit(loads, [0.25, 0.75]).formula_text()
    'mu = 0.5'
    """

    family: ClassVar[str] = "constant"
    form = "linear"

    def __init__(self, mu: float | None = None) -> None:
        self.mu = mu

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights = None) -> None:
        self.mean_ = float(np.average(mu, weights=sample_weight)) if self.mu is None else self.value

    @property
    def value(self) -> float:
        """The coefficient of friction.

        Raises
        ------
        InputError
            Not a number within the limits of mu, or neither given nor fitted.
        """
        if self.mu is not None:
            return check_number(self.family, "mu", self.mu, MU.lower, MU.upper)
        self.require_fitted()
        return self.mean_

    @property
    def is_fitted(self) -> bool:
        return self.mu is not None or hasattr(self, "mean_")

    @property
    def needed_loads(self) -> tuple[str, ...]:
        """None: the value is the same at all loads."""
        return ()

    def tangent(self, data: MeasuredPoints) -> Tangent:
        """Return a column of ones; a given value stays as it is."""
        level = np.ones((len(data.mu), 1))
        if self.mu is None:
            return Tangent(level, np.zeros(len(data.mu)))
        return Tangent(level, self.predict(data.loads), fixed=True)

    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
        return x.constant(self.value, L.v_rel)

    def formula_text(self) -> str:
        return f"mu = {self.value:.6g}"

    def _learned(self) -> Learned:
        return {"mu": self.value}, {}

    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        # As the base of a sum it may be negative: effects carry the level then. Alone it may not, see `check_alone`.
        value = check_number(self.family, "mu", values["mu"], -math.inf, math.inf)
        if self.mu is not None and self.value != value:
            raise InputError(f"constant: mu is {self.mu!r} as a parameter and {value!r} as learned")
        self.mean_ = value

    def check_alone(self) -> None:
        check_number(self.family, "mu", self.value, MU.lower, MU.upper)
