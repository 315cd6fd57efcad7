"""Polynomial regression with interactions (second order by default)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import ClassVar

import numpy as np

from ..expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ..expressions.parameters import check_integer, check_number, stored_floats
from ..expressions.scaling import RESOLUTION, Scaling, centred
from ..loads import LOAD_NAMES, FloatArray, TriboLoads
from ..models.base import FrictionModel
from ..models.law import Arrays, Groups, JsonObject, Learned, States, System, Weights
from ..models.tangent import MeasuredPoints, Tangent, polynomial_columns

MAX_DEGREE = 4


@dataclass(eq=False, repr=False)
class PolynomialFriction(FrictionModel):
    """mu = polynomial of the five standardised loads, all products up to `degree`.

    Parameters
    ----------
    degree : int
        1 to 4; 2 is the full second order with interactions (21 coefficients).
    ridge : float
        Penalty on the squared coefficients of standardised terms, relative to the number of points.

    Attributes
    ----------
    coef_ : ndarray, shape (terms,)
        Coefficients of `terms`, in standardised loads.
    intercept_ : float

    Examples
    --------
    >>> from friction_models import PolynomialFriction
    >>> len(PolynomialFriction().terms)
    20

    A parabola of the speed, which no straight line follows:

    >>> loads = [[v, 20, 500, 0, 1] for v in (0, 10, 20, 30, 40)]
    >>> mu = [0.05 + 0.0001 * (v - 20) ** 2 for v in (0, 10, 20, 30, 40)]
    >>> model = PolynomialFriction(degree=2, ridge=0).fit(loads, mu)
    >>> model.predict([[20, 20, 500, 0, 1], [35, 20, 500, 0, 1]]).round(6).tolist()
    [0.05, 0.0725]
    """

    family: ClassVar[str] = "polynomial"
    form = "linear"

    degree: int = 2
    ridge: float = 1e-6

    @property
    def terms(self) -> list[tuple[int, ...]]:
        """The products: tuples of load indices, e.g. (0, 2) for v_rel * sigma_n."""
        degree = check_integer(self.family, "degree", self.degree, 1, MAX_DEGREE)
        indices = range(len(LOAD_NAMES))
        return [t for d in range(1, degree + 1) for t in combinations_with_replacement(indices, d)]

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights = None) -> None:
        ridge = check_number(self.family, "ridge", self.ridge, 0.0, 1e6)
        matrix = loads.as_array()
        self.scaling_ = Scaling.of(matrix)
        terms = self._features(NumpyOps(), [c[:, None] for c in matrix.T])
        # The terms are standardised once more, so that the ridge treats all alike.
        second = Scaling.of(terms)
        design, target, centre, offset = centred(second.apply(terms), mu, sample_weight)
        normal = design.T @ design / len(mu) + ridge * np.eye(design.shape[1])
        slopes, *_ = np.linalg.lstsq(normal, design.T @ target / len(mu), rcond=RESOLUTION**2)
        self.coef_ = slopes / second.scale
        self.intercept_ = offset - float(self.coef_ @ (second.mean + centre * second.scale))

    def _features(self, x: Ops, columns: list[Value]) -> Value:
        z = self.scaling_.columns(x, columns)
        products: dict[tuple[int, ...], Value] = {}
        for term in self.terms:
            products[term] = z[term[0]] if len(term) == 1 else products[term[:-1]] * z[term[-1]]
        return x.concat(list(products.values()))

    def tangent(self, data: MeasuredPoints) -> Tangent:
        """Return the products of the loads that vary."""
        return Tangent(polynomial_columns(data.loads, int(self.degree)), np.zeros(len(data.mu)))

    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
        return x.matmul(self._features(x, L.columns()), self.coef_[:, None], [self.intercept_])

    def formula_text(self) -> str:
        order = np.argsort(-np.abs(self.coef_))[:6]
        terms = self.terms
        shown = " ".join(f"{self.coef_[i]:+.3g} {'*'.join(LOAD_NAMES[j] for j in terms[i])}" for i in order)
        rest = len(terms) - len(order)
        more = f" and {rest} more terms" if rest else ""
        return f"mu = {self.intercept_:.4g} {shown}{more}, loads standardised"

    def _learned(self) -> Learned:
        return {}, {
            "coef": self.coef_,
            "intercept": np.array([self.intercept_]),
            **self.scaling_.arrays(),
        }

    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        check_number(self.family, "ridge", self.ridge, 0.0, 1e6)
        self.coef_ = stored_floats(self.family, arrays, "coef", (len(self.terms),))
        self.intercept_ = float(stored_floats(self.family, arrays, "intercept", (1,))[0])
        self.scaling_ = Scaling.restore(self.family, arrays, len(LOAD_NAMES))
