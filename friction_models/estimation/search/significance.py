"""Significance: family-wise p-values by parametric bootstrap, and rivals that the data cannot rule out."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ...loads import FloatArray
from .scan import Fit, Prepared, Projector, drops

#: Inner products of each effect's columns with simulated noise, shape (g, amplitudes, replicates) each.
Simulated: TypeAlias = dict[str, FloatArray]

REPLICATES = 499
#: Tests from which on the signs of whole tests are drawn, instead of normal noise.
FLIPPED = 20
#: Contributions that correlate by more than this count as one.
TWINS = 0.98
#: A lead below this share of the winner's evidence may come from the formulas rather than from the mechanisms.
SAME = 0.02


def null_noise(
    residual: FloatArray, test: npt.NDArray[np.intp], freedom: float, rng: np.random.Generator, count: int
) -> FloatArray:
    """Return whitened data in which nothing is missing, shape (m, count); `test` is the place of the test of each bin.

    The residual of every whole test with a random sign (wild bootstrap; Cameron, Gelbach, Miller, Rev. Econ. Stat. 90
    (2008)): tests that scatter more, skewed noise, heavy tails and single odd tests stay as they are. With few tests there
    are too few signs: normal noise then, whose scale varies as that of a floor that was estimated with `freedom`.
    """
    tests = int(test.max()) + 1
    if tests >= FLIPPED:
        signs = rng.choice([-1.0, 1.0], (tests, count))
        return residual[:, None] * signs[test]
    noise = np.empty((len(residual), count))
    noise[np.argsort(test, kind="stable")] = rng.standard_normal(noise.shape)
    return np.asarray(noise * np.sqrt(freedom / rng.chisquare(freedom, count)))


def simulate(candidates: list[Prepared], project: Projector, noise: FloatArray) -> Simulated:
    """Return what every candidate sees of noise, shape (m, replicates)."""
    noise = project(noise)
    return {c.name: _products(c.columns, noise) for c in candidates}


def _products(columns: FloatArray, noise: FloatArray) -> FloatArray:
    """Return inner products of columns [m, g, amplitudes] with noise [m, replicates], one matrix product."""
    m, sets, amplitudes = columns.shape
    return (columns.reshape(m, -1).T @ noise).reshape(sets, amplitudes, -1)


def maximum_gains(candidates: list[Prepared], simulated: Simulated) -> FloatArray:
    """Return the largest gain of any effect in each replicate of pure noise, shape (replicates,)."""
    gains = [drops(c, simulated[c.name])[0].max(axis=0) - c.penalty for c in candidates]
    return np.max(gains, axis=0)


def p_value(gain: float, null: FloatArray) -> float:
    """Return the share of replicates without any effect that gain as much."""
    return float((1 + np.sum(null >= gain)) / (1 + null.size))


def confusion_set(ranking: list[Fit], simulated: Simulated, level: float = 0.05) -> list[str]:
    """Return the effects that the data cannot tell from the winner, the winner first.

    For each rival, data are simulated from its own fit. It stays in the set if the winner leads by as much as observed in
    more than `level` of these data. Noise hardly matters beside a strong effect; a small lead then only shows which formula
    happens to fit better, so it does not count.
    """
    winner = ranking[0]
    kept = [winner.name]
    for rival in ranking[1:]:
        if rival.gain <= 0.25 * winner.gain:
            continue
        if alike(winner, rival) > TWINS or winner.evidence - rival.evidence < SAME * winner.evidence:
            kept.append(rival.name)
            continue
        signal = rival.signal
        lead = _gains(winner.prepared, signal, simulated) - _gains(rival.prepared, signal, simulated)
        if float(np.mean(lead >= winner.gain - rival.gain)) > level:
            kept.append(rival.name)
    return kept


def alike(first: Fit, second: Fit) -> float:
    """Return the correlation of two fitted contributions in the data, beyond the base."""
    a, b = first.signal, second.signal
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0 else 0.0


def stays_first(ranking: list[Fit], simulated: Simulated) -> float:
    """Return how often the winner comes first again in data simulated from its own fit."""
    winner = ranking[0]
    own = _gains(winner.prepared, winner.signal, simulated)
    others = [_gains(r.prepared, winner.signal, simulated) for r in ranking[1:8]]
    return float(np.mean(own > np.max(others, axis=0))) if others else 1.0


def _gains(prepared: Prepared, signal: FloatArray, simulated: Simulated) -> FloatArray:
    scores = simulated[prepared.name] + np.einsum("mga,m->ga", prepared.columns, signal)[:, :, None]
    return drops(prepared, scores)[0].max(axis=0) - prepared.penalty
