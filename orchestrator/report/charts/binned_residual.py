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

    Examples
    --------
    >>> found = binned_residual(np.zeros(3), np.array([0.0, 0.01, 0.02]), np.array(["a", "b", "c"]))
    >>> found.mean.round(6), found.tests
    (array([0.01]), array([3]))
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

    Examples
    --------
    Six tests at two temperatures; the model is right at 20 degC and 0.01 too low at 80 degC:

    >>> load = np.array([20.0, 20.0, 20.0, 80.0, 80.0, 80.0])
    >>> residual = np.array([0.001, -0.001, 0.0, 0.011, 0.009, 0.010])
    >>> found = binned_residual(load, residual, np.array(list("abcdef")))
    >>> found.centre, found.mean.round(6) + 0.0, found.tests
    (array([20., 80.]), array([0.  , 0.01]), array([3, 3]))
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
