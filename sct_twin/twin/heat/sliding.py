"""The sliding phase: contact temperature along measured or simulated motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from friction_models.loads import FloatArray

from ...signals.filters import integral
from .contact_temperature import SlidingContact


@dataclass(frozen=True, eq=False)
class TemperatureHistory:
    """Contact temperatures [degC] over sliding distance [mm], all of shape (n,).

    `mean` is the area-weighted mean of both surfaces, `maximum` the largest local value of it, `film` the mean of
    the middle of the film.
    """

    sd: FloatArray
    mean: FloatArray
    maximum: FloatArray
    plate: FloatArray
    specimen: FloatArray
    film: FloatArray

    def at(self, sd: FloatArray) -> dict[str, FloatArray]:
        """Return the temperatures interpolated to other distances."""
        names = ("mean", "maximum", "plate", "specimen", "film")
        return {name: np.interp(sd, self.sd, getattr(self, name)) for name in names}


def rest(contact: SlidingContact, seconds: float) -> None:
    """Let specimen and plate lie on each other without sliding; steps grow with time."""
    if seconds <= 0.0:
        return
    for dt in np.diff(np.linspace(0.0, 1.0, 25) ** 2 * seconds):
        contact.advance(float(dt), 0.0, 0.0)


def slide(
    contact: SlidingContact,
    t: FloatArray,
    sd: FloatArray,
    friction: FloatArray,
    v: FloatArray,
) -> TemperatureHistory:
    """Slide along t(sd) under a given friction force, with rests under load where the plate stands.

    - `t`, `sd`, `friction`, `v`, shape (n,): time [s], distance [mm] (increasing), friction force [N] and
      speed [mm/s]. Time beyond distance over speed is a rest.
    - returns: at the ends of the thermal steps, the start included; before and after a rest at the same
      distance.
    """
    where, pauses = rests(t, sd, v)
    stops = np.union1d(step_ends(contact.cell, float(sd[-1])), where)
    # Friction work is force times distance: rests and the time base have no part in it.
    work = np.interp(stops, sd, integral(friction, x=sd))
    steps = np.diff(t)
    steps[np.searchsorted(sd, where) - 1] -= pauses
    moving = np.interp(stops, sd, np.concatenate([[0.0], np.cumsum(steps)]))
    distances, rows = [0.0], [contact.contact]
    waits = dict(zip(where.tolist(), pauses.tolist()))
    for k in range(1, len(stops)):
        dt = max(float(moving[k] - moving[k - 1]), 1e-9)
        distances.append(float(stops[k]))
        rows.append(contact.advance(dt, float(stops[k] - stops[k - 1]), float((work[k] - work[k - 1]) / dt)))
        if stops[k] in waits:
            rest(contact, waits[float(stops[k])])
            distances.append(float(stops[k]))
            rows.append(contact.contact)
    return TemperatureHistory(np.array(distances), *np.array(rows).T)


#: Standing time between two points that counts as a rest [s].
SHORTEST_REST = 0.05


def rests(t: FloatArray, sd: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where the plate stands [mm], between two points each, and how long [s].

    A rest is what the time between two points exceeds distance over speed by, where that is more than
    `SHORTEST_REST` and than the moving time itself.
    """
    moving = np.diff(sd) / np.maximum(0.5 * (v[1:] + v[:-1]), 1e-9)
    pause = np.diff(t) - moving
    found = np.flatnonzero((pause > SHORTEST_REST) & (pause > moving) & (moving > 0.0))
    return 0.5 * (sd[found] + sd[found + 1]), pause[found]


def step_ends(cell: float, distance: float) -> FloatArray:
    """Return the distances at which thermal steps end: a tenth of a cell at the start, then half a cell each."""
    stops = [0.0]
    step = 0.1 * cell
    while stops[-1] < distance - 1e-9:
        stops.append(min(stops[-1] + step, distance))
        step = min(1.3 * step, 0.5 * cell)
    return np.array(stops)
