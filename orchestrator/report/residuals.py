"""Mean residual over each load, with intervals that treat a whole test as one observation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

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
        Mean over the tests in the bin and half of its 95 % interval; each test counts once.
    tests : ndarray, shape (k,)
        Number of tests in the bin.
    """

    centre: FloatArray
    mean: FloatArray
    half: FloatArray
    tests: np.ndarray


def binned_residual(load: FloatArray, residual: FloatArray, test_id: np.ndarray) -> BinnedResidual:
    """Bin residuals by quantiles of a load.

    The mean of a bin is the mean over its tests of each test's own mean there; the interval is Student's
    t over these test means, so that 500 points of one test do not count as 500 observations. There are
    as many bins, up to nine, as leave at least three tests in each.
    """
    _, test = np.unique(test_id, return_inverse=True)
    which = _bins(load, test)
    rows = []
    for k in range(int(which.max()) + 1):
        inside = which == k
        counts = np.bincount(test[inside], minlength=test.max() + 1)
        used = counts > 0
        n = int(used.sum())
        if n < 2:
            continue
        means = (
            np.bincount(test[inside], weights=residual[inside], minlength=len(counts))[used] / counts[used]
        )
        half = float(stats.t.ppf(0.975, n - 1) * means.std(ddof=1) / np.sqrt(n))
        rows.append((float(load[inside].mean()), float(means.mean()), half, n))
    table = np.array(rows, dtype=float).reshape(-1, 4)
    return BinnedResidual(table[:, 0], table[:, 1], table[:, 2], table[:, 3].astype(int))


def _bins(load: FloatArray, test: np.ndarray) -> np.ndarray:
    """Return the bin of each point: quantiles of the load, as many as leave `MIN_TESTS` tests in each."""
    for count in range(BINS, 0, -1):
        edges = np.unique(np.quantile(load, np.linspace(0.0, 1.0, count + 1)))
        which = np.clip(np.searchsorted(edges, load, side="right") - 1, 0, max(len(edges) - 2, 0))
        present = [len(np.unique(test[which == k])) for k in range(int(which.max()) + 1)]
        if min(present) >= MIN_TESTS:
            break
    return which
