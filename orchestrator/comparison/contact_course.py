"""Loads and mu along the contact of a run, and at single points of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from friction_models.loads import LOADS, MU, FloatArray

from ..cosim.run_folders import Run

#: Contact points whose loads and mu are shown.
POINTS = 3


@dataclass(frozen=True)
class PointHistory:
    """Loads and mu of one contact point in one run."""

    point: int  # its number, from 1
    stroke: FloatArray  # [mm]
    #: By name of the loads contract, as long as the stroke; NaN where it touches nothing.
    values: Mapping[str, FloatArray]


@dataclass(frozen=True)
class ContactCourse:
    """Loads and mu along the contact of one run at n strokes."""

    stroke: FloatArray  # shape (n,) [mm]
    place: FloatArray  # shape (n, points), distance along the surface from the first point [mm], or numbers of the points
    #: By name of the loads contract, shape (n, points); NaN where a point touches nothing.
    values: Mapping[str, FloatArray]
    is_distance: bool  # False where the process does not say where its points are


def _touching(run: Run, process: str) -> npt.NDArray[np.bool_] | None:
    """Return which points touch the tool at each time, shape (steps + 1, points); None without contact points."""
    active = run.values.get(f"{process}.active")
    pressure = run.values.get(f"{process}.sigma_n")
    if pressure is None:
        return None
    found: npt.NDArray[np.bool_] = pressure > 0.0 if active is None else active > 0.5
    return found if found.ndim == 2 else found[:, None]


def shown_points(run: Run, process: str) -> list[int]:
    """Return points spread evenly along those that touch the tool longest: half as long as any at least."""
    touching = _touching(run, process)
    if touching is None or not touching.any():
        return []
    share = touching.sum(axis=0)
    long = np.flatnonzero(share >= 0.5 * share.max())
    places = np.linspace(0, len(long) - 1, min(POINTS, len(long)))
    return [int(long[round(k)]) for k in places]


def contact_course(run: Run, process: str, mu: str) -> ContactCourse | None:
    """Return loads and mu of all points at every stroke; None for a process without contact points."""
    touching = _touching(run, process)
    if touching is None or touching.shape[1] < 2:
        return None
    found = {q.name: run.values.get(f"{process}.{q.name}") for q in LOADS} | {MU.name: run.values.get(mu)}
    values = {
        name: np.where(touching, array, np.nan)
        for name, array in found.items()
        if array is not None and array.shape == touching.shape
    }
    r, z = (run.values.get(f"{process}.{n}") for n in ("r", "z"))
    if r is None or z is None or r.shape != touching.shape:
        place = np.tile(np.arange(1.0, touching.shape[1] + 1.0), (len(touching), 1))
        return ContactCourse(run[f"{process}.stroke"], place, values, False)
    steps = np.hypot(np.diff(r, axis=1), np.diff(z, axis=1))
    place = np.concatenate([np.zeros((len(r), 1)), np.cumsum(steps, axis=1)], axis=1)
    return ContactCourse(run[f"{process}.stroke"], place, values, True)


def point_history(run: Run, process: str, mu: str, point: int) -> PointHistory:
    """Return loads and mu of one point at every stroke."""
    touching = _touching(run, process)
    values = {}
    for name, label in [*((q.name, f"{process}.{q.name}") for q in LOADS), (MU.name, mu)]:
        found = run.values.get(label)
        if found is None or touching is None:
            continue
        column = found[:, point] if found.ndim == 2 else found
        values[name] = np.where(touching[:, point], column, np.nan)
    return PointHistory(point + 1, run[f"{process}.stroke"], values)
