"""Measurements of which everything is known, for tests of the estimation: no sensor, no laboratory, no catalogue."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd

from friction_models import LinearFriction
from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.base_law import base_law
from friction_models.estimation.search.candidates import Candidate
from friction_models.estimation.search.search_round import SearchRound, search

STEP = 0.5  # mm


def measured(
    rng: np.random.Generator,
    tests: int = 24,
    points: int = 30,
    between: float = 0.004,
    drift: float = 0.0,
    length: float = 3.0,
    sensor: float = 0.001,
) -> pd.DataFrame:
    """Return tests at random constant loads: mu linear in them, an offset and a drift of each test, sensor noise.

    The drift is an autoregressive process, so that its covariance falls exponentially with the distance.
    """
    parts = []
    kept = np.exp(-STEP / length)
    for k in range(tests):
        v, T, sigma = rng.uniform([5.0, 20.0, 500.0], [500.0, 300.0, 2500.0])
        slow = np.empty(points)
        slow[0] = rng.normal()
        for i in range(1, points):
            slow[i] = kept * slow[i - 1] + np.sqrt(1.0 - kept**2) * rng.normal()
        noise = between * rng.normal() + drift * slow + sensor * rng.normal(size=points)
        parts.append(
            pd.DataFrame(
                {
                    "test_id": f"t{k:03d}",
                    "v_rel": v,
                    "T": T,
                    "sigma_n": sigma,
                    "sd": STEP * (np.arange(points) + 1.0),
                    "psi": 1.2,
                    "mu": 0.15 + 1e-5 * v - 1e-5 * sigma + noise,
                }
            )
        )
    return pd.concat(parts, ignore_index=True)


def searched(
    data: pd.DataFrame, seed: int = 0, known: pd.Series | None = None
) -> tuple[BinnedTests, SearchRound]:
    """Return the campaign and a search beside a linear base without any candidate.

    The estimation of the floor allows for a multiple of `known`, a value for each point.
    """
    campaign = prepare(data)
    extra = None if known is None else campaign.average(known.to_numpy()[:, None])
    return campaign, search(
        campaign, base_law(LinearFriction(), campaign), None, [], seed, also_in_mean=extra
    )


def candidate(
    name: str,
    columns: np.ndarray,
    signs: tuple[int, ...] = (0,),
    driver: tuple[str, ...] = (),
    kind: str = "physics",
) -> Candidate:
    """Return a candidate with given columns, shape (m, sets, amplitudes), instead of a formula."""
    effect: Any = SimpleNamespace(
        name=name,
        amplitudes=tuple(SimpleNamespace(name=f"a{k}", sign=s) for k, s in enumerate(signs)),
        degrees_of_freedom=len(signs),
        kind=kind,
        driver=driver,
    )
    return Candidate(effect, {"s": np.arange(columns.shape[1], dtype=float)}, columns)
