"""Punch for backward cup extrusion: nose, edge rounding, land and relieved shaft."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from friction_models.common import InputError

from ..fe.heat.tool_field import ToolField
from ..fe.mesh.polyline import SizeField
from ..fe.mesh.shape import FloatArray
from ..fe.tooling import Point, arc, line, polylines

#: Angle over which the shaft steps back behind the land [degrees].
RELIEF_ANGLE = 25.0


@dataclass(frozen=True)
class CupPunch:
    """Punch with a flat or conical nose, a land and a relieved shaft; z = 0 is the lowest point of the nose.

    >>> from forming.tools.cup_punch import CupPunch
    >>> CupPunch(radius=8.0, edge_radius=1.0, land=2.0).nose_height
    0.0
    >>> blunt = CupPunch(radius=8.0, edge_radius=1.0, land=2.0, nose_angle=10.0)
    >>> blunt.nose_height > 0.0
    True
    """

    #: Radius at the land, rounding between nose and land, length of the land [mm].
    radius: float
    edge_radius: float
    land: float
    #: Angle between the nose and a plane across the axis [degrees]; 0 is flat.
    nose_angle: float = 0.0
    #: Rounding of a conical nose on the axis [mm].
    tip_radius: float = 2.0
    #: How far the shaft steps back behind the land [mm].
    relief: float = 0.28

    def __post_init__(self) -> None:
        sine = math.sin(math.radians(self.nose_angle))
        widest = self.radius - self.edge_radius * (1.0 - sine)
        if self.nose_angle > 0.0 and self.tip_radius * sine > 0.95 * widest:
            raise InputError(
                f"forming: tip_radius = {self.tip_radius:g} mm; allowed: at most {0.95 * widest / sine:.3g} mm "
                f"with nose_angle = {self.nose_angle:g} degrees and edge_radius = {self.edge_radius:g} mm"
            )

    @property
    def nose_height(self) -> float:
        """Height of the cone between tip and edge rounding [mm]; 0 for a flat nose."""
        return self._edge_centre[1] - self.edge_radius

    @property
    def _edge_centre(self) -> Point:
        b = math.radians(self.nose_angle)
        r = self.radius - self.edge_radius
        start = (r + self.edge_radius * math.sin(b), 0.0)
        if self.nose_angle > 0.0:
            tip = (self.tip_radius * math.sin(b), self.tip_radius * (1.0 - math.cos(b)))
            start = (start[0], tip[1] + (start[0] - tip[0]) * math.tan(b))
        return r, start[1] + self.edge_radius * math.cos(b)

    def segments(self, shaft: float) -> FloatArray:
        """Return the chain from the shaft down to the axis, with `shaft` mm above the relief."""
        rp, edge = self.radius, self.edge_radius
        centre = self._edge_centre
        top = centre[1] + self.land
        a = math.radians(RELIEF_ANGLE)
        curve = self.relief / (1.0 - math.cos(a))
        back = (rp - self.relief, top + curve * math.sin(a))
        b = math.radians(self.nose_angle)
        start = (centre[0] + edge * math.sin(b), centre[1] - edge * math.cos(b))
        rows = [
            line((back[0], back[1] + shaft), back),
            arc(back, (rp, top), (rp - curve, top), curve),
            line((rp, top), (rp, centre[1])),
            arc((rp, centre[1]), start, centre, edge),
        ]
        if self.nose_angle == 0.0:
            return np.array([*rows, line(start, (-1.0, 0.0))])
        tip = self.tip_radius
        right = (tip * math.sin(b), tip * (1.0 - math.cos(b)))
        rows += [line(start, right), arc(right, (-right[0], right[1]), (0.0, tip), tip)]
        return np.array(rows)

    def heat_field(self, shaft: float, size: SizeField, T: float) -> ToolField:
        """Return the heat field of the punch with `shaft` mm above the relief; `size` counts z from the tip."""
        face = [piece[::-1] for piece in polylines(self.segments(shaft))[::-1]]
        # The last piece crosses the axis; only its part at r >= 0 belongs to the mesh.
        beyond = face[0][face[0][:, 0] > 1e-6]
        face[0] = np.concatenate([[[0.0, 0.0]], beyond])
        top = face[-1][-1]
        back = np.array([top, [0.0, top[1]], [0.0, 0.0]])
        return ToolField.build(face, back, size, T)
