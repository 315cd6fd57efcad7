"""Where tools at rest hold a product, and how much axial force friction can carry there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..fe.contact import NORMAL_R, PRESSURE
from ..fe.simulation import Simulation


@dataclass(frozen=True)
class GripPatch:
    """A part of the surface that a tool at rest holds after unloading.

    Examples
    --------
    >>> patch = GripPatch("container", 10.0, 10.0, 0.0, 5.0, pressure=50.0, friction=1.25)
    >>> patch.tool, patch.z_high - patch.z_low
    ('container', 5.0)
    """

    #: Which tool.
    tool: str
    #: Where it is [mm].
    r_low: float
    r_high: float
    z_low: float
    z_high: float
    #: Mean contact pressure [MPa].
    pressure: float
    #: Axial force that friction can carry there, mu times the contact force [kN].
    friction: float


def grip_patches(simulation: Simulation) -> tuple[GripPatch, ...]:
    """Return the parts of the surface that the tools at rest touch, from the lower axis point on."""
    state, found = simulation.state, []
    mu = state.markers.at_nodes(state.mu, len(state.body.chain))
    surface = state.body.surface
    for tool, table in zip(state.tools, state.tables or []):
        if tool.speed > 0.0:
            continue
        on = np.flatnonzero(table[:, PRESSURE] > 0.0)
        for patch in np.split(on, np.flatnonzero(np.diff(on) > 1) + 1):
            if not len(patch):
                continue
            force = 2.0 * math.pi * table[patch, PRESSURE] * state.weights[patch]
            (r_low, z_low), (r_high, z_high) = surface[patch].min(axis=0), surface[patch].max(axis=0)
            area = 2.0 * math.pi * float(state.weights[patch].sum())
            axial = float((mu[patch] * force * np.abs(table[patch, NORMAL_R])).sum())
            found.append(
                GripPatch(
                    tool.name,
                    float(r_low),
                    float(r_high),
                    float(z_low),
                    float(z_high),
                    float(force.sum()) / area,
                    axial * 1e-3,
                )
            )
    return tuple(found)
