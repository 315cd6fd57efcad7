"""Temperature rise of the contact in a test: a power law of pressure, speed and distance, fitted to tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...loads import FloatArray

#: Smaller rises are not used for the fit [K].
WARM = 1.0
_LEAST_POINTS = 20
#: Logarithm of the largest rise [K] that is predicted: 700 K.
_HOT = 6.55


@dataclass(frozen=True)
class Heating:
    """``rise = exp(c) (sigma_n)^p (v_rel + 0.5)^q (sd + 0.5)^r`` [K, MPa, mm/s, mm]."""

    #: c, p, q, r; None if no test was warm enough: no rise is predicted. Shape (4,).
    exponents: FloatArray | None

    @classmethod
    def learn(cls, sigma_n: FloatArray, v_rel: FloatArray, sd: FloatArray, rise: FloatArray) -> Heating:
        """Fit the law to points, each of shape (n,); `rise` is contact less tool temperature [K]."""
        warm = rise > WARM
        if int(warm.sum()) < _LEAST_POINTS:
            return cls(None)
        terms = _terms(sigma_n[warm], v_rel[warm], sd[warm])
        return cls(np.asarray(np.linalg.lstsq(terms, np.log(rise[warm]), rcond=1e-8)[0]))

    def rise(self, sigma_n: FloatArray, v_rel: FloatArray, sd: FloatArray) -> FloatArray:
        """Return the temperature rise [K], shape (n,)."""
        if self.exponents is None:
            return np.zeros(len(sd))
        return np.exp(np.minimum(_terms(sigma_n, v_rel, sd) @ self.exponents, _HOT))


def _terms(sigma_n: FloatArray, v_rel: FloatArray, sd: FloatArray) -> FloatArray:
    return np.column_stack(
        [np.ones(len(sd)), np.log(np.maximum(sigma_n, 1.0)), np.log(v_rel + 0.5), np.log(sd + 0.5)]
    )
