"""Speed, pressure and surface expansion along the sliding distance of a test."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .domains import Domain

Array = NDArray[np.float64]
#: Points a test on the fine grid: 0.1 mm for 55 mm.
FINE = 550


@dataclass
class Profiles:
    """True loads of all tests that do not depend on friction; arrays of shape (n_tests, n_points).

    Attributes
    ----------
    sd, v, sigma, psi, t : ndarray
        Distance [mm], speed [mm/s], pressure [MPa], surface expansion [-], time [s].
    T_start : ndarray, shape (n_tests,)
        Contact temperature before sliding [degC].
    """

    sd: Array
    v: Array
    sigma: Array
    psi: Array
    t: Array
    T_start: Array


def profiles(table: pd.DataFrame, domain: Domain, rng: np.random.Generator) -> Profiles:
    """Speed ramp at the start, slight decay of pressure, nearly constant surface expansion.

    Parameters
    ----------
    table : pandas.DataFrame
        Test table with the set points.
    domain : Domain
        Load ranges.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    Profiles
        Loads on the fine grid.
    """
    n = len(table)
    sd = np.broadcast_to(domain.sd_max * np.arange(1, FINE + 1) / FINE, (n, FINE)).copy()
    v_set = table["v_set"].to_numpy(float)[:, None] * (1.0 + rng.normal(0.0, 0.004, (n, 1)))
    drive = rng.uniform(*domain.acceleration)
    acceleration = drive * (1.0 + rng.normal(0.0, 0.08, (n, 1)))
    ramp = 2.0 * acceleration * sd / v_set**2
    v = v_set * np.sqrt(1.0 - np.exp(-ramp))
    decay = np.clip(rng.uniform(0.01, 0.05) + rng.normal(0.0, 0.006, (n, 1)), 0.0, None)
    length = rng.uniform(0.2, 0.6) * domain.sd_max
    sigma_set = table["sigma_set"].to_numpy(float)[:, None] * (1.0 + rng.normal(0.0, 0.012, (n, 1)))
    sigma = sigma_set * (1.0 - decay * (1.0 - np.exp(-sd / length)))
    growth = rng.uniform(0.0, 0.04)
    psi_set = table["psi_set"].to_numpy(float)[:, None]
    varies = psi_set > 1.0
    psi = np.where(varies, 1.0 + (psi_set - 1.0) * (1.0 + rng.normal(0.0, 0.01, (n, 1))), 1.0)
    psi = 1.0 + (psi - 1.0) * (1.0 + growth * sd / domain.sd_max)
    before = np.concatenate([np.zeros((n, 1)), v[:, :-1]], axis=1)
    step = np.diff(sd, axis=1, prepend=0.0)
    t = np.cumsum(2.0 * step / (v + before), axis=1)
    tool = table["T_tool [degC]"].to_numpy(float)
    # The specimen is warm from upsetting, a hot plate is cooled a little by it.
    warm = 25.0 * table["sigma_set"].to_numpy(float) / max(domain.sigma) if domain.size == 1.0 else 0.0
    return Profiles(sd, v, sigma, psi, t, tool + warm - 0.05 * np.maximum(tool - 20.0, 0.0))
