"""Tests at an end of a plan, which no other test reaches, do not speak against a law that is steep there."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.discovery import diagnose, refine

#: A star: one load at a time leaves the middle, the third value. [mm/s, degC, MPa, -]
STAR = {
    "v_rel": (5.0, 15.8, 50.0, 158.0, 500.0),
    "T": (25.0, 105.0, 185.0, 265.0, 345.0),
    "sigma_n": (300.0, 850.0, 1400.0, 1950.0, 2500.0),
    "psi": (1.1, 4.3, 7.5, 10.8, 14.0),
}


def star(seed: int) -> pd.DataFrame:
    """Two tests at each point of the star; friction falls between 80 and 200 degC as a share of a film that melts (Hill)."""
    rng = np.random.default_rng(seed)
    middle = {name: values[2] for name, values in STAR.items()}
    points = [middle] + [
        middle | {name: values[k]} for name, values in STAR.items() for k in range(5) if k != 2
    ]
    rows = []
    for test, loads in enumerate(2 * points):
        level = rng.normal(0.0, 0.004)
        for sd in np.linspace(0.0, 10.0, 40):
            T = loads["T"] + 0.3 * sd
            mu = 0.09 + 0.06 / (1.0 + (T / 125.0) ** 4) + 1e-6 * loads["sigma_n"] + level
            rows.append(
                {"test_id": f"t{test:02d}", "sd": sd, **loads, "T": T, "mu": mu + rng.normal(0.0, 0.001)}
            )
    return pd.DataFrame(rows)


def test_a_steep_end_belongs_to_its_law() -> None:
    """Without the two coldest tests a fit foretells far more friction there than was ever measured."""
    data = star(4)
    found = diagnose(data)
    assert found.effects == ["thermal_softening"] and found.verdict == "explained", found.sentence
    # the fall of the error is that of refine
    error = refine(data, add=found.effects).error_history_[0]
    assert error["after"]["rmse"] < 0.9 * error["before"]["rmse"]
