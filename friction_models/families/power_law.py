"""The multiplicative power law: a grey box with one exponent a load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from sklearn.base import clone

from ..expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ..expressions.parameters import check_number, stored_floats
from ..expressions.scaling import Scaling, unresolved
from ..loads import MU, FloatArray, TriboLoads
from ..models.base import FrictionModel
from ..models.law import Arrays, Groups, JsonObject, Learned, States, System, Weights
from ..models.tangent import Beside, MeasuredPoints, Tangent

#: References that make the factors numbers of order one: mm/s, K, MPa, mm.
V_REF, T_REF, SIGMA_REF, SD_REF = 100.0, 100.0, 1000.0, 10.0
NAMES = ("log_C", "b_v_rel", "e_T", "a_sigma_n", "d_sd", "c_psi")
#: Exponents beyond this are artefacts of too little variation in the data.
MAX_EXPONENT = 5.0
#: Limits of the offsets, each in the unit of its load.
OFFSETS = (1e-6, 1e6)
#: The offset of the pressure [MPa] where pressures are those of forming, and its share of the median where they are lower.
USUAL_OFFSET, SHARE = 100.0, 0.2


@dataclass(eq=False, repr=False)
class PowerLawFriction(FrictionModel):
    """mu = C (sigma_n + s0)^a (v_rel + v0)^b (sd + d0)^d psi^c exp(e T), in reference units.

    The offsets keep the law regular at zero loads. The fit minimises the squared error of mu itself,
    starting from the log-linear solution, so that scatter at small mu does not dominate.

    Parameters
    ----------
    sigma_offset : float, optional
        s0 [MPa], above 0. By default it follows the data: a fifth of their median pressure, at most 100 MPa. That is
        100 MPa in forming; far below, on a pin-on-disc, so large an offset would hide the pressure.
    v_offset, sd_offset : float
        v0 [mm/s], d0 [mm]; above 0.

    Attributes
    ----------
    sigma_offset_ : float
        s0 as given or found.
    coef_ : ndarray, shape (6,)
        log C and the exponents in the order of `NAMES`; 0 for a load that does not vary in the data.
        mu = exp(log C) ((v_rel + v0) / 100)^b exp(e T / 100) ((sigma_n + s0) / 1000)^a ((sd + d0) / 10)^d psi^c.

    Notes
    -----
    Multiplicative power laws of pressure, speed and surface expansion with an exponential of
    temperature are common grey boxes of lubricated metal forming. mu is limited to 10, the physical
    limit of the contract.

    Examples
    --------
    Friction that is halved whenever the surface doubles, mu = 0.2 / psi:

    >>> from friction_models import PowerLawFriction
    >>> loads = [[50, 20, 500, 0, psi] for psi in (1, 2, 4, 8)]
    >>> model = PowerLawFriction().fit(loads, [0.2, 0.1, 0.05, 0.025])
    >>> round(float(model.coef_[5]), 4)
    -1.0
    >>> model.predict([[50, 20, 500, 0, 5]]).round(5).tolist()
    [0.04]
    """

    family: ClassVar[str] = "power_law"
    form = "smooth"

    sigma_offset: float | None = None
    v_offset: float = 1.0
    sd_offset: float = 1.0

    def _features(self, x: Ops, L: LoadColumns) -> list[Value]:
        """Return the columns that the exponents multiply in the logarithm of mu."""
        v0, s0, d0 = self.offsets()
        return [
            x.log((L.v_rel + v0) * (1.0 / V_REF)),
            L.T * (1.0 / T_REF),
            x.log((L.sigma_n + s0) * (1.0 / SIGMA_REF)),
            x.log((L.sd + d0) * (1.0 / SD_REF)),
            x.log(L.psi),
        ]

    def offsets(self) -> tuple[float, float, float]:
        """Return v0, s0 and d0 of a fitted model, checked."""
        return (
            check_number(self.family, "v_offset", self.v_offset, *OFFSETS),
            check_number(self.family, "sigma_offset", self.sigma_offset_, *OFFSETS),
            check_number(self.family, "sd_offset", self.sd_offset, *OFFSETS),
        )

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights = None) -> None:
        from scipy.optimize import lsq_linear

        self.sigma_offset_ = offset_for(loads.sigma_n) if self.sigma_offset is None else self.sigma_offset
        x = NumpyOps()
        features = self._features(x, LoadColumns.from_matrix(x, loads.as_array()))
        design = np.concatenate([np.ones((len(mu), 1)), *features], axis=1)
        varies = np.ptp(design, axis=0) > 1e-9
        varies[0] = True
        used = design[:, varies]
        limit = np.full(used.shape[1], MAX_EXPONENT)
        limit[0] = 50.0
        floor = max(1e-3 * float(np.mean(mu)), 1e-9)
        root = np.ones(len(mu)) if sample_weight is None else np.sqrt(sample_weight)
        coef = lsq_linear(root[:, None] * used, root * np.log(np.maximum(mu, floor)), (-limit, limit)).x
        coef = least_norm(used, refine_exponential(used, mu, coef, limit, root))
        self.coef_ = np.zeros(len(NAMES))
        self.coef_[varies] = coef

    def tangent(self, data: MeasuredPoints) -> Tangent:
        """Return the law's derivatives by log C and the exponents, around its fit to the data.

        ``d mu / d exponent = mu ln(load + offset)``. The logarithms are centred and scaled, which changes the
        coefficients, but not what the columns can follow. Other offsets would bend mu along their loads: the derivative is
        ``exponent mu / (load + offset)``.
        """
        fitted = clone(self).fit(data.loads, data.mu)
        mu = fitted.predict(data.loads)
        loads = data.loads
        v0, s0, d0 = fitted.offsets()
        logs = [
            np.log(loads.v_rel + v0),
            loads.T,
            np.log(loads.sigma_n + s0),
            np.log(loads.sd + d0),
            np.log(loads.psi),
        ]
        columns = [mu, *(mu * (f - f.mean()) / max(float(f.std()), 1e-12) for f in logs)]
        offsets = (
            Beside("another v_offset", mu / (loads.v_rel + v0)),
            Beside("another sigma_offset", mu / (loads.sigma_n + s0)),
            Beside("another sd_offset", mu / (loads.sd + d0)),
        )
        return Tangent(np.column_stack(columns), mu, beside=offsets)

    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
        total = x.matmul(x.concat(self._features(x, L)), self.coef_[1:, None], self.coef_[:1])
        return x.exp(x.minimum(total, float(np.log(MU.upper))))

    def formula_text(self) -> str:
        log_c, b, e, a, d, c = self.coef_
        return (
            f"mu = {np.exp(log_c):.4g} ((v_rel + {self.v_offset:g})/{V_REF:g})^{b:.4g} exp({e:.4g} T/{T_REF:g}) "
            f"((sigma_n + {self.sigma_offset_:g})/{SIGMA_REF:g})^{a:.4g} "
            f"((sd + {self.sd_offset:g})/{SD_REF:g})^{d:.4g} psi^{c:.4g}"
        )

    def _learned(self) -> Learned:
        return {"sigma_offset": self.sigma_offset_}, {"coef": self.coef_}

    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        # Models of before have it as a parameter only.
        self.sigma_offset_ = values.get("sigma_offset", self.sigma_offset)
        self.offsets()
        self.coef_ = stored_floats(self.family, arrays, "coef", (len(NAMES),))


def offset_for(sigma_n: FloatArray) -> float:
    """Return the offset s0 [MPa] for data of these pressures; what is not in contact does not count."""
    loaded = sigma_n[sigma_n > 0.0]
    share = SHARE * float(np.median(loaded)) if loaded.size else USUAL_OFFSET
    return float(np.clip(share, OFFSETS[0], USUAL_OFFSET))


def least_norm(design: FloatArray, coef: FloatArray) -> FloatArray:
    """Take out of the coefficients what the columns of a design, the first one constant, do not tell apart.

    The coefficients of standardised columns then have the least norm; what they predict for the design stays.
    """
    columns = design[:, 1:]
    scaling = Scaling.of(columns)
    directions = unresolved(scaling.apply(columns))
    if not directions.size:
        return coef
    change = directions @ (directions.T @ (coef[1:] * scaling.scale)) / scaling.scale
    return np.r_[coef[0] + change @ scaling.mean, coef[1:] - change]


def refine_exponential(
    design: FloatArray, mu: FloatArray, start: FloatArray, limit: FloatArray, root: FloatArray
) -> FloatArray:
    """Minimise ``sum (root (exp(design @ coef) - mu))^2`` within ``|coef| <= limit`` (Levenberg-Marquardt).

    `design` has the shape (n, k), `mu` and the roots of the weights `root` (n,); `start`, `limit` and what is returned have the
    shape (k,).
    """

    def predicted(coef: FloatArray) -> FloatArray:
        return np.exp(np.minimum(design @ coef, np.log(MU.upper)))

    coef, damping = start, 1e-3
    fit = predicted(coef)
    cost = float(np.sum((root * (fit - mu)) ** 2))
    for _ in range(100):
        jacobian = design * (root * fit)[:, None]
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ (root * (mu - fit))
        step = np.linalg.lstsq(normal + damping * np.diag(np.diag(normal) + 1e-30), gradient, rcond=None)[0]
        trial = np.clip(coef + step, -limit, limit)
        trial_fit = predicted(trial)
        trial_cost = float(np.sum((root * (trial_fit - mu)) ** 2))
        if trial_cost <= cost:
            done = bool(np.max(np.abs(trial - coef)) < 1e-12)
            coef, fit, cost, damping = trial, trial_fit, trial_cost, max(damping * 0.1, 1e-15)
            if done:
                break
        else:
            damping *= 10.0
            if damping > 1e12:
                break
    return coef
