"""Linear regression on the five loads."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ..expressions.ops import LoadColumns, Ops, Value
from ..expressions.parameters import stored_floats
from ..expressions.scaling import RESOLUTION, Scaling, centred
from ..loads import LOADS, FloatArray, TriboLoads
from ..models.base import FrictionModel
from ..models.law import Arrays, Groups, JsonObject, Learned, States, System, Weights
from ..models.tangent import MeasuredPoints, Tangent, polynomial_columns


class LinearFriction(FrictionModel):
    """mu = b0 + sum over the loads of b_j x_j, by least squares, weighted where points have weights.

    Attributes
    ----------
    intercept_ : float
    coef_ : ndarray, shape (5,)
        Per mm/s, degC, MPa, mm, 1. A load that does not vary in the data gets 0; loads that follow from one
        another but for rounding share their influence (least norm of the coefficients of standardised loads).

    Examples
    --------
    Friction that falls by 0.02 over 1000 MPa:

    >>> from friction_models import LinearFriction
    >>> loads = [[50, 20, 500, 0, 1], [50, 20, 1000, 0, 1], [50, 20, 1500, 0, 1]]
    >>> model = LinearFriction().fit(loads, [0.10, 0.09, 0.08])
    >>> round(float(model.coef_[2]), 9), round(model.intercept_, 9)
    (-2e-05, 0.11)
    """

    family: ClassVar[str] = "linear"
    form = "linear"

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights = None) -> None:
        matrix = loads.as_array()
        scaling = Scaling.of(matrix)
        standardised, target, centre, offset = centred(scaling.apply(matrix), mu, sample_weight)
        slopes, *_ = np.linalg.lstsq(standardised, target, rcond=RESOLUTION)
        slopes[np.ptp(matrix, axis=0) == 0.0] = 0.0  # not what rounding leaves of it
        self.coef_ = slopes / scaling.scale
        self.intercept_ = offset - float(self.coef_ @ (scaling.mean + centre * scaling.scale))

    def tangent(self, data: MeasuredPoints) -> Tangent:
        """Return a column of ones and the loads that vary."""
        return Tangent(polynomial_columns(data.loads, 1), np.zeros(len(data.mu)))

    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
        return x.matmul(x.concat(L.columns()), self.coef_[:, None], [self.intercept_])

    def formula_text(self) -> str:
        terms = (f"{b:+.4g} {q.name}/({q.unit})" for b, q in zip(self.coef_, LOADS))
        return f"mu = {self.intercept_:.5g} " + " ".join(terms)

    def _learned(self) -> Learned:
        return {}, {"coef": self.coef_, "intercept": np.array([self.intercept_])}

    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        self.coef_ = stored_floats(self.family, arrays, "coef", (len(LOADS),))
        self.intercept_ = float(stored_floats(self.family, arrays, "intercept", (1,))[0])
