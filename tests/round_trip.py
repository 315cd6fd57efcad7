"""How far the twin's loads are from the truth that the virtual laboratory keeps to itself."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from friction_models.loads import DataSet, FloatArray


def deviations(data: DataSet, truth: Mapping[str, Mapping[str, FloatArray]]) -> pd.DataFrame:
    """Return one row a test.

    `T`: mean contact temperature, in % of the mean rise over the tool; `sigma_n`, `psi`: means, in %;
    `mu_rms`, `mu_bias`, `mu_std`: error of mu and its stated standard uncertainty; `mu_inside`: share of the points
    within two of them.
    """
    assert data.tests is not None
    tools = data.tests.set_index("test_id")["T_tool"]
    rows = []
    for name, points in data.points.groupby("test_id", sort=False):
        true = truth[str(name)]
        sd = points["sd"].to_numpy()
        # The laboratory knows the truth at tenths of a millimetre up to where the plate stopped.
        points, sd = points[sd <= true["sd"][-1] + 1e-9], sd[sd <= true["sd"][-1] + 1e-9]
        at = {key: np.interp(sd, true["sd"], true[key]) for key in ("T", "sigma_n", "psi", "mu")}
        error = points["mu"].to_numpy() - at["mu"]
        spread = points["mu_std"].to_numpy()
        rise = float(np.mean(at["T"] - float(tools[name])))
        rows.append(
            {
                "test_id": str(name),
                "T": 100.0 * float(np.mean(points["T"].to_numpy() - at["T"])) / rise,
                **{
                    key: 100.0 * (float(points[key].mean()) / float(at[key].mean()) - 1.0)
                    for key in ("sigma_n", "psi")
                },
                "mu_rms": float(np.sqrt(np.mean(error**2))),
                "mu_bias": float(error.mean()),
                "mu_std": float(spread.mean()),
                "mu_inside": float(np.mean(np.abs(error) <= 2.0 * spread)),
                "rise": rise,
            }
        )
    return pd.DataFrame(rows)
