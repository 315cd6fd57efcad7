"""Die for forward rod extrusion: container, cone, land and relief."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..fe.heat.tool_field import ToolField
from ..fe.mesh.polyline import SizeField
from ..fe.mesh.shape import FloatArray
from ..fe.tooling import BEYOND, arc, line, polylines


@dataclass(frozen=True)
class ExtrusionDie:
    """Die for forward rod extrusion, which checks its dimensions; z = 0 is the lower end of its land.

    The cone from 10 to 7 mm at 45 degrees is as high as it is wide, 3 mm, above the land of 2 mm; the roundings add to it:

    >>> from forming.tools.extrusion_die import ExtrusionDie
    >>> die = ExtrusionDie(container_radius=10.0, exit_radius=7.0, half_angle=45.0, entry_radius=0.1, edge_radius=0.1)
    >>> chain, entry = die.segments(container_length=30.0)
    >>> round(entry, 1)
    5.1
    """

    #: Radii before and behind the cone [mm].
    container_radius: float
    exit_radius: float
    #: Angle between the cone and the axis [degrees].
    half_angle: float
    #: Rounding from container to cone and from cone to land [mm]; shortened where the cone is too short.
    entry_radius: float = 2.0
    edge_radius: float = 1.5
    #: Length of the calibrating land [mm].
    land: float = 2.0
    #: Radius at the lower end of the land, behind which the rod runs free [mm].
    relief: float = 1.0

    def __post_init__(self) -> None:
        cone = (self.container_radius - self.exit_radius) / math.sin(math.radians(self.half_angle))
        tangents = (self.entry_radius + self.edge_radius) * math.tan(math.radians(self.half_angle) / 2.0)
        if tangents > 0.95 * cone:
            shorten = 0.95 * cone / tangents
            object.__setattr__(self, "entry_radius", self.entry_radius * shorten)
            object.__setattr__(self, "edge_radius", self.edge_radius * shorten)

    def segments(self, container_length: float) -> tuple[FloatArray, float]:
        """Return the chain from the relief below the land up the container, and the cone's upper end z."""
        a = math.radians(self.half_angle)
        r1, r0 = self.exit_radius, self.container_radius
        edge, entry, land, relief = self.edge_radius, self.entry_radius, self.land, self.relief
        cone_start = (r1 + edge * (1.0 - math.cos(a)), land + edge * math.sin(a))
        cone_end_r = r0 - entry * (1.0 - math.cos(a))
        cone_end = (cone_end_r, cone_start[1] + (cone_end_r - cone_start[0]) / math.tan(a))
        z_entry = cone_end[1] + entry * math.sin(a)
        rows = [
            line((r0 + relief + BEYOND, -relief), (r1 + relief, -relief)),
            arc((r1 + relief, -relief), (r1, 0.0), (r1 + relief, 0.0), relief),
            line((r1, 0.0), (r1, land)),
            arc((r1, land), cone_start, (r1 + edge, land), edge),
            line(cone_start, cone_end),
            arc(cone_end, (r0, z_entry), (r0 - entry, z_entry), -entry),
            line((r0, z_entry), (r0, z_entry + container_length)),
        ]
        return np.array(rows), z_entry

    def heat_field(self, top: float, size: SizeField, T: float) -> ToolField:
        """Return the heat field of the die with its container up to z = `top`."""
        segments, z_entry = self.segments(1.0)
        inner = [piece[::-1] for piece in polylines(segments)[:0:-1]]
        inner[0] = np.array([[self.container_radius, top], [self.container_radius, z_entry]])
        start, end = inner[0][0], inner[-1][-1]
        radius = self.container_radius
        outside = max(radius + max(1.5 * radius, 12.0), float(end[0]) + 0.5 * radius)
        back = np.array([end, [outside, end[1]], [outside, top], start])
        return ToolField.build(inner, back, size, T)
