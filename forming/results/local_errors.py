"""How far the loads at the markers may be off: the same process on coarser meshes, compared marker by marker."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from friction_models.loads import LOAD_NAMES

from ..fe.mesh.shape import FloatArray

#: Elements of the further runs are larger by these factors.
COARSER = (1.5, 2.0)
#: Markers, and share of the steps, over which the differences are averaged (standard deviation of the weights): where
#: meshes differ by chance, two runs agree at single markers that are both off.
MARKERS, STEPS = 1.15, 0.085
#: Stated error over the mean error of first order, for v_rel, T, sigma_n, sd, psi: 9 of 10 loads of seven runs, on average,
#: are then closer to those with elements of 0.1 mm (docs/forming-results.md).
FACTORS = (1.0, 1.4, 0.95, 1.4, 1.0)

#: Loads, shape (n, n_points, 5), and markers in contact, shape (n, n_points), at the same markers and steps.
Contact = tuple[FloatArray, npt.NDArray[np.bool_]]


def local_errors(
    loads: FloatArray, active: npt.NDArray[np.bool_], coarse: Mapping[float, Contact]
) -> FloatArray:
    """Return the stated error of each load, shape (n, n_points, 5), in the units of the loads.

    An error C h of first order differs by (c - 1) C h from that with elements c times as large. This error, from each of the
    coarser runs, is averaged without its sign around marker and step, and multiplied by `FACTORS`. Where no marker
    around is in contact in both runs, the mean over the whole run stands in.

    Parameters
    ----------
    loads : ndarray, shape (n, n_points, 5)
        Loads with the mesh in question.
    active : ndarray of bool, shape (n, n_points)
        Markers in contact.
    coarse : mapping of float to (ndarray, ndarray)
        The same of runs with elements so many times as large; steps that such a run did not reach are left out.

    Examples
    --------
    Elements twice as large, and all loads 10 higher:

    >>> loads, on = np.zeros((20, 6, 5)), np.ones((20, 6), dtype=bool)
    >>> errors = local_errors(loads, on, {2.0: (loads + 10.0, on)})
    >>> [round(float(error), 6) for error in errors[0, 0]]
    [10.0, 14.0, 9.5, 14.0, 10.0]
    """
    weight, total = np.zeros(active.shape), np.zeros(loads.shape)
    for coarser, (other, touching) in coarse.items():
        n = min(len(loads), len(other))
        both = active[:n] & touching[:n]
        weight[:n] += both
        total[:n] += np.where(both[..., None], np.abs(loads[:n] - other[:n]) / (coarser - 1.0), 0.0)
    width = (STEPS * max((len(other) for other, _ in coarse.values()), default=0), MARKERS)
    around = _spread(weight, width)
    seen, everywhere = around > 1e-3, total.sum(axis=(0, 1)) / max(float(weight.sum()), 1.0)
    errors = np.empty_like(total)
    for k, factor in enumerate(FACTORS):
        mean = _spread(total[..., k], width) / np.where(seen, around, 1.0)
        errors[..., k] = factor * np.where(seen, mean, everywhere[k])
    return errors


def _spread(values: FloatArray, width: tuple[float, float]) -> FloatArray:
    from scipy.ndimage import gaussian_filter  # few runs ask for errors, every FMU of a process would load it

    return np.asarray(gaussian_filter(values, width, mode="constant", truncate=3.0))


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
