"""A law of three loads of which no one, and no two, show anything by themselves."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose

MIDDLE, HALF = {"v_rel": 30.0, "T": 140.0, "sigma_n": 500.0}, {"v_rel": 25.0, "T": 100.0, "sigma_n": 400.0}


@pytest.mark.parametrize("seed", range(3))
def test_three_loads_together_are_no_scatter(seed: int) -> None:
    """Friction is high where an even number of the loads is low: half of the variance of mu, and nothing along any two of them."""
    rng = np.random.default_rng(seed)
    n = 80
    at = rng.uniform(-1.0, 1.0, (n, 3))
    mu = 0.12 + 0.012 * np.tanh(2.0 * at[:, 0]) * np.sin(1.4 * at[:, 1]) * at[:, 2] / 0.35
    loads = {name: MIDDLE[name] + HALF[name] * at[:, k] for k, name in enumerate(MIDDLE)}
    data = pd.DataFrame(
        {"test_id": [f"t{k:02d}" for k in range(n)], **loads, "mu": mu + rng.normal(0.0, 0.003, n)}
    )
    found = diagnose(data)
    assert found.verdict == "unknown_structure" and not found.effects, found.sentence
    assert found.error_budget["missing"] > found.error_budget["floor"]
