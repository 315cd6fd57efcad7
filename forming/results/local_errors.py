"""How far the loads at the markers may be off: the same process on a coarser mesh, compared marker by marker."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.ndimage import uniform_filter

from friction_models.loads import LOAD_NAMES

from ..fe.mesh.shape import FloatArray

#: Elements of the second run are larger by this factor.
COARSER = 1.5
#: Markers, and share of the steps, over which the differences of both runs are averaged: where meshes differ by chance,
#: two runs agree at single markers that are both off.
MARKERS, STEPS = 5, 0.2
#: Stated error over the mean difference of both runs (rms), for v_rel, T, sigma_n, sd, psi. Chosen so that it covers the
#: difference from elements of 0.1 mm at nine of ten markers of a rod and of a cup with the default mesh.
FACTORS = (1.6, 2.6, 1.7, 2.5, 2.1)


def local_errors(
    loads: FloatArray,
    active: npt.NDArray[np.bool_],
    coarse_loads: FloatArray,
    coarse_active: npt.NDArray[np.bool_],
) -> FloatArray:
    """Return the stated error of each load, shape (n, n_points, 5), in the units of the loads.

    It is `FACTORS` times the root of the mean square of the difference of both runs around marker and step. Where no
    marker around is in contact in both runs, the mean over the whole run stands in.

    Parameters
    ----------
    loads, coarse_loads : ndarray, shape (n, n_points, 5)
        Loads at the same markers and steps, with the mesh in question and with a coarser one; steps that one run
        did not reach are left out of both.
    active, coarse_active : ndarray of bool, shape (n, n_points)
        Markers in contact.

    Examples
    --------
    Both runs differ by 10 MPa everywhere:

    >>> loads, on = np.zeros((20, 6, 5)), np.ones((20, 6), dtype=bool)
    >>> errors = local_errors(loads, on, loads + np.array([0.0, 0.0, 10.0, 0.0, 0.0]), on)
    >>> [round(float(error), 6) for error in errors[0, 0]]
    [0.0, 0.0, 17.0, 0.0, 0.0]
    """
    n = min(len(loads), len(coarse_loads))
    both = active[:n] & coarse_active[:n]
    window = (max(1, 2 * round(0.5 * STEPS * n) + 1), MARKERS)
    weight = uniform_filter(both.astype(np.float64), window, mode="constant")
    errors = np.zeros_like(loads)
    for k, factor in enumerate(FACTORS):
        square = np.where(both, (loads[:n, :, k] - coarse_loads[:n, :, k]) ** 2, 0.0)
        around = np.maximum(uniform_filter(square, window, mode="constant"), 0.0)
        everywhere = square.sum() / max(int(both.sum()), 1)
        seen = weight > 0.5 / (window[0] * window[1])
        mean = np.where(seen, around / np.where(seen, weight, 1.0), everywhere)
        errors[:n, :, k] = factor * np.sqrt(mean)
        errors[n:, :, k] = factor * np.sqrt(everywhere)
    return errors


def summary(
    loads: FloatArray, active: npt.NDArray[np.bool_], errors: FloatArray
) -> list[tuple[str, float, float, float]]:
    """Return for each load its name, its median, and median and 90 % quantile of its error, over the markers in contact."""
    if not active.any():
        return []
    rows = []
    for k, name in enumerate(LOAD_NAMES):
        usual, high = np.quantile(errors[active, k], (0.5, 0.9))
        rows.append((name, float(np.median(loads[active, k])), float(usual), float(high)))
    return rows
