"""Rigid tools: chains of lines and arcs with the workpiece on their left-hand side."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from .heat.tool_field import ToolField
from .mesh.polyline import SizeField
from .mesh.shape import FloatArray

Point = tuple[float, float]

#: Length that tools reach beyond the workpiece, so that no node leaves their end [mm].
BEYOND = 60.0


def line(start: Point, end: Point) -> list[float]:
    """Return the segment from `start` to `end`; the workpiece is on the left."""
    return [0.0, *start, *end, 0.0, 0.0, 0.0]


def arc(start: Point, end: Point, centre: Point, radius: float) -> list[float]:
    """Return an arc below 180 degrees; `radius` > 0: the tool is convex (its body around `centre`)."""
    return [1.0, *start, *end, *centre, radius]


@dataclass
class Tool:
    """A rigid tool moving at constant velocity."""

    #: For messages.
    name: str
    #: Rows of `line` and `arc`, in the tool's own frame [mm], shape (n, 8).
    segments: FloatArray
    #: Radial and axial velocity [mm/s], shape (2,).
    velocity: FloatArray = field(default_factory=lambda: np.zeros(2))
    #: Where the tool's frame is now [mm], shape (2,).
    offset: FloatArray = field(default_factory=lambda: np.zeros(2))
    #: Deepest penetration that still counts as contact [mm]; deeper points are on another side.
    reach: float = 1.0
    #: Temperature at the start and, without a `heat_field`, always [degC].
    temperature: float = 20.0
    #: Temperature field; its frame is the tool's.
    heat_field: ToolField | None = None
    #: How far the whole surface moves outward for its mean contact pressure [mm/MPa]; 0: rigid.
    flexibility: float = 0.0
    #: Least area per radian over which the contact force is taken to act for that [mm2].
    spread: float = 0.0
    #: That pressure after the last increment [MPa]: the mean over the contact, seen in radial direction.
    pressure: float = 0.0

    @property
    def speed(self) -> float:
        """Magnitude of the velocity [mm/s]."""
        return float(np.hypot(*self.velocity))

    def surface_temperature(self, points: FloatArray) -> FloatArray:
        """Return the tool surface temperature next to points of shape (n, 2) [degC]."""
        if self.heat_field is None:
            return np.full(len(points), self.temperature)
        return self.heat_field.surface_temperature(points - self.offset)


def plate(z: float = 0.0, temperature: float = 20.0, *, widest: float) -> Tool:
    """Return a flat plate at rest below a workpiece whose radius will be `widest` at most [mm]."""
    return Tool(
        "plate", np.array([line((-1.0, z), (widest + BEYOND, z))]), reach=1.0, temperature=temperature
    )


def flat_punch(z: float, speed: float, temperature: float = 20.0, *, widest: float) -> Tool:
    """Return a flat punch above the workpiece, moving down at `speed` [mm/s]; `widest` as of `plate`."""
    segments = np.array([line((widest + BEYOND, z), (-1.0, z))])
    return Tool("punch", segments, np.array([0.0, -speed]), reach=2.0, temperature=temperature)


def sleeve(radius: float, height: float, speed: float = 0.0, temperature: float = 20.0) -> Tool:
    """Return the cylindrical bore around the workpiece, moving with the punch (a cup) or at rest."""
    segments = np.array([line((radius, -BEYOND), (radius, height + BEYOND))])
    return Tool("sleeve", segments, np.array([0.0, -speed]), reach=1.0, temperature=temperature)


def polylines(segments: FloatArray) -> list[FloatArray]:
    """Return each segment as a polyline, arcs in steps of 5 degrees."""
    pieces = []
    for kind, r0, z0, r1, z1, rc, zc, radius in segments:
        if kind == 0.0:
            pieces.append(np.array([[r0, z0], [r1, z1]]))
            continue
        start, end = math.atan2(z0 - zc, r0 - rc), math.atan2(z1 - zc, r1 - rc)
        turn = (end - start + math.pi) % (2.0 * math.pi) - math.pi
        angle = start + np.linspace(0.0, turn, max(2, math.ceil(abs(turn) / math.radians(5.0)) + 1))
        pieces.append(np.array([rc, zc]) + abs(radius) * np.column_stack([np.cos(angle), np.sin(angle)]))
    return pieces


def block_field(radius: float, z: float, depth: float, size: SizeField, T: float) -> ToolField:
    """Return the heat field of a cylindrical tool: working face at `z`, its body above (below: depth < 0)."""
    face = np.array([[0.0, z], [radius, z]])
    back = np.array([[radius, z], [radius, z + depth], [0.0, z + depth], [0.0, z]])
    if depth < 0.0:
        face, back = face[::-1], back[::-1]
    return ToolField.build([face], back, size, T)
