"""Surface expansion along a test: its mean, and a course over the distance that the tests share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...loads import FloatArray

#: Places of the course, at equal shares of the points.
PLACES = 12
#: Smaller mean expansions say nothing of a course.
LEAST = 1e-3


@dataclass(frozen=True)
class Stretching:
    """``psi = 1 + (mean - 1) course(sd)``; beyond the longest test it stays where it was."""

    sd: FloatArray  #: Places [mm], shape (k,).
    course: FloatArray  #: Of the mean expansion of a test, shape (k,).

    @classmethod
    def learn(cls, campaign: BinnedTests) -> Stretching:
        """Return the course of tests, by medians; 1 everywhere where no surface grows."""
        psi = campaign.loads.psi
        mean = campaign.mean_at_points(psi) - 1.0
        grown = np.abs(mean) > LEAST
        if np.count_nonzero(grown) < PLACES:
            return cls(np.zeros(1), np.ones(1))
        sd, course = campaign.loads.sd[grown], (psi[grown] - 1.0) / mean[grown]
        parts = np.array_split(np.argsort(sd, kind="stable"), PLACES)
        medians = np.array([[np.median(sd[p]), np.median(course[p])] for p in parts])
        return cls(medians[:, 0], medians[:, 1])

    def along(self, mean: float, sd: FloatArray) -> FloatArray:
        """Return the expansion at distances along a test of this mean expansion."""
        return 1.0 + (mean - 1.0) * np.interp(sd, self.sd, self.course)
