"""What the outcome of a test is worth: by how many bits it is expected to reduce the entropy of the answer.

Every hypothesis predicts the outcome as a mixture of normal distributions. Outcomes are drawn from all of them; the expected
entropy of the posterior is a mean over these draws (Lindley, Ann. Math. Stat. 27 (1956) 986).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ...estimation.noise.regular import regular_root
from ...loads import FloatArray

#: Draws of outcomes, about.
DRAWS = 400
#: Largest separation that is promised.
MOST = 50.0


@dataclass(frozen=True)
class Outcomes:
    """What hypotheses predict of the outcome of one or several tests.

    Examples
    --------
    Two equal rivals that predict means ten standard deviations apart: a test tells everything, one bit.

    >>> import numpy as np
    >>> apart = Outcomes(np.full(2, 0.5), np.arange(2), np.ones(2), np.array([[0.0], [10.0]]), np.ones((2, 1, 1)))
    >>> round(apart.reduction, 3), round(apart.separation(0, 1))
    (1.0, 10)
    """

    prior: FloatArray  #: Probability of each hypothesis; their sum is 1. Shape (h,).
    owner: npt.NDArray[np.intp]  #: Hypothesis of each normal distribution, shape (c,).
    share: FloatArray  #: Its share in the mixture of the hypothesis, shape (c,).
    mean: FloatArray  #: Shape (c, n).
    covariance: FloatArray  #: Shape (c, n, n).
    #: How much of a lead of each hypothesis over each other one may be a matter of formulas, shape (h, h).
    owed: FloatArray | None = None

    @cached_property
    def _drawn(self) -> tuple[npt.NDArray[np.intp], FloatArray, FloatArray]:
        """Return which distribution each outcome comes from, its weight, and its log density by hypothesis [draws, h]."""
        count, n = self.mean.shape
        each = max(DRAWS // count // 2, 2)
        root = regular_root(self.covariance)
        half = np.random.default_rng(0).standard_normal(
            (each, n)
        )  # the same for all tests: they are compared
        normal = np.concatenate([half, -half])
        drawn = (self.mean[:, None] + np.einsum("cij,sj->csi", root, normal)).reshape(-1, n)
        inverse = np.linalg.inv(root)
        white = (drawn - self.mean[:, None]) @ inverse.transpose(0, 2, 1)
        size = np.log(np.diagonal(inverse, axis1=1, axis2=2)).sum(axis=1)
        density = size - 0.5 * np.einsum("csi,csi->sc", white, white)
        density += np.log(self.share)
        by_hypothesis = np.stack(
            [np.logaddexp.reduce(density[:, self.owner == h], axis=1) for h in range(len(self.prior))], axis=1
        )
        source = np.repeat(np.arange(count), 2 * each)
        weight = (self.prior[self.owner] * self.share)[source] / (2 * each)
        return source, weight, by_hypothesis

    @property
    def reduction(self) -> float:
        """Expected reduction of the entropy of the answer [bits]."""
        return self._reduction(range(len(self.prior)))

    def pair_reduction(self, first: int, second: int) -> float:
        """The same if one of two hypotheses were the truth, times the probability that it is so [bits]."""
        return float(self.prior[first] + self.prior[second]) * self._reduction((first, second))

    def _reduction(self, among: Sequence[int]) -> float:
        chosen = list(among)
        source, weight, density = self._drawn
        prior = self.prior[chosen] / self.prior[chosen].sum()
        drawn = np.isin(self.owner[source], chosen)
        posterior = np.log(prior) + density[drawn][:, chosen]
        posterior = np.exp(posterior - np.logaddexp.reduce(posterior, axis=1)[:, None])
        expected = float(np.average(entropy(posterior), weights=weight[drawn]))
        return max(float(entropy(prior[None])[0]) - expected, 0.0)

    def separation(self, first: int, second: int) -> float:
        """Return by how many standard errors the true one of two hypotheses should lead after the test.

        The root of the lead that twice the logarithm of the likelihood shows, beyond what is owed to formulas: the median over the
        outcomes, whichever of the two is true, by their probabilities.
        """
        source, weight, density = self._drawn
        leads, weights = [], []
        for truth, rival in ((first, second), (second, first)):
            own = self.owner[source] == truth
            owed = 0.0 if self.owed is None else float(self.owed[truth, rival])
            leads.append(2.0 * (density[own, truth] - density[own, rival]) - owed)
            weights.append(weight[own])
        lead, share = np.concatenate(leads), np.concatenate(weights)
        order = np.argsort(lead)
        below = np.cumsum(share[order])
        middle = float(lead[order[min(int(np.searchsorted(below, 0.5 * below[-1])), len(order) - 1)]])
        return min(float(np.sqrt(max(middle, 0.0))), MOST)


def entropy(probabilities: FloatArray) -> FloatArray:
    """Return the entropy of each row of probabilities [bits].

    Examples
    --------
    >>> entropy(np.array([[0.5, 0.5, 0.0], [1.0, 0.0, 0.0]])).tolist()
    [1.0, 0.0]
    """
    safe = np.maximum(probabilities, 1e-300)
    return np.asarray(-np.sum(probabilities * np.log2(safe), axis=1) + 0.0)
