"""The sliding phase: contact temperature along measured or simulated motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from friction_models.loads import FloatArray

from .contact_temperature import SlidingContact


@dataclass(frozen=True, eq=False)
class TemperatureHistory:
    """Contact temperatures [degC] over sliding distance [mm], all of shape (n,).

    `mean` is the area-weighted mean of both surfaces, `maximum` the largest local value of it.
    """

    sd: FloatArray
    mean: FloatArray
    maximum: FloatArray
    plate: FloatArray
    specimen: FloatArray

    def at(self, sd: FloatArray) -> dict[str, FloatArray]:
        """Return the temperatures interpolated to other distances."""
        names = ("mean", "maximum", "plate", "specimen")
        return {name: np.interp(sd, self.sd, getattr(self, name)) for name in names}


def rest(contact: SlidingContact, seconds: float) -> None:
    """Let specimen and plate lie on each other without sliding; steps grow with time."""
    if seconds <= 0.0:
        return
    edges = np.linspace(0.0, 1.0, 13) ** 2 * seconds
    for dt in np.diff(edges):
        contact.advance(float(dt), 0.0, 0.0)


def slide(
    contact: SlidingContact, t: FloatArray, sd: FloatArray, power: FloatArray, start_share: float = 0.1
) -> TemperatureHistory:
    """Slide along t(sd) with a given friction power.

    Parameters
    ----------
    contact : SlidingContact
        Start state; advanced in place.
    t, sd, power : ndarray, shape (n,)
        Time [s], distance [mm] (increasing) and friction power [N mm/s].
    start_share : float
        First step, in cells; steps grow to half a cell.

    Returns
    -------
    TemperatureHistory
        At the ends of the thermal steps, the start included.
    """
    stops = step_ends(contact.cell, float(sd[-1]), start_share)
    energy = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(t))])
    times = np.interp(stops, sd, t)
    energies = np.interp(stops, sd, energy)
    rows = [contact.contact]
    for k in range(1, len(stops)):
        dt = max(times[k] - times[k - 1], 1e-9)
        mean_power = (energies[k] - energies[k - 1]) / dt
        rows.append(contact.advance(float(dt), float(stops[k] - stops[k - 1]), float(mean_power)))
    columns = np.array(rows)
    return TemperatureHistory(stops, columns[:, 0], columns[:, 1], columns[:, 2], columns[:, 3])


def step_ends(cell: float, distance: float, start_share: float = 0.1) -> FloatArray:
    """Return the distances at which thermal steps end: fine at the start, then half a cell each."""
    stops = [0.0]
    step = start_share * cell
    while stops[-1] < distance - 1e-9:
        stops.append(min(stops[-1] + step, distance))
        step = min(1.3 * step, 0.5 * cell)
    return np.array(stops)
