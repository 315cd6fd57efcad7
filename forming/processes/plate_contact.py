"""Contact of an upset specimen with the plate: radius, pressure, surface expansion, temperature."""

from __future__ import annotations

import math

import numpy as np

from ..fe.contact import FACING, GAP, PRESSURE
from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..fe.surface_loads import LEAST_SHARE
from ..tools.punch_geometry import PunchGeometry


def ring_shares(fraction: FloatArray) -> FloatArray:
    """Return which share of a circle each of some radii stands for: the ring half-way to its neighbours.

    - `fraction`, shape (m,): radii over that of the circle, rising from 0 to 1.

    Examples
    --------
    The edge stands for one side only:

    >>> ring_shares(np.array([0.0, 0.5, 1.0])).tolist()
    [0.0625, 0.5, 0.4375]
    """
    return np.diff(_ring_edges(fraction) ** 2)


def _ring_edges(fraction: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], 0.5 * (fraction[1:] + fraction[:-1]), [1.0]])


def _expansion(sim: Simulation, edge: float, fraction: FloatArray) -> FloatArray:
    """Return the mean surface expansion of the rings that `fraction` stands for, by area as it is now.

    - `edge`: index coordinate of the surface at which the contact ends.
    """
    markers, surface = sim.state.markers, sim.state.body.surface
    psi = markers.areas(surface) / markers.start_areas
    touching = markers.areas(surface, edge)
    area, weighed = (np.append(0.0, np.cumsum(part)) for part in (touching, psi * touching))
    ends = np.interp(_ring_edges(fraction) ** 2 * area[-1], area, weighed)
    return np.diff(ends) / (ring_shares(fraction) * area[-1])


def _profile(r: FloatArray, at: FloatArray, values: FloatArray) -> FloatArray:
    order = np.argsort(at, kind="stable")
    return np.interp(r, at[order], values[order])


def _edge(surface: FloatArray, table: FloatArray, bore: float) -> tuple[float, float]:
    """Return the radius at which the surface leaves the plate [mm], at most `bore`, and its index coordinate.

    The contact lies between the last node that touches and the first that does not. The gap of the first two
    free nodes over the length of the surface, extrapolated to zero, tells where, so that the area grows smoothly with
    the force. Over the radius it would not: where the side stands up, along a bore, the radius hardly changes.
    """
    on = table[:, PRESSURE] > 0.0
    last = int(np.flatnonzero(on)[np.argmax(surface[on, 0])])
    at = float(surface[last, 0])
    if last + 2 >= len(surface):
        return min(at, bore), float(last)
    gap, wider = table[last + 1 : last + 3, GAP]
    near, far = np.hypot(*np.diff(surface[last : last + 3], axis=0).T)
    if not (wider > gap > 0.0 and surface[last + 1, 0] > at):
        return min(at, bore), float(last)
    share = 1.0 - float(np.clip(gap * far / (wider - gap) / near, 0.0, 1.0))
    return min(at + share * float(surface[last + 1, 0] - at), bore), last + share


def plate_contact(
    sim: Simulation, punch: PunchGeometry, fraction: FloatArray
) -> dict[str, FloatArray | float]:
    """Return one row of the result: the contact with the plate now."""
    state = sim.state
    body = state.body
    row: dict[str, FloatArray | float] = {
        "time": state.time,
        "force": max(sim.force, 0.0),
        "height": punch.specimen_height - state.stroke,
    }
    surface = body.surface
    tables = state.tables
    on = tables[0][:, PRESSURE] > 0.0 if tables else np.zeros(len(surface), dtype=bool)
    if tables is None or not on.any():
        area = punch.first_contact_area
        flat = np.zeros_like(fraction)
        return row | {
            "contact_radius": math.sqrt(area / math.pi),
            "sigma_n": flat,
            "psi": flat + 1.0,
            "sigma_n_mean": 0.0,
            "psi_mean": 1.0,
            "area_ratio": 1.0,
            "T_contact": 0.5 * (float(body.T.mean()) + state.tools[0].temperature),
        }
    radius, edge = _edge(surface, tables[0], 0.5 * (punch.bore_diameter or math.inf))
    area = math.pi * radius**2
    r = fraction * radius
    share = ring_shares(fraction)
    mean_pressure = -float(state.forces[0, 1]) / area
    # The last node holds a part of the free side, too; what it carries acts on the part that faces the plate.
    facing = np.maximum(tables[0][on, FACING], LEAST_SHARE)
    pressure = _profile(r, surface[on, 0], np.maximum(tables[0][on, PRESSURE], 0.0) / facing)
    pressure *= mean_pressure / float(share @ pressure)
    psi = _expansion(sim, edge, fraction)
    T = _profile(r, surface[on, 0], body.surface_T[on])
    return row | {
        "contact_radius": radius,
        "sigma_n": pressure,
        "psi": psi,
        "sigma_n_mean": mean_pressure,
        "psi_mean": float(share @ psi),
        "area_ratio": area / punch.first_contact_area,
        "T_contact": float(share @ (0.5 * (T + state.tools[0].temperature))),
    }
