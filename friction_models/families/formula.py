"""A law that is written as a formula: what a friction card holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from sklearn.base import clone

from ..common import InputError
from ..expressions.formula_text import Formula, read_formula
from ..expressions.ops import LoadColumns, Ops, Value
from ..expressions.parameters import check_number
from ..loads import LOAD_NAMES, MU, FloatArray, TriboLoads
from ..models.base import FrictionModel
from ..models.law import Arrays, Groups, JsonObject, Learned, States, System, Weights
from ..models.tangent import MeasuredPoints, Tangent

#: Most constants of a formula.
MAX_CONSTANTS = 30
_LARGE = 1e300


class FormulaFriction(FrictionModel):
    """mu = a formula of the five loads and of named constants, which a fit adapts.

    Outside the trained domain the law keeps its value at the edge: a published formula is not extrapolated.

    Parameters
    ----------
    law : str
        Such as ``mu0*(sigma_n/100)**n``; see `expressions.formula_text`.
    constants : mapping of str to float
        Start values of the constants, which stand in a model that is not fitted.

    Attributes
    ----------
    constants_ : dict of str to float
        Fitted constants.

    Examples
    --------
    >>> loads = [[50, 20, p, 0, 1] for p in (100, 200, 400)]
    >>> model = FormulaFriction("mu0*(sigma_n/100)**n", {"mu0": 0.1, "n": -0.1}).fit(loads, [0.2, 0.1, 0.05])
    >>> {k: round(v, 6) for k, v in model.constants_.items()}
    {'mu0': 0.2, 'n': -1.0}
    >>> model.predict([[50, 20, 800, 0, 1]]).round(6).tolist()
    [0.05]
    """

    family: ClassVar[str] = "formula"
    form = "smooth"

    def __init__(self, law: str = "mu0", constants: Mapping[str, float] | None = None) -> None:
        self.law = law
        self.constants = constants

    @property
    def name(self) -> str:
        """Name for reports: that of the card, for the law of one."""
        data = getattr(self, "training_", {}).get("data", {})
        card = data.get("provenance", {}).get("card")
        return f"card {card}" if card else self.family

    def _parsed(self) -> Formula:
        return read_formula(self.law, {*LOAD_NAMES, *self._start()}, self.family)

    def _start(self) -> dict[str, float]:
        given = {"mu0": 0.1} if self.constants is None else self.constants
        if not isinstance(given, Mapping) or len(given) > MAX_CONSTANTS:
            raise InputError(
                f"{self.family}: constants = {given!r:.60}, allowed: at most {MAX_CONSTANTS} names with numbers"
            )
        for name in given:
            if not isinstance(name, str) or not name.isidentifier() or name in LOAD_NAMES:
                raise InputError(f"{self.family}: constant {name!r:.40}, allowed: a name that is no load")
        return {n: check_number(self.family, n, v, -_LARGE, _LARGE) for n, v in given.items()}

    @property
    def needed_loads(self) -> tuple[str, ...]:
        """The loads that stand in the formula."""
        return tuple(n for n in LOAD_NAMES if n in self._parsed().names)

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights = None) -> None:
        from scipy.optimize import least_squares

        start = self._start()
        parsed = self._parsed()
        names = [n for n in start if n in parsed.names]
        columns = {n: loads.as_array()[:, k] for k, n in enumerate(LOAD_NAMES)}
        root = np.ones(len(mu)) if sample_weight is None else np.sqrt(sample_weight)
        size = np.array([abs(start[n]) or 1.0 for n in names])

        def misfit(z: FloatArray) -> FloatArray:
            values = {**start, **columns, **dict(zip(names, (z * size).tolist()))}
            with np.errstate(all="ignore"):
                found = np.broadcast_to(np.asarray(parsed.value(Ops(), values)), mu.shape)
            return np.asarray(root * np.where(np.isfinite(found), found - mu, 1e3))

        self.constants_ = dict(start)
        if names:
            best = least_squares(misfit, np.array([start[n] for n in names]) / size, max_nfev=400).x
            self.constants_ |= dict(zip(names, (best * size).tolist()))

    def tangent(self, data: MeasuredPoints) -> Tangent:
        """Return a column of ones on top of the law, which stays as it is where it is stated (a card).

        Before a fit there is no law: then its derivatives by the constants, around the fit to the data.
        """
        if self.is_fitted:
            return Tangent(np.ones((len(data.mu), 1)), self.predict(data.loads), fixed=True)
        fitted = clone(self).fit(data.loads, data.mu)
        mu = fitted.predict(data.loads)
        columns = [np.ones(len(mu))]
        for name, value in fitted.constants_.items():
            moved = clone(self).set_params(constants={**fitted.constants_, name: value * 1.001 + 1e-9})
            moved.constants_, moved.domain_ = moved._start(), fitted.domain_
            columns.append((moved.predict(data.loads) - mu) / max(abs(value) * 1e-3, 1e-9))
        return Tangent(np.column_stack(columns), mu)

    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
        inside = {}
        for name, column, low, high in zip(LOAD_NAMES, L.columns(), self.domain.lower, self.domain.upper):
            inside[name] = x.minimum(x.maximum(column, low), high)
        mu = self._parsed().value(x, {**self.constants_, **inside})
        if isinstance(mu, float):
            return x.constant(mu, L.v_rel)
        return x.minimum(mu, MU.upper)

    def formula_text(self) -> str:
        used = self._parsed().names
        constants = ", ".join(f"{n} = {v:.4g}" for n, v in self.constants_.items() if n in used)
        return f"mu = {self.law}" + (f" with {constants}" if constants else "")

    def _learned(self) -> Learned:
        return {"constants": self.constants_}, {}

    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        stored = values["constants"]
        if not isinstance(stored, dict) or set(stored) != set(self._start()):
            raise InputError(f"{self.family}: constants {stored!r:.60}, allowed: {', '.join(self._start())}")
        self.constants_ = {n: check_number(self.family, n, v, -_LARGE, _LARGE) for n, v in stored.items()}
        self._parsed()
