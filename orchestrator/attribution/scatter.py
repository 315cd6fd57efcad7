"""What force-stroke curves deviate by although nothing is wrong: scatter of the repeats, and error of the mesh.

Repeats scatter level by level. The error of a mesh does not: elements reach an edge at the same stroke whatever
speed and temperature are, so that all levels of a process share most of it, and it does not average out. Its size,
its length along the stroke and how much of it the levels share are taken from the user's own process on two meshes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import block_diag

from friction_models.loads import FloatArray

from ..force_curves.forces import ForceCurve
from .curves import LevelForces, averaged
from .sensitivities import OTHER_MESH, Sensitivities

#: What a mesh is assumed to move a curve by where no other mesh can be set, relative to its largest force.
ASSUMED_MESH = 0.005
#: Numerical noise of any curve (steps, averaging), relative to its largest force.
NOISE = 0.001
#: Scatter of the force that is assumed where nothing was repeated.
ASSUMED_SCATTER = 0.01
#: What is tried for the error of a mesh: length along the stroke as a share of it, share that the levels of a
#: process have in common, noise relative to the whole.
_LENGTHS, _SHARED, _NOISES = (0.07, 0.12, 0.2, 0.35, 0.6), (0.0, 0.5, 0.8, 0.95), (0.01, 0.05, 0.2)


@dataclass(frozen=True)
class Scatter:
    """How all N forces, one level after the other, deviate."""

    covariance: FloatArray  # shape (N, N) [kN2]
    factor: FloatArray  # its lower Cholesky factor [kN]
    deviation: FloatArray  # standard deviation of every force without drift, shape (N,) [kN]
    drift: FloatArray  # one standard deviation of what the mesh may shift all curves of a process by together [kN]

    @classmethod
    def of(cls, levels: Sequence[LevelForces], found: Sensitivities, notes: list[str]) -> Scatter:
        """Return scatter of the mean curves and error of the mesh together; notes what is poorly known."""
        waves, drifts = mesh_error(levels, found.remeshed, notes)
        own = repeats(levels, notes) + waves
        S = own + drifts @ drifts.T
        drift = np.sqrt(np.sum(drifts**2, axis=1))
        return cls(S, np.asarray(np.linalg.cholesky(S), dtype=np.float64), np.sqrt(np.diag(own)), drift)

    def whitened(self, forces: Sequence[FloatArray]) -> FloatArray:
        """Return the forces of all levels as independent numbers of variance one."""
        return np.asarray(np.linalg.solve(self.factor, np.concatenate(forces)))


def repeats(levels: Sequence[LevelForces], notes: list[str]) -> FloatArray:
    """Return the covariance of the mean curves of the repeats [kN2].

    A billet, or its lubricant, shifts a whole curve in proportion to the force; beside that curves differ
    slowly along the stroke, and by sensor noise.
    """
    gains, slow, white, freedom = 0.0, 0.0, 0.0, 0
    for v in levels:
        share = v.deviations @ v.simulated / float(v.simulated @ v.simulated)
        rest = (v.deviations - share[:, None] * v.simulated) / v.simulated.max()
        gains += float(share @ share)
        slow += float(np.sum(np.mean(rest**2, axis=1)))
        white += float(np.mean(np.diff(rest, 2, axis=1) ** 2)) / 6.0 * len(rest)
        freedom += len(rest) - 1
    if freedom < 1:
        notes.append(
            f"no level was repeated: a scatter of {100 * ASSUMED_SCATTER:g} % of the force is assumed, nothing is certain"
        )
        gains, slow, white = ASSUMED_SCATTER**2, (0.5 * ASSUMED_SCATTER) ** 2, 1e-6
    else:
        wide = freedom / max(freedom - 2.0, 1.0)  # few repeats know their own scatter poorly
        gains, slow, white = gains / freedom * wide, slow / freedom * wide, white / freedom * wide
        if freedom < 4:
            notes.append("few repeats: their scatter is poorly known")
    blocks = []
    for v in levels:
        n, top = max(len(v.deviations), 1), float(v.simulated.max())
        gap = np.abs(v.stroke[:, None] - v.stroke[None, :]) / float(np.ptp(v.stroke))
        S = gains * np.outer(v.simulated, v.simulated)
        blocks.append((S + top**2 * (slow * np.exp(-gap / 0.3) + white * np.eye(len(v.stroke)))) / n)
    return np.asarray(block_diag(*blocks))


def mesh_error(
    levels: Sequence[LevelForces], remeshed: Sequence[ForceCurve], notes: list[str]
) -> tuple[FloatArray, FloatArray]:
    """Return the error of the mesh in two parts: from another mesh, or assumed where there is none.

    The first, shape (N, N), is the covariance of waves along the stroke [kN2], whose size, length and share in common
    are those that make the difference of the two meshes most likely. The second, shape (N, processes), is the
    difference itself [kN], as large as convergence of first order would leave it between the mesh and the limit of
    small elements (Richardson's extrapolation): a shift of known shape and unknown strength.
    """
    top = np.concatenate([np.full(len(v.stroke), v.simulated.max()) for v in levels])
    waves = np.diag((NOISE * top) ** 2)
    if not remeshed:
        notes.append(
            f"the size of the elements cannot be set: an error of the mesh of {100 * ASSUMED_MESH:g} % of the force is assumed"
        )
    start = np.cumsum([0, *(len(v.stroke) for v in levels)])
    processes = list(dict.fromkeys(v.process for v in levels))
    drifts = np.zeros((len(top), len(processes)))
    for column, process in enumerate(processes):
        chosen = [k for k, v in enumerate(levels) if v.process == process]
        rows = np.concatenate([np.arange(start[k], start[k + 1]) for k in chosen])
        stroke = np.concatenate([levels[k].stroke for k in chosen])
        level = np.concatenate([np.full(len(levels[k].stroke), k) for k in chosen])
        if remeshed:
            change = [
                averaged(remeshed[k], levels[k].stroke, levels[k].window) - levels[k].simulated
                for k in chosen
            ]
            relative = np.concatenate(change) / top[rows]
            error = _waves(relative, stroke, level)
            drifts[rows, column] = relative * top[rows] / (1.0 - OTHER_MESH)
        else:
            error = ASSUMED_MESH**2 * _correlation(stroke, level, _LENGTHS[1], 1.0)
        waves[np.ix_(rows, rows)] += error * np.outer(top[rows], top[rows])
    return waves, drifts


def _waves(change: FloatArray, stroke: FloatArray, level: FloatArray) -> FloatArray:
    """Return the covariance under which the difference of two meshes is most likely."""
    best, likeliest = np.zeros((len(change), len(change))), -np.inf
    several = len(np.unique(level)) > 1
    for length, shared, noise in product(_LENGTHS, _SHARED if several else (0.0,), _NOISES):
        C = _correlation(stroke, level, length, shared) + noise * np.eye(len(stroke))
        L = np.linalg.cholesky(C)
        z = np.linalg.solve(L, change)
        variance = float(z @ z) / len(z) + 1e-300
        likelihood = -0.5 * len(z) * np.log(variance) - float(np.sum(np.log(np.diag(L))))
        if likelihood > likeliest:
            pieces = float(np.trace(C)) ** 2 / float(np.sum(C**2))
            # one difference shows only so many independent pieces, and knows their size accordingly
            best, likeliest = variance * max(pieces, 4.0) / (max(pieces, 4.0) - 2.0) * C, likelihood
    return best


def _correlation(stroke: FloatArray, level: FloatArray, length: float, shared: float) -> FloatArray:
    """Return a correlation that falls exponentially along the stroke; levels have `shared` of it in common.

    It takes curves to be rough: a smooth correlation would trust every kink of a difference that is smooth by chance.
    """
    gap = np.abs(stroke[:, None] - stroke[None, :]) / (length * float(np.ptp(stroke)))
    return np.asarray(np.where(level[:, None] == level[None, :], 1.0, shared) * np.exp(-gap))
