"""The floor: what a fit with the true form of the law reaches on held-out tests."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

LOADS = ("v_rel [mm/s]", "T [degC]", "sigma_n [MPa]", "sd [mm]", "psi")


def _design(data: pd.DataFrame, shapes: NDArray[Any]) -> NDArray[Any]:
    return np.column_stack([np.ones(len(data)), data[list(LOADS)].to_numpy(float), shapes])


def fit_predict(
    data: pd.DataFrame,
    shapes: NDArray[Any],
    new: pd.DataFrame,
    new_shapes: NDArray[Any],
    test_sd: float,
    point_sd: float,
    drop: set[str] | None = None,
) -> NDArray[np.float64]:
    """Fit a linear base and the given shapes with a random intercept a test; predict other tests.

    Parameters
    ----------
    data : pandas.DataFrame
        Measured campaign, one row a point.
    shapes : ndarray, shape (n_rows, n_laws)
        Further regressors; no columns for the plain linear base.
    new : pandas.DataFrame
        Held-out tests.
    new_shapes : ndarray, shape (n_new, n_laws)
        Their further regressors.
    test_sd, point_sd : float
        Standard deviations between tests and between the points of a test.
    drop : set of str, optional
        Tests to leave out.

    Returns
    -------
    ndarray, shape (n_new,)
        Predicted friction coefficient.
    """
    X, y = _design(data, shapes), data["mu"].to_numpy(float)
    ids = data["test_id"].to_numpy()
    keep = ~np.isin(ids, list(drop or set()))
    scale = np.maximum(np.abs(X).max(axis=0), 1e-12)
    frame = pd.DataFrame(np.column_stack([X / scale, y])[keep])
    groups = frame.groupby(ids[keep])
    count = groups[0].transform("size").to_numpy(float)
    theta = 1.0 - np.sqrt(point_sd**2 / (point_sd**2 + count * test_sd**2))
    turned = frame.to_numpy() - theta[:, None] * groups.transform("mean").to_numpy()
    coefficients, *_ = np.linalg.lstsq(turned[:, :-1], turned[:, -1], rcond=None)
    return _design(new, new_shapes) / scale @ coefficients
