"""Contact of an upset specimen with the plate: radius, pressure, surface expansion, temperature."""

from __future__ import annotations

import math

import numpy as np

from ..fe.contact import GAP, PRESSURE
from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..tools.punch_geometry import PunchGeometry


def _profile(r: FloatArray, at: FloatArray, values: FloatArray) -> FloatArray:
    order = np.argsort(at, kind="stable")
    return np.interp(r, at[order], values[order])


def _edge_radius(surface: FloatArray, table: FloatArray, bore: float) -> float:
    """Return where the surface leaves the plate [mm], at most `bore`.

    The contact lies between the last node that touches and the first that does not. The gap of the first two
    free nodes, extrapolated to zero, tells where, so that the area grows smoothly with the force.
    """
    on = table[:, PRESSURE] > 0.0
    last = int(np.flatnonzero(on)[np.argmax(surface[on, 0])])
    edge = float(surface[last, 0])
    if last + 2 < len(surface):
        (near, far), (gap, wider) = surface[last + 1 : last + 3, 0], table[last + 1 : last + 3, GAP]
        if wider > gap > 0.0 and near > edge:
            edge = float(np.clip(near - gap * (far - near) / (wider - gap), edge, near))
    return min(edge, bore)


def plate_contact(
    sim: Simulation, punch: PunchGeometry, fraction: FloatArray
) -> dict[str, FloatArray | float]:
    """Return one row of the result: the contact with the plate now."""
    state = sim.state
    body, markers = state.body, state.markers
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
    radius = _edge_radius(surface, tables[0], 0.5 * (punch.bore_diameter or math.inf))
    area = math.pi * radius**2
    r = fraction * radius
    ring = np.gradient(fraction) * fraction
    share = ring / ring.sum()
    mean_pressure = -float(state.forces[0, 1]) / area
    pressure = _profile(r, surface[on, 0], np.maximum(tables[0][on, PRESSURE], 0.0))
    pressure *= mean_pressure / float(share @ pressure)
    points = markers.points(surface)
    touching = (
        markers.active
        & (points[:, 1] < 0.25 * punch.specimen_height)
        & (points[:, 0] <= 1.001 * max(radius, float(surface[on, 0].max())))
    )
    touching[0] = True
    psi = _profile(r, points[touching, 0], markers.psi[touching])
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
