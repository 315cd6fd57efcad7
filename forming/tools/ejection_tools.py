"""Tools of ejection: the withdrawn punch, the ejector, the stripper, the opening of a container."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..fe.mesh.shape import FloatArray
from ..fe.tooling import BEYOND, Tool, arc, line

#: Rounding of the container's opening, as a share of its radius.
OPENING = 0.1
#: Rounding of the ejector's edge, as a share of its radius.
EDGE = 0.05


@dataclass(frozen=True)
class Stage:
    """One motion.

    Examples
    --------
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
