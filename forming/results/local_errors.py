"""How far the loads at the markers may be off: the same process on a finer mesh, compared marker by marker."""

from __future__ import annotations

import math
import os

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, FloatArray

#: Elements of the further run are smaller by this factor. Larger ones do not tell: what they do wrong, such as contact where
#: there should be none, the run in question need not do at all.
FINER = 2.0 / 3.0
#: Environment variable: the elements of a forming FMU are so many times as large as its parameters say.
ELEMENTS = "TRIBOFMU_ELEMENTS"
SMALLEST, LARGEST = 0.2, 5.0
#: Markers, and share of the steps, over which the differences are averaged (standard deviation of the weights): where
#: meshes differ by chance, two runs agree at single markers that are both off.
MARKERS, STEPS = 1.0, 0.06
#: Stated error over the mean error of first order, for v_rel, T, sigma_n, sd, psi: 9 of 10 loads of twelve runs (psi: of eight), on average,
#: are then closer to those with elements a quarter as large (docs/forming-results.md).
FACTORS = (0.9, 1.6, 0.95, 1.25, 1.05)

#: Loads, shape (n, n_points, 5), and markers in contact, shape (n, n_points), at the same markers and steps.
Contact = tuple[FloatArray, npt.NDArray[np.bool_]]


def elements_from_environment() -> float:
    """Return by how much elements are larger than the parameters of a process say.

    Raises InputError: not a number from 0.2 to 5.
    """
    given = os.environ.get(ELEMENTS) or "1"
    try:
        factor = float(given)
    except ValueError:
        factor = math.nan
    if not SMALLEST <= factor <= LARGEST:
        raise InputError(f"{ELEMENTS}={given[:40]!r}; allowed: {SMALLEST:g} to {LARGEST:g}")
    return factor


def local_errors(loads: FloatArray, active: npt.NDArray[np.bool_], finer: Contact) -> FloatArray:
    """Return the stated error of each load, in the units and the shape of the loads.

    An error C h of first order differs by (1 - `FINER`) C h from that with smaller elements. This error is averaged
    without its sign around marker and step, and multiplied by `FACTORS`. Where no marker around is in contact in both
    runs, the mean over the whole run stands in.

    - `loads`, `active`: with the mesh in question; `finer`: of the run with elements smaller by `FINER`.

    All loads 1 lower than with elements two thirds as large:

    >>> loads, on = np.zeros((20, 6, 5)), np.ones((20, 6), dtype=bool)
    >>> errors = local_errors(loads, on, (loads + 1.0, on))
    >>> [round(float(error), 6) for error in errors[0, 0]]
    [2.7, 4.8, 2.85, 3.75, 3.15]
    """
    other, touching = finer
    both = active & touching
    first_order = np.where(both[..., None], np.abs(loads - other) / (1.0 - FINER), 0.0)
    width = (STEPS * len(loads), MARKERS)
    around = _spread(both.astype(np.float64), width)
    seen, everywhere = around > 1e-3, first_order.sum(axis=(0, 1)) / max(int(both.sum()), 1)
    errors = np.empty_like(first_order)
    for k, factor in enumerate(FACTORS):
        mean = _spread(first_order[..., k], width) / np.where(seen, around, 1.0)
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
