"""Scan: how much of the whitened residual each candidate effect explains beyond the base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...effects.base import Effect
from ...loads import FloatArray
from .candidates import Candidate

#: Least share of a candidate's whitened variation that the base must leave, else it cannot be seen. Noise within tests is so
#: small that a slope along them may outweigh all that sets the tests apart.
VISIBLE = 1e-4
#: A correct instrument is the better bet: what a fault must explain beyond a physical effect.
FAULT_PENALTY = 3.0


@dataclass
class Prepared:
    """A candidate after whitening and after the base has been projected out."""

    candidate: Candidate
    columns: FloatArray  #: Whitened, projected, shape (m, g, amplitudes).
    gram: FloatArray  #: Shape (g, amplitudes, amplitudes).
    usable: np.ndarray  #: Whether enough of a column is left beside the base, shape (g, amplitudes).

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.candidate.effect.name

    @property
    def signs(self) -> FloatArray:
        """Physical signs of the amplitudes."""
        return np.array([a.sign for a in self.candidate.effect.amplitudes], dtype=float)

    @property
    def penalty(self) -> float:
        """Two per degree of freedom; a fault of the data has to beat its physical twins by more."""
        fault = FAULT_PENALTY if self.candidate.effect.kind == "fault" else 0.0
        return 2.0 * self.candidate.effect.degrees_of_freedom + fault


@dataclass
class Fit:
    """The best parameters of one effect."""

    prepared: Prepared
    index: int  #: Which set of shape parameters.
    amplitudes: FloatArray  #: Shape (amplitudes,).
    #: Drop of the whitened sum of squares minus two per degree of freedom; at most 0 for a useless effect.
    gain: float
    evidence: float  #: The gain where the form of the effect may be somewhat wrong.

    @property
    def effect(self) -> Effect:
        """The effect."""
        return self.prepared.candidate.effect

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name

    @property
    def columns(self) -> FloatArray:
        """Basis in the bins, shape (m, amplitudes)."""
        return self.prepared.candidate.columns[:, self.index]

    @property
    def signal(self) -> FloatArray:
        """Whitened, projected contribution, shape (m,)."""
        return self.prepared.columns[:, self.index] @ self.amplitudes

    @property
    def binned(self) -> FloatArray:
        """Contribution to mu in the bins, shape (m,)."""
        return self.columns @ self.amplitudes

    @property
    def shape(self) -> dict[str, float]:
        """Shape parameters."""
        return self.prepared.candidate.shape_at(self.index)


class Projector:
    """Removes the whitened base from whitened columns."""

    def __init__(self, base: FloatArray) -> None:
        norms = np.linalg.norm(base, axis=0)
        if not np.any(norms > 0):
            self.q = np.empty((len(base), 0))
            return
        u, s, _ = np.linalg.svd(base[:, norms > 0] / norms[norms > 0], full_matrices=False)
        self.q = u[:, s > 1e-7 * s[0]]

    def __call__(self, columns: FloatArray) -> FloatArray:
        """Return what the base leaves of `columns`, shape (m,) or (m, ...)."""
        flat = columns.reshape(len(columns), -1)
        return (flat - self.q @ (self.q.T @ flat)).reshape(columns.shape)


def prepare_candidate(candidate: Candidate, whiten: object, project: Projector) -> Prepared:
    """Whiten a candidate and remove the base from it."""
    m, sets, amplitudes = candidate.columns.shape
    centred = candidate.columns - candidate.columns.mean(axis=0)
    white = whiten(candidate.columns.reshape(m, -1))  # type: ignore[operator]
    before = np.sum(whiten(centred.reshape(m, -1)) ** 2, axis=0)  # type: ignore[operator]
    columns = project(white)
    after = np.sum(columns**2, axis=0)
    usable = (after > VISIBLE * before) & (after > 1e-12)
    columns = columns.reshape(m, sets, amplitudes)
    gram = np.einsum("mga,mgb->gab", columns, columns)
    return Prepared(candidate, columns, gram, usable.reshape(sets, amplitudes))


def drops(prepared: Prepared, scores: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the drop of the sum of squares, shape (g, ...), and the amplitudes that reach it, shape (g, amplitudes, ...), signs respected.

    `scores`, shape (g, amplitudes, ...), are inner products of the columns with the data (or with many simulated data).
    """
    extra = (1,) * (scores.ndim - 2)
    signs, amplitudes = prepared.signs, np.zeros_like(scores)
    best = np.zeros((scores.shape[0], *scores.shape[2:]))
    for k in range(scores.shape[1]):
        square = prepared.gram[:, k, k]
        ok = prepared.usable[:, k]
        a = scores[:, k] / np.where(ok, square, 1.0).reshape(-1, *extra)
        gain = np.where(_allowed(a, signs[k]) & ok.reshape(-1, *extra), a * scores[:, k], 0.0)
        better = gain > best
        best = np.where(better, gain, best)
        for j in range(scores.shape[1]):
            amplitudes[:, j] = np.where(better, a if j == k else 0.0, amplitudes[:, j])
    if scores.shape[1] == 2:
        g = prepared.gram
        determinant = g[:, 0, 0] * g[:, 1, 1] - g[:, 0, 1] ** 2
        ok = prepared.usable.all(axis=1) & (determinant > 1e-6 * g[:, 0, 0] * g[:, 1, 1])
        d = np.where(ok, determinant, 1.0).reshape(-1, *extra)
        g00, g01, g11 = (v.reshape(-1, *extra) for v in (g[:, 0, 0], g[:, 0, 1], g[:, 1, 1]))
        a0 = (g11 * scores[:, 0] - g01 * scores[:, 1]) / d
        a1 = (g00 * scores[:, 1] - g01 * scores[:, 0]) / d
        both = _allowed(a0, signs[0]) & _allowed(a1, signs[1]) & ok.reshape(-1, *extra)
        gain = np.where(both, a0 * scores[:, 0] + a1 * scores[:, 1], 0.0)
        better = gain > best
        best = np.where(better, gain, best)
        amplitudes[:, 0] = np.where(better, a0, amplitudes[:, 0])
        amplitudes[:, 1] = np.where(better, a1, amplitudes[:, 1])
    return best, amplitudes


def _allowed(amplitude: FloatArray, sign: float) -> np.ndarray:
    return amplitude * sign >= 0.0 if sign else np.ones(amplitude.shape, dtype=bool)


def best_fit(prepared: Prepared, residual: FloatArray) -> Fit:
    """Return the best parameters of one effect for a whitened residual, shape (m,)."""
    scores = np.einsum("mga,m->ga", prepared.columns, residual)
    drop, amplitudes = drops(prepared, scores)
    index = int(np.argmax(drop))
    gain = float(drop[index]) - prepared.penalty
    return Fit(prepared, index, amplitudes[index], gain, gain)


def rank(candidates: list[Prepared], residual: FloatArray) -> list[Fit]:
    """Return the best fit of every effect, the largest gain first."""
    return sorted((best_fit(c, residual) for c in candidates), key=lambda f: -f.gain)
