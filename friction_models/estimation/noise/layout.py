"""Bins of all tests side by side: padded arrays, their covariance, inverses of its roots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...loads import FloatArray
from ..campaign.binned_tests import BinnedTests

#: Factor on the variance of a bin that is left out.
NO_WEIGHT = 1e6
#: Rows of triangular matrices that are inverted row by row, in all tests at once.
SMALL = 12


@dataclass(frozen=True)
class Layout:
    """Bins of all tests as padded arrays [tests, slots]."""

    #: Where each bin stands, shape (m,).
    test: npt.NDArray[np.intp]
    slot: npt.NDArray[np.intp]
    shape: tuple[int, int]  #: Tests and slots.
    gaps: FloatArray  #: Distances between bins of a test [mm], shape (tests, slots, slots).
    weight: FloatArray  #: 1/points, 0 where there is no bin, shape (tests, slots).
    present: npt.NDArray[np.bool_]  #: Shape (tests, slots).

    @classmethod
    def of(cls, campaign: BinnedTests) -> Layout:
        """Return the layout of the bins of a campaign."""
        shape = (len(campaign.tests), int(campaign.slot.max()) + 1)
        at = (campaign.test, campaign.slot)
        distance, weight = np.zeros(shape), np.zeros(shape)
        distance[at] = campaign.average(campaign.distance)
        weight[at] = 1.0 / campaign.count
        if campaign.distrusted is not None:
            weight[at] *= np.where(campaign.distrusted, NO_WEIGHT, 1.0)
        present = weight > 0
        return cls(*at, shape, np.abs(distance[:, :, None] - distance[:, None, :]), weight, present)

    def subset(self, tests: npt.NDArray[np.intp]) -> tuple[Layout, npt.NDArray[np.bool_]]:
        """Return the layout of some tests, and which bins belong to it."""
        rows = np.isin(self.test, tests)
        test = np.searchsorted(tests, self.test[rows])
        shape = (len(tests), self.shape[1])
        part = Layout(test, self.slot[rows], shape, self.gaps[tests], self.weight[tests], self.present[tests])
        return part, rows

    def pad(self, values: FloatArray) -> FloatArray:
        """Return [tests, slots, k] from [m, k]."""
        padded = np.zeros((*self.shape, values.shape[1]))
        padded[self.test, self.slot] = values
        return padded

    def covariance(self, s_b: float, s_d: float, length: float, s_w: float) -> FloatArray:
        """Return the covariance of every test, [tests, slots, slots]; identity where there is no bin."""
        both = self.present[:, :, None] & self.present[:, None, :]
        S = np.where(both, s_b**2 + s_d**2 * np.exp(-self.gaps / length), 0.0)
        diagonal = np.where(self.present, s_w**2 * self.weight, 1.0)
        index = np.arange(self.shape[1])
        S[:, index, index] += diagonal
        return S


def inverse_of_roots(roots: FloatArray, out: FloatArray | None = None) -> FloatArray:
    """Return the inverses of lower triangular matrices, shape (tests, slots, slots), halving them until they are small.

    For stacks of them this takes a third of the time of `numpy.linalg.inv`, which knows nothing of triangles. They are written to
    the lower triangles of `out`, if it is given.

    Examples
    --------
    >>> inverse_of_roots(np.array([[[2.0, 0.0], [1.0, 4.0]]]))
    array([[[ 0.5  ,  0.   ],
            [-0.125,  0.25 ]]])
    """
    size = roots.shape[1]
    found = np.zeros_like(roots) if out is None else out
    if size <= SMALL:
        for k in range(size):
            own = 1.0 / roots[:, k, k]
            found[:, k, k] = own
            if k:
                found[:, k, :k] = -own[:, None] * (roots[:, k : k + 1, :k] @ found[:, :k, :k])[:, 0]
        return found
    half = size // 2
    upper = inverse_of_roots(roots[:, :half, :half], found[:, :half, :half])
    lower = inverse_of_roots(roots[:, half:, half:], found[:, half:, half:])
    found[:, half:, :half] = -lower @ (roots[:, half:, :half] @ upper)
    return found
