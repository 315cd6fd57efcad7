"""Mean residual over each load, with intervals that treat a whole test as one observation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from friction_models.discovery.summaries import clustered_mean, load_bins
from friction_models.loads import FloatArray

BINS = 9
MIN_TESTS = 3


@dataclass(frozen=True)
class BinnedResidual:
    """Mean of measured - model in bins of one load.

    Attributes
    ----------
    centre : ndarray, shape (k,)
        Mean load of the bin.
    mean, half : ndarray, shape (k,)
        Mean over the points in the bin and half of its 95 % interval over tests (NaN for one test).
    tests : ndarray, shape (k,)
        Number of tests in the bin.
    """

    centre: FloatArray
    mean: FloatArray
    half: FloatArray
    tests: np.ndarray


def binned_residual(
    load: FloatArray, residual: FloatArray, test_id: np.ndarray, weight: FloatArray | None = None
) -> BinnedResidual:
    """Bin residuals by quantiles of a load, levels of a plan kept together.

    The interval of a bin treats a test as the unit, so that 500 points of one test do not count as 500 observations
    (no interval for a single test). There are as many bins, up to nine, as leave at least three tests in each.

    Parameters
    ----------
    load, residual : ndarray, shape (n,)
    test_id : ndarray of str, shape (n,)
    weight : ndarray, shape (n,), optional
        Points behind each value; one each by default.
    """
    _, test = np.unique(test_id, return_inverse=True)
    which = _bins(load, test)
    points = np.ones(len(load)) if weight is None else np.asarray(weight, dtype=float)
    rows = []
    for k in range(int(which.max()) + 1):
        inside = which == k
        mean, half, tests = clustered_mean(residual, points, test, inside)
        rows.append((float(load[inside].mean()), mean, half, tests))
    table = np.array(rows, dtype=float).reshape(-1, 4)
    return BinnedResidual(table[:, 0], table[:, 1], table[:, 2], table[:, 3].astype(int))


def _bins(load: FloatArray, test: np.ndarray) -> np.ndarray:
    """Return the bin of each point: quantiles of the load, as many as leave `MIN_TESTS` tests in each."""
    least = min(MIN_TESTS, len(np.unique(test)))
    for count in range(BINS, 0, -1):
        which = load_bins(load, count)
        present = [len(np.unique(test[which == k])) for k in range(int(which.max()) + 1)]
        if min(present) >= least:
            break
    return which
