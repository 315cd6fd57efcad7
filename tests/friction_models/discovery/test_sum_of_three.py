"""Three effects that are certain together only: what the others leave between tests hides each of them."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy.stats import qmc

from friction_models.discovery import diagnose


def falling_growing_wearing(seed: int) -> pd.DataFrame:
    """Return 60 tests: mu falls with temperature, rises with surface expansion, and the lubricant wears out."""
    rng = np.random.default_rng(seed)
    frames = []
    for k, (a, b, c, e) in enumerate(qmc.LatinHypercube(4, seed=rng).random(60)):
        v, tool, p, psi = 5.0 * 100.0**a, 20.0 + 260.0 * b, 150.0 * 10.0**c, 1.0 + 14.0 * e
        sd = np.linspace(0.0, 1.0, 24) ** 1.5 * 28.0
        pressure = p * (1.0 + 0.06 * sd / 28.0)
        T = tool + 0.012 * p * np.sqrt(v / 100.0) * np.sqrt(sd / 28.0) + rng.normal(0.0, 1.5)
        mu = 0.08 + 0.004 * T / 280.0 - 0.004 * pressure / 1500.0 + 0.003 * v / 500.0
        mu += 0.05 / (1.0 + (np.maximum(T - 20.0, 0.0) / 70.0) ** 1.5)
        mu += 0.05 * (1.0 - psi**-1.2)
        mu += 0.05 / (1.0 + np.exp(-(sd - 18.0) / 3.0))
        mu += rng.normal(0.0, 0.003) + rng.normal(0.0, 0.001, len(sd))
        loads = {"t": sd / v, "v_rel": v, "T": T, "sigma_n": pressure, "sd": sd, "psi": psi}
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu}))
    return pd.concat(frames, ignore_index=True)


def test_three_effects_are_found_where_none_is_certain_alone() -> None:
    found = diagnose(falling_growing_wearing(2))
    assert found.verdict in ("explained", "ambiguous")
    assert set(found.effects) == {"thermal_softening", "surface_expansion", "wear_out"}
