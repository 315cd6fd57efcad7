"""Made-up tests with a known smooth law, for tests of models; nothing here comes from a measurement."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.loads import LOAD_NAMES, FloatArray

#: Loads at and far beyond the borders of every domain: zeros, physical limits, nearly nothing.
EDGES = np.array(
    [
        [0.0, 20.0, 0.0, 0.0, 1.0],
        [0.0, -273.15, 0.0, 0.0, 1e-3],
        [1e5, 2000.0, 1e5, 1e6, 1e3],
        [1e5, -273.15, 1e5, 1e6, 1e-3],
        [0.0, 2000.0, 1e5, 0.0, 1e3],
        [1e-300, 0.0, 1e-300, 1e-300, 1.0],
        [50.0, 80.0, 1000.0, 10.0, 1.2],
    ]
)


def law(loads: FloatArray) -> FloatArray:
    """Return mu of a smooth law in all five loads, shape (n,)."""
    v, T, sigma, sd, psi = loads.T
    return (
        0.07
        + 0.03 * np.exp(-v / 80)
        + 0.02 * np.exp(-sd / 6)
        - 0.012 * sigma / 2750
        + 0.006 * np.log(psi)
        - 5e-5 * (T - 20)
    )


def campaign(tests: int = 24, points: int = 40, noise: float = 0.0015, seed: int = 0) -> pd.DataFrame:
    """Return points of whole tests: three speeds, temperatures, pressures, expansions; 60 mm each."""
    rng = np.random.default_rng(seed)
    parts = []
    for i in range(tests):
        v, T, sigma, psi = (
            rng.choice(levels)
            for levels in (
                (5.0, 200.0, 500.0),
                (20.0, 100.0, 300.0),
                (500.0, 1750.0, 2750.0),
                (1.069, 5.0, 20.0),
            )
        )
        sd = np.linspace(0.5, 60.0, points)
        loads = np.column_stack(
            [
                v * (1 - np.exp(-sd / 2)),
                T + 60 * np.sqrt(sd / 60),
                sigma * (1 - 0.1 * sd / 60),
                sd,
                np.full(points, psi),
            ]
        )
        frame = pd.DataFrame(loads, columns=list(LOAD_NAMES))
        frame.insert(0, "test_id", f"t{i:02d}")
        frame.insert(1, "t", sd / v)
        frame["mu"] = np.maximum(law(loads) + rng.normal(0, noise, points), 0.0)
        parts.append(frame)
    return pd.concat(parts, ignore_index=True)


def anywhere(points: int, seed: int = 0) -> FloatArray:
    """Return random loads inside the range of `campaign`, shape (points, 5)."""
    low, high = [0.0, 20.0, 300.0, 0.0, 1.0], [500.0, 400.0, 2750.0, 60.0, 20.0]
    return np.random.default_rng(seed).uniform(low, high, (points, 5))
