"""What sets whole tests apart is found in series as in their means, though more happens along the tests."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.discovery import diagnose


def series(seed: int, oil: float = 0.02) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return 48 tests at four settings, that settle along their path each in its own way; every third oil lowers mu."""
    rng = np.random.default_rng(seed)
    sd = np.linspace(100.0, 6000.0, 30)
    frames, oils = [], np.tile(["plain", "A", "B"], 16)
    for k in range(48):
        v, p = (20.0, 100.0)[k % 2], (10.0, 20.0)[k // 2 % 2]
        settles = rng.normal(0.012, 0.012) / (1.0 + sd / rng.uniform(500.0, 3000.0))
        waves = np.cumsum(rng.normal(0.0, 0.002, len(sd)))
        mu = 0.11 - oil * (oils[k] == "B") + rng.normal(0.0, 0.008) + settles + waves - 0.0001 * v
        frames.append(
            pd.DataFrame({"test_id": f"t{k:02d}", "t": sd / v, "v_rel": v, "sigma_n": p, "sd": sd, "mu": mu})
        )
    return pd.concat(frames), pd.DataFrame({"test_id": [f"t{k:02d}" for k in range(48)], "oil": oils})


def test_an_oil_that_unseen_tests_show_is_named() -> None:
    found = [diagnose(*series(seed)) for seed in range(3)]
    assert sum("factor:oil" in d.effects for d in found) == 3, [d.sentence for d in found]


def test_an_oil_that_does_nothing_is_not() -> None:
    assert all("factor:oil" not in diagnose(*series(seed, 0.0)).effects for seed in range(2))
