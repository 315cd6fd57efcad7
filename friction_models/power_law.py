"""The multiplicative power law: a grey box with one exponent a load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from .base import FrictionModel, Groups
from .loads import MU, FloatArray, TriboLoads
from .ops import LoadColumns, NumpyOps, Ops, Value
from .parameters import check_number, stored_floats

#: References that make the factors numbers of order one: mm/s, K, MPa, mm.
V_REF, T_REF, SIGMA_REF, SD_REF = 100.0, 100.0, 1000.0, 10.0
NAMES = ("log_C", "b_v_rel", "e_T", "a_sigma_n", "d_sd", "c_psi")
#: Exponents beyond this are artefacts of too little variation in the data.
MAX_EXPONENT = 5.0


class PowerLawFriction(FrictionModel):
    """mu = C (sigma_n + s0)^a (v_rel + v0)^b (sd + d0)^d psi^c exp(e T), in reference units.

    The offsets keep the law regular at zero loads. The fit minimises the squared error of mu itself,
    starting from the log-linear solution, so that scatter at small mu does not dominate.

    Parameters
    ----------
    sigma_offset, v_offset, sd_offset : float
        s0 [MPa], v0 [mm/s], d0 [mm]; above 0.

    Attributes
    ----------
    coef_ : ndarray, shape (6,)
        log C and the exponents in the order of `NAMES`; 0 for a load that does not vary in the data.
        mu = exp(log C) ((v_rel + v0) / 100)^b exp(e T / 100) ((sigma_n + s0) / 1000)^a ((sd + d0) / 10)^d psi^c.

    Notes
    -----
    Multiplicative power laws of pressure, speed and surface expansion with an exponential of
    temperature are common grey boxes of lubricated metal forming. mu is limited to 10, the physical
    limit of the contract.
    """

    family: ClassVar[str] = "power_law"

    def __init__(self, sigma_offset: float = 100.0, v_offset: float = 1.0, sd_offset: float = 1.0) -> None:
        self.sigma_offset = sigma_offset
        self.v_offset = v_offset
        self.sd_offset = sd_offset

    def _features(self, x: Ops, L: LoadColumns) -> list[Value]:
        """Return the columns that the exponents multiply in the logarithm of mu."""
        v0, s0, d0 = (
            check_number(self.family, n, getattr(self, n), 1e-6, 1e6)
            for n in ("v_offset", "sigma_offset", "sd_offset")
        )
        return [
            x.log((L.v_rel + v0) * (1.0 / V_REF)),
            L.T * (1.0 / T_REF),
            x.log((L.sigma_n + s0) * (1.0 / SIGMA_REF)),
            x.log((L.sd + d0) * (1.0 / SD_REF)),
            x.log(L.psi),
        ]

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups) -> None:
        from scipy.optimize import lsq_linear

        x = NumpyOps()
        features = self._features(x, LoadColumns(*(c[:, None] for c in loads.as_array().T)))
        design = np.concatenate([np.ones((len(mu), 1)), *features], axis=1)
        varies = np.ptp(design, axis=0) > 1e-9
        varies[0] = True
        used = design[:, varies]
        limit = np.full(used.shape[1], MAX_EXPONENT)
        limit[0] = 50.0
        floor = max(1e-3 * float(np.mean(mu)), 1e-9)
        coef = lsq_linear(used, np.log(np.maximum(mu, floor)), (-limit, limit)).x
        coef = refine_exponential(used, mu, coef, limit)
        self.coef_ = np.zeros(len(NAMES))
        self.coef_[varies] = coef

    def formula(
        self,
        x: Ops,
        L: LoadColumns,
        S: Sequence[Value] | None = None,
        system: Mapping[str, Value] | None = None,
    ) -> Value:
        total = x.matmul(x.concat(self._features(x, L)), self.coef_[1:, None], self.coef_[:1])
        return x.exp(x.minimum(total, float(np.log(MU.upper))))

    def formula_text(self) -> str:
        log_c, b, e, a, d, c = self.coef_
        return (
            f"mu = {np.exp(log_c):.4g} ((v_rel + {self.v_offset:g})/{V_REF:g})^{b:.4g} exp({e:.4g} T/{T_REF:g}) "
            f"((sigma_n + {self.sigma_offset:g})/{SIGMA_REF:g})^{a:.4g} "
            f"((sd + {self.sd_offset:g})/{SD_REF:g})^{d:.4g} psi^{c:.4g}"
        )

    def _learned(self) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
        return {}, {"coef": self.coef_}

    def _restore(self, values: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        for name in ("sigma_offset", "v_offset", "sd_offset"):
            check_number(self.family, name, getattr(self, name), 1e-6, 1e6)
        self.coef_ = stored_floats(self.family, arrays, "coef", (len(NAMES),))


def refine_exponential(
    design: FloatArray, mu: FloatArray, start: FloatArray, limit: FloatArray
) -> FloatArray:
    """Minimise ``sum (exp(design @ coef) - mu)^2`` within ``|coef| <= limit`` (Levenberg-Marquardt).

    Parameters
    ----------
    design : ndarray, shape (n, k)
    mu : ndarray, shape (n,)
    start, limit : ndarray, shape (k,)

    Returns
    -------
    ndarray, shape (k,)
    """

    def predicted(coef: FloatArray) -> FloatArray:
        return np.exp(np.minimum(design @ coef, np.log(MU.upper)))

    coef, damping = start, 1e-3
    fit = predicted(coef)
    cost = float(np.sum((fit - mu) ** 2))
    for _ in range(100):
        jacobian = design * fit[:, None]
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ (mu - fit)
        step = np.linalg.lstsq(normal + damping * np.diag(np.diag(normal) + 1e-30), gradient, rcond=None)[0]
        trial = np.clip(coef + step, -limit, limit)
        trial_fit = predicted(trial)
        trial_cost = float(np.sum((trial_fit - mu) ** 2))
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
