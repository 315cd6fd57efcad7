"""Tools of ejection, and where tools at rest hold the product and how much axial force friction can carry there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..fe.contact import NORMAL_R, PRESSURE
from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..fe.tooling import BEYOND, Tool, arc, line

#: Rounding of the container's opening, as a share of its radius.
OPENING = 0.1
#: Rounding of the ejector's edge, as a share of its radius.
EDGE = 0.05


@dataclass(frozen=True)
class Stage:
    """One motion.

    >>> stage = Stage("withdraw", tools=(), mover="punch", longest=20.0, clear=0.5)
    >>> stage.mover, stage.longest, stage.opening
    ('punch', 20.0, None)
    """

    #: ``"withdraw"``, ``"release"`` or ``"eject"``.
    name: str
    #: As they stand at its start; those with a velocity move, the others hold. A tool of the stage before
    #: keeps its name, and with it its force.
    tools: tuple[Tool, ...]
    #: Name of the moving tool whose force is asked for.
    mover: str
    #: It ends after this travel [mm] at the latest.
    longest: float
    #: It ends when the moving tool has touched nothing over this travel [mm].
    clear: float | None = None
    #: It ends when the tools at rest touch the product above this height only [mm].
    opening: float | None = None


def withdrawn(tool: Tool, speed: float) -> Tool:
    """Return a tool that from now on moves upward at `speed` [mm/s]."""
    return replace(tool, velocity=np.array([0.0, speed]))


def ejector(radius: float, surface: FloatArray, speed: float, T: float) -> Tool:
    """Return a flat pin of `radius` [mm] in touch with the lowest point of `surface` above it, moving up."""
    edge = EDGE * radius
    z = float(surface[surface[:, 0] < radius - edge, 1].min()) - 1e-8
    segments = [
        line((-1.0, 0.0), (radius - edge, 0.0)),
        arc((radius - edge, 0.0), (radius, -edge), (radius - edge, -edge), edge),
        line((radius, -edge), (radius, -BEYOND)),
    ]
    return Tool("ejector", np.array(segments), np.array([0.0, speed]), np.array([0.0, z]), temperature=T)


def stripper(inner: float, edge: float, surface: FloatArray, T: float) -> Tool:
    """Return a plate at rest on the highest point of `surface`, with a hole of radius `inner` for the punch [mm]."""
    z = float(surface[surface[:, 0] > inner + edge, 1].max()) + 1e-8
    segments = [
        line((inner + BEYOND, 0.0), (inner + edge, 0.0)),
        arc((inner + edge, 0.0), (inner, edge), (inner + edge, edge), edge),
        line((inner, edge), (inner, BEYOND)),
    ]
    return Tool("stripper", np.array(segments), offset=np.array([0.0, z]), temperature=T)


def opened(container: Tool, radius: float, top: float) -> Tool:
    """Return a container whose bore, its last segment, ends at z = `top` [mm] with a rounding."""
    edge = OPENING * radius
    bore = container.segments[-1].copy()
    bore[4] = top - edge
    rim = [
        arc((radius, top - edge), (radius + edge, top), (radius + edge, top - edge), edge),
        line((radius + edge, top), (radius + edge + BEYOND, top)),
    ]
    return replace(container, segments=np.vstack([container.segments[:-1], bore[None], rim]))


@dataclass(frozen=True)
class GripPatch:
    """A part of the surface that a tool at rest holds after unloading.

    >>> patch = GripPatch("container", 10.0, 10.0, 0.0, 5.0, pressure=50.0, friction=1.25)
    >>> patch.tool, patch.z_high - patch.z_low
    ('container', 5.0)
    """

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
            r, z = surface[patch].T
            place = float(r.min()), float(r.max()), float(z.min()), float(z.max())
            pressure = float(force.sum()) / (2.0 * math.pi * float(state.weights[patch].sum()))
            axial = float((mu[patch] * force * np.abs(table[patch, NORMAL_R])).sum())
            found.append(GripPatch(tool.name, *place, pressure, axial * 1e-3))
    return tuple(found)
