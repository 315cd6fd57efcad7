"""Force-stroke curves on a common stroke: fingerprints of causes, and the scatter of repeats and of the mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from friction_models.loads import FloatArray, InputError

from .attribution_causes import Cause
from .attribution_runs import Sensitivities
from .forces import WINDOW, ForceCurve

if TYPE_CHECKING:
    from forming.press import PressLevel

#: Places along the stroke at which curves are compared.
PLACES = 32
#: Least that a mesh moves a curve by, relative to its largest force: slowly along the stroke, and at random.
MESH_ERROR = (0.002, 0.001)
#: Independent pieces of its error that one other mesh shows along a stroke: so few know their size poorly.
MESH_FREEDOM = 4.0
#: Share of the stroke over which relative sensitivities are smoothed: meshes make them ripple.
SMOOTH = 0.08
#: Scatter of the force that is assumed where nothing was repeated.
ASSUMED_SCATTER = 0.01
#: Shift of the stroke [mm] by which causes of the press are moved for their sensitivity.
SHIFT = 0.02
#: Causes of the press that bend the stroke: their change is not in proportion to their strength.
BENT = ("compliance", "stroke_zero")


@dataclass(frozen=True)
class Level:
    """One level of the press on a common stroke.

    Attributes
    ----------
    name : str
    stroke, simulated, measured : ndarray, shape (n,)
        Stroke [mm] and forces [kN].
    window : float
        Stroke over which the forces are averaged [mm].
    curve : ForceCurve
        The simulated curve as it was recorded.
    deviations : ndarray, shape (repeats, n)
        Of each repeat from their mean [kN].
    """

    name: str
    stroke: FloatArray
    window: float
    simulated: FloatArray
    measured: FloatArray
    deviations: FloatArray
    curve: ForceCurve


def on_common_stroke(level: PressLevel, simulated: ForceCurve, mesh_size: float = 0.0) -> Level:
    """Return measured and simulated force at the same strokes, both averaged over a mesh size at least.

    Raises
    ------
    InputError
        Less than 0.5 mm of stroke in common.
    """
    repeats = [ForceCurve(c["stroke"].to_numpy(), c["force"].to_numpy()) for c in level.repeats]
    start = max(simulated.stroke[0], *(c.stroke[0] for c in repeats))
    end = min(simulated.stroke[-1], *(c.stroke[-1] for c in repeats))
    if end - start < 0.5:
        raise InputError(
            f"{level.file}: {max(end - start, 0.0):.2f} mm of stroke in common with the simulation; allowed: at least 0.5 mm"
        )
    grid = np.linspace(start, end, PLACES)
    window = max(WINDOW, mesh_size)
    force = averaged(simulated, grid, window)
    each = np.array([averaged(c, grid, window) for c in repeats])
    mean = each.mean(axis=0)
    return Level(level.file, grid, window, force, mean, each - mean, simulated)


def averaged(curve: ForceCurve, grid: FloatArray, window: float) -> FloatArray:
    """Return the force on `grid`, averaged over `window` [mm] (narrower at the ends)."""
    half = np.minimum(window / 2, np.minimum(grid - grid[0], grid[-1] - grid))
    fine = curve.on(np.linspace(grid[0], grid[-1], 8 * len(grid) + 1))
    at = np.linspace(grid[0], grid[-1], len(fine))
    area = np.concatenate([[0.0], np.cumsum(0.5 * (fine[1:] + fine[:-1]) * np.diff(at))])
    wide = half > 1e-9
    mean = np.interp(grid, at, fine)
    ends = [np.interp(grid[wide] + side * half[wide], at, area) for side in (-1.0, 1.0)]
    mean[wide] = (ends[1] - ends[0]) / (2.0 * half[wide])
    return mean


def fingerprint(
    cause: Cause, levels: Sequence[Level], found: Sensitivities, strength: float | None = None
) -> list[FloatArray]:
    """Return the change of the force at every level for a strength of one [kN].

    Causes of the press bend the stroke, which is far from linear where the force rises steeply: with a `strength`
    their change is that of this strength, divided by it.
    """
    if cause.name == "force_gain":
        return [v.simulated for v in levels]
    if cause.name in BENT:
        return [_bent(cause.name, v, strength) for v in levels]
    prints = []
    for v, moved in zip(levels, found.moved[cause.key], strict=True):
        change = averaged(moved, v.stroke, v.window) - v.simulated
        near = np.exp(-0.5 * ((v.stroke[:, None] - v.stroke) / (SMOOTH * np.ptp(v.stroke))) ** 2)
        relative = near @ (v.simulated * change) / np.maximum(near @ v.simulated**2, 1e-12)
        prints.append(relative * v.simulated / cause.step)
    return prints


def mesh_error(levels: Sequence[Level], found: Sensitivities) -> tuple[float, float]:
    """Return the slow and the random error of the mesh, relative to the largest force."""
    slow, white = 0.0, 0.0
    for v, other in zip(levels, found.remeshed, strict=False):
        change = (averaged(other, v.stroke, v.window) - v.simulated) / v.simulated.max()
        noise = float(np.mean(np.diff(change, 2) ** 2)) / 6.0
        white += noise / len(levels)
        slow += max(float(np.mean(change**2)) - noise, 0.0) / len(levels)
    wide = MESH_FREEDOM / (MESH_FREEDOM - 2.0)
    return max(MESH_ERROR[0], float(np.sqrt(wide * slow))), max(MESH_ERROR[1], float(np.sqrt(wide * white)))


def whiteners(levels: Sequence[Level], mesh: tuple[float, float], notes: list[str]) -> list[FloatArray]:
    """Return a matrix for each level that turns its mean curve into independent numbers of variance one.

    A billet, or its lubricant, shifts a whole curve in proportion to the force; beside that curves differ
    slowly along the stroke, and by sensor noise. Meshes differ too: their error is on top.
    """
    gains, slow, white, freedom = 0.0, 0.0, 0.0, 0
    for v in levels:
        share = v.deviations @ v.simulated / float(v.simulated @ v.simulated)
        rest = (v.deviations - share[:, None] * v.simulated) / v.simulated.max()
        noise = float(np.mean(np.diff(rest, 2, axis=1) ** 2)) / 6.0
        gains += float(share @ share)
        slow += float(np.sum(np.mean(rest**2, axis=1)))
        white += noise * len(rest)
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
    result = []
    for v in levels:
        n, top = max(len(v.deviations), 1), float(v.simulated.max())
        gap = np.abs(v.stroke[:, None] - v.stroke[None, :]) / float(np.ptp(v.stroke))
        S = gains * np.outer(v.simulated, v.simulated)
        S = S + top**2 * (slow * np.exp(-gap / 0.3) + white * np.eye(len(v.stroke)))
        S = S / n + top**2 * (mesh[0] ** 2 * np.exp(-gap / 0.15) + mesh[1] ** 2 * np.eye(len(v.stroke)))
        result.append(np.linalg.inv(np.linalg.cholesky(S)))
    return result


def _bent(name: str, level: Level, strength: float | None) -> FloatArray:
    """Return the change of the force for a give of press and tools [mm/kN], or a zero of the stroke [mm], of one."""
    stroke, force = level.curve.stroke, level.curve.force
    along = force if name == "compliance" else np.ones_like(force)
    size = strength or SHIFT / float(np.abs(along).max())
    # the sensor reads the travel of the tool and what press and tools give
    read = ForceCurve(np.maximum.accumulate(stroke + size * along), force)
    return (averaged(read, level.stroke, level.window) - level.simulated) / size


def unwhitened(values: FloatArray, whiten: Sequence[FloatArray]) -> FloatArray:
    """Return whitened values of all levels as forces again [kN]."""
    parts = np.split(values, np.cumsum([len(w) for w in whiten])[:-1])
    return np.concatenate([np.linalg.solve(w, p) for w, p in zip(whiten, parts, strict=True)])
