"""Force against travel without the ripple of surface nodes that pass the roundings of the tools."""

from __future__ import annotations

import numpy as np

from ..fe.mesh.shape import FloatArray

#: Travel over which the force is averaged before its maximum is read [mm].
FORCE_WINDOW = 0.5


def averaged(travel: FloatArray, force: FloatArray, window: float = FORCE_WINDOW) -> FloatArray:
    """Return the force averaged over `window` [mm] of travel, less near the ends.

    - `travel`, `force`, shape (n,): `travel` grows.

    The mean of a straight line over any window is its middle:

    >>> travel = np.linspace(0.0, 2.0, 21)
    >>> averaged(travel, 50.0 * travel)[[0, 10, 20]].round(6).tolist()
    [0.0, 50.0, 100.0]
    """
    if len(travel) < 3:
        return force
    fine = np.union1d(np.linspace(travel[0], travel[-1], 4 * len(travel)), travel)
    f = np.interp(fine, travel, force)
    area = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(fine) * (f[1:] + f[:-1]))])
    half = np.minimum(0.5 * window, np.minimum(travel - travel[0], travel[-1] - travel))
    low, high = travel - half, travel + half
    mean = np.interp(high, fine, area) - np.interp(low, fine, area)
    wide = half > 1e-9
    return np.where(wide, mean / np.where(wide, high - low, 1.0), force)
