"""The test table: order of testing, system variables and the set points."""

from __future__ import annotations

import numpy as np
import pandas as pd

#: Column of the test table -> key used by the laws.
PLAIN = {
    "Ra [um]": "Ra",
    "t_wait [s]": "t_wait",
    "T_tool [degC]": "T_tool",
    "film_weight [g/m2]": "film_weight",
    "humidity [%]": "humidity",
}


def test_table(
    setpoints: pd.DataFrame, rng: np.random.Generator, first: int = 1, prefix: str = "S"
) -> pd.DataFrame:
    """Metadata of tests in random order, independent of their loads.

    Parameters
    ----------
    setpoints : pandas.DataFrame
        Columns ``v, T, sigma, psi``, one row a test.
    rng : numpy.random.Generator
        Source of randomness.
    first : int
        Number of the first test in the order of testing.
    prefix : str
        Start of the test identifiers.

    Returns
    -------
    pandas.DataFrame
        One row a test in the rows' order of `setpoints`.
    """
    n = len(setpoints)
    order = first + rng.permutation(n)
    tool = rng.choice(["P1", "P2", "P3"], n)
    ra_of = {"P1": 0.02, "P2": 0.05, "P3": 0.12}
    ra = np.array([ra_of[k] for k in tool]) * rng.lognormal(0.0, 0.2, n)
    return pd.DataFrame(
        {
            "test_id": [f"{prefix}{i:03d}" for i in order],
            "order": order,
            "batch": rng.choice(["B1", "B2", "B3"], n),
            "tool_id": tool,
            "Ra [um]": ra.round(4),
            "t_wait [s]": np.clip(rng.lognormal(2.5, 1.0, n), 1.0, 600.0).round(1),
            "T_tool [degC]": setpoints["T"].to_numpy() + rng.normal(0.0, 1.5, n).round(1),
            "v_set": setpoints["v"].to_numpy(),
            "sigma_set": setpoints["sigma"].to_numpy(),
            "psi_set": setpoints["psi"].to_numpy(),
            "operator": rng.choice(["O1", "O2", "O3"], n),
            "film_weight [g/m2]": rng.uniform(2.0, 14.0, n).round(2),
            "humidity [%]": rng.uniform(25.0, 70.0, n).round(1),
        }
    )


def for_laws(table: pd.DataFrame) -> dict[str, np.ndarray]:
    """Columns as arrays under plain keys."""
    return {PLAIN.get(str(c), str(c)): table[c].to_numpy() for c in table.columns}


# pytest must not take the function above for a test when it is imported.
test_table.__test__ = False  # type: ignore[attr-defined]
