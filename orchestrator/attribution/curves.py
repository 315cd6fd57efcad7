"""Force-stroke curves on a common stroke, and fingerprints of causes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from forming.press import PressLevel
from friction_models.common import InputError
from friction_models.loads import FloatArray

from ..force_curves.forces import WINDOW, ForceCurve
from .causes import Cause
from .sensitivities import Sensitivities

#: Places along the stroke at which curves are compared.
PLACES = 32
#: Share of the stroke over which relative sensitivities are smoothed: meshes make them ripple.
SMOOTH = 0.08
#: Shift of the stroke [mm] by which causes of the press are moved for their sensitivity.
SHIFT = 0.02
#: Causes of the press that bend the stroke: their change is not in proportion to their strength.
BENT = ("compliance", "stroke_zero")


@dataclass(frozen=True)
class LevelForces:
    """One level of the press on a common stroke [mm] of n places; forces in kN."""

    name: str
    stroke: FloatArray  # shape (n,)
    window: float  # stroke over which the forces are averaged
    simulated: FloatArray  # shape (n,)
    measured: FloatArray  # shape (n,), mean of the repeats
    deviations: FloatArray  # shape (repeats, n), of each repeat from their mean
    curve: ForceCurve  # the simulated one as it was recorded
    process: str = ""  # levels of one process share the error of the mesh


def on_common_stroke(level: PressLevel, simulated: ForceCurve, mesh_size: float = 0.0) -> LevelForces:
    """Return measured and simulated force at the same strokes, both averaged over a mesh size [mm] at least."""
    repeats = [ForceCurve(c["stroke"].to_numpy(), c["force"].to_numpy()) for c in level.repeats]
    start = max(simulated.stroke[0], *(c.stroke[0] for c in repeats))
    end = min(simulated.stroke[-1], *(c.stroke[-1] for c in repeats))
    if end - start < 0.5:
        raise InputError(
            f"{level.file}: {max(end - start, 0.0):.2f} mm of stroke in common with the simulation; allowed: at least 0.5 mm"
        )
    window = min(max(WINDOW, mesh_size), (end - start) / 2)
    # whole windows only: where they are cut off at an end, a single element that enters contact shows
    grid = np.linspace(start + window / 2, end - window / 2, PLACES)
    force = averaged(simulated, grid, window)
    each = np.array([averaged(c, grid, window) for c in repeats])
    mean = each.mean(axis=0)
    return LevelForces(level.file, grid, window, force, mean, each - mean, simulated, level.process)


def averaged(curve: ForceCurve, grid: FloatArray, window: float) -> FloatArray:
    """Return the force on `grid`, averaged over `window` [mm] (narrower at the ends of the curve).

    Examples
    --------
    A ramp stays as it is:

    >>> averaged(ForceCurve([0.0, 10.0], [0.0, 100.0]), np.array([2.0, 5.0]), window=1.0).round(6)
    array([20., 50.])
    """
    low, high = float(curve.stroke[0]), float(curve.stroke[-1])
    half = np.clip(np.minimum(grid - low, high - grid), 0.0, window / 2)
    at = np.linspace(max(low, grid[0] - window / 2), min(high, grid[-1] + window / 2), 8 * len(grid) + 1)
    fine = curve.on(at)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (fine[1:] + fine[:-1]) * np.diff(at))])
    wide = half > 1e-9
    mean = np.interp(grid, at, fine)
    ends = [np.interp(grid[wide] + side * half[wide], at, area) for side in (-1.0, 1.0)]
    mean[wide] = (ends[1] - ends[0]) / (2.0 * half[wide])
    return mean


def fingerprint(
    cause: Cause, levels: Sequence[LevelForces], found: Sensitivities, strength: float | None = None
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


def _bent(name: str, level: LevelForces, strength: float | None) -> FloatArray:
    """Return the change of the force for a give of press and tools [mm/kN], or a zero of the stroke [mm], of one."""
    stroke, force = level.curve.stroke, level.curve.force
    along = force if name == "compliance" else np.ones_like(force)
    size = strength or SHIFT / float(np.abs(along).max())
    # the sensor reads the travel of the tool and what press and tools give
    read = ForceCurve(np.maximum.accumulate(stroke + size * along), force)
    return (averaged(read, level.stroke, level.window) - level.simulated) / size
