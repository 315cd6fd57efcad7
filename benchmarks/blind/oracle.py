"""What an oracle sees that knows the covariance of the noise and the shape of what is hidden.

All values are averages over twelve stretches of each test. The covariance comes from draws of the noise recipe itself,
not from a model of it. What the base model can follow is taken out by generalised least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, ncx2

from benchmarks.blind.campaign import Array, Bins, Campaign, Rng, bins_of
from benchmarks.blind.noise import Recipe

DRAWS = 150


def detectable(level: float = 0.05, power: float = 0.8) -> float:
    """Non-centrality that a chi-square test of one known shape needs."""
    low, high = 0.0, 100.0
    critical = float(chi2.isf(level, 1))
    for _ in range(60):
        middle = (low + high) / 2
        if ncx2.sf(critical, 1, middle) < power:
            low = middle
        else:
            high = middle
    return high


LIMIT = detectable()


@dataclass(frozen=True)
class Oracle:
    """Whitens columns and projects out what the base follows."""

    bins: Bins
    factors: list[Array]
    base: Array
    variance: float = 0.0

    @classmethod
    def of(cls, c: Campaign, mu: Array, recipe: Recipe, design: Array, rng: Rng) -> Oracle:
        """Draw the noise and estimate second moments of each test: a bias, such as that of rounding, counts as noise."""
        bins = bins_of(c)
        noise = np.stack([bins.mean(recipe(rng, c, mu) - mu) for _ in range(DRAWS)])
        factors: list[Array] = []
        for k in range(len(c.tests)):
            own = noise[:, bins.test == k]
            cov = own.T @ own / DRAWS
            cov += np.diag(0.03 * np.diag(cov) + 0.01 * np.diag(cov).mean() + 1e-9)
            factors.append(np.asarray(np.linalg.cholesky(cov), np.float64))
        variance = float(np.mean(noise**2))
        plain = cls(bins, factors, np.zeros((len(bins.count), 0)))
        q, r = np.linalg.qr(plain.whiten(design))
        keep = np.abs(np.diag(r)) > 1e-9 * np.abs(np.diag(r)).max()
        return cls(bins, factors, q[:, keep], variance)

    def whiten(self, values: Array) -> Array:
        """Bin and whiten columns (rows are points)."""
        binned = self.bins.mean(values.reshape(len(values), -1))
        out = np.empty_like(binned)
        for k, lower in enumerate(self.factors):
            rows = self.bins.test == k
            out[rows] = np.linalg.solve(lower, binned[rows])
        return out

    def project(self, values: Array, beside: Array | None = None) -> Array:
        """Whitened columns without what the base (and further whitened columns) can follow."""
        w = self.whiten(values)
        basis = self.base
        if beside is not None and beside.size:
            q, _ = np.linalg.qr(np.hstack([basis, beside]))
            basis = q
        return w - basis @ (basis.T @ w)


def raw_share(oracle: Oracle, design: Array, term: Array) -> float:
    """Share of the variance of the averages, base taken out by least squares, that a term makes beside the noise."""
    x, z = oracle.bins.mean(design), oracle.bins.mean(term)
    rest = z - x @ np.linalg.lstsq(x, z, rcond=None)[0]
    square = float(np.mean(rest**2))
    return square / (square + oracle.variance)


def share_explained(target: Array, rival: Array, one_sided: bool) -> float:
    """Share of a whitened target's square that a whitened rival explains; its first amplitude may not be negative."""
    norms = np.linalg.norm(rival, axis=0)
    rival = rival[:, norms > 1e-8]
    if not rival.shape[1]:
        return 0.0
    amplitude, *_ = np.linalg.lstsq(rival, target, rcond=None)
    if one_sided and amplitude[0] < 0:
        return 0.0
    total = float(target @ target)
    return 1 - float(np.sum((target - rival @ amplitude) ** 2)) / total if total > 0 else 0.0
