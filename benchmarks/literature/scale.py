"""Size of a law: amplitude from a wanted ratio of what a linear model misses to the scatter of tests."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .contact import Run
from .law import Ranges
from .profiles import Profiles

Array = NDArray[np.float64]


def ranges(loads: Profiles, run: Run, order: NDArray[Any]) -> Ranges:
    """Ranges of the loads along a run (2 % and 98 % points; distance and order by their ends)."""
    columns = {
        "v": loads.v[:, 20:],
        "T": run.T[:, 20:],
        "sigma": loads.sigma,
        "psi": loads.psi,
        "mu": run.mu,
        "rise": run.T - loads.T_start[:, None],
    }
    low = {k: float(np.quantile(c, 0.02)) for k, c in columns.items()}
    high = {k: float(np.quantile(c, 0.98)) for k, c in columns.items()}
    low |= {"sd": float(loads.sd[0, 0]), "order": float(order.min())}
    high |= {"sd": float(loads.sd[0, -1]), "order": float(order.max())}
    return Ranges(low, high)


def missed(shape: Array, loads: Profiles, T: Array) -> Array:
    """Part of a shape that a linear model of the five loads cannot learn, same shape as `shape`."""
    X = np.column_stack(
        [np.ones(shape.size)] + [a.ravel() for a in (loads.v, T, loads.sigma, loads.sd, loads.psi)]
    )
    scale = np.maximum(np.abs(X).max(axis=0), 1e-12)
    coefficients, *_ = np.linalg.lstsq(X / scale, shape.ravel(), rcond=None)
    return (shape.ravel() - (X / scale) @ coefficients).reshape(shape.shape)


def size(residual: Array) -> float:
    """Size of what is missed: root mean square, or 0.4 of the 99 % point for short local effects."""
    return float(max(np.sqrt(np.mean(residual**2)), 0.4 * np.quantile(np.abs(residual), 0.99)))


def amplitude(shape: Array, loads: Profiles, T: Array, wanted: float, cap: float) -> float:
    """Factor of a unit shape.

    Parameters
    ----------
    shape : ndarray, shape (n_tests, n_points)
        Unit shape along the loads.
    loads : Profiles
        True loads.
    T : ndarray, shape (n_tests, n_points)
        Contact temperature [degC].
    wanted : float
        Wanted size of the missed part [-], as friction coefficient.
    cap : float
        Largest span of the effect as friction coefficient.

    Returns
    -------
    float
        Amplitude, at most what `cap` allows.
    """
    span = float(np.quantile(shape, 0.999) - np.quantile(shape, 0.001))
    if span <= 0.0:
        return 0.0
    return min(wanted / max(size(missed(shape, loads, T)), 1e-12), cap / span)
