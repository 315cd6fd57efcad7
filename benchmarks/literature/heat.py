"""Contact temperature from friction heat, one dimension a body.

The specimen face is a half space that is heated all the time; its memory kernel ``1 / (e sqrt(pi t))`` is
written as a sum of decaying exponentials (trapezoidal rule of its Laplace integral in ``ln s``). The plate is
always fresh under the face: it answers at once with the mean rise of a band of length ``LENGTH`` that was
heated while it passed. Both surfaces have one temperature, which fixes how the heat is shared.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Effusivities [W s^0.5 / (m2 K)] of the specimen (16MnCr5) and of the plate (1.2379).
EFFUSIVITY_SPECIMEN = 12448.0
EFFUSIVITY_PLATE = 8417.0
#: Length of the contact in sliding direction [m].
LENGTH = 0.015

_LOG_STEP = 1.0
_RATES = np.exp(np.arange(np.log(1e-3), np.log(3e4), _LOG_STEP))  # [1/s]
_WEIGHTS = _LOG_STEP / np.pi * np.sqrt(_RATES)


class HeatedContact:
    """State of the temperature rise of many tests at once.

    Parameters
    ----------
    n_tests : int
        Number of tests that are marched together.
    share : float
        Share of the friction heat that reaches the two surfaces (the rest stays in the film and in the rim).
    """

    def __init__(self, n_tests: int, share: float = 0.5) -> None:
        self.share = share
        self.memory: Array = np.zeros((n_tests, _RATES.size))
        self.rise: Array = np.zeros(n_tests)

    def step(self, mu: Array, sigma: Array, v: Array, dt: Array) -> Array:
        """Advance by one time step.

        Parameters
        ----------
        mu : ndarray, shape (n_tests,)
            Friction coefficient [-].
        sigma : ndarray, shape (n_tests,)
            Contact pressure [MPa].
        v : ndarray, shape (n_tests,)
            Sliding speed [mm/s].
        dt : ndarray, shape (n_tests,)
            Time step [s].

        Returns
        -------
        ndarray, shape (n_tests,)
            Rise of the contact temperature over its start value [K].
        """
        flux = self.share * np.maximum(mu, 0.0) * sigma * v * 1e3  # W/m2
        decay = np.exp(-np.outer(dt, _RATES))
        gain = _WEIGHTS * (1.0 - decay) / _RATES
        faded = self.memory * decay
        own = gain.sum(axis=1) / EFFUSIVITY_SPECIMEN
        old = faded.sum(axis=1) / EFFUSIVITY_SPECIMEN
        transit = LENGTH / np.maximum(v * 1e-3, 1e-6)
        # Mean over the band of q sqrt(4 t / pi) / e, bounded for very slow sliding.
        plate = (2.0 / 3.0) * np.sqrt(4.0 * np.minimum(transit, 5.0) / np.pi) / EFFUSIVITY_PLATE
        into_specimen = np.maximum((flux * plate - old) / (plate + own), 0.0)
        self.memory = faded + into_specimen[:, None] * gain
        self.rise = old + own * into_specimen
        return self.rise
