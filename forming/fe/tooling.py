"""Rigid tools: chains of lines and arcs with the workpiece on their left-hand side."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from friction_models.common import InputError

from .mesh.polyline import SizeField
from .mesh.shape import FloatArray
from .tool_heat import ToolField, ToolSteel

Point = tuple[float, float]

#: Angle over which the shaft of a cup punch steps back behind its land [degrees].
RELIEF_ANGLE = 25.0

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
    """A rigid tool moving at constant velocity.

    Attributes
    ----------
    name : str
        For messages.
    segments : ndarray, shape (n, 8)
        Rows of `line` and `arc`, in the tool's own frame [mm].
    velocity : ndarray, shape (2,)
        Radial and axial velocity [mm/s].
    offset : ndarray, shape (2,)
        Where the tool's frame is now [mm].
    reach : float
        Deepest penetration that still counts as contact [mm]; deeper points are on another side.
    temperature : float
        Temperature at the start and, without a `heat_field`, always [degC].
    heat_field : ToolField or None
        Temperature field; its frame is the tool's.
    flexibility : float
        How far the whole surface moves outward for its mean contact pressure [mm/MPa]; 0: rigid.
    spread : float
        Least area per radian over which the contact force is taken to act for that [mm2].
    pressure : float
        That pressure after the last increment [MPa]: the mean over the contact, seen in radial direction.
    """

    name: str
    segments: FloatArray
    velocity: FloatArray = field(default_factory=lambda: np.zeros(2))
    offset: FloatArray = field(default_factory=lambda: np.zeros(2))
    reach: float = 1.0
    temperature: float = 20.0
    heat_field: ToolField | None = None
    flexibility: float = 0.0
    spread: float = 0.0
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


def plate(z: float = 0.0, temperature: float = 20.0) -> Tool:
    """Return a flat plate at rest below the workpiece."""
    return Tool("plate", np.array([line((-1.0, z), (BEYOND + 30.0, z))]), reach=1.0, temperature=temperature)


def flat_punch(z: float, speed: float, temperature: float = 20.0, reach: float = 2.0) -> Tool:
    """Return a flat punch above the workpiece, moving down at `speed` [mm/s]."""
    segments = np.array([line((BEYOND + 30.0, z), (-1.0, z))])
    return Tool("punch", segments, np.array([0.0, -speed]), reach=reach, temperature=temperature)


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


def block_field(
    radius: float, z: float, depth: float, size: SizeField, T: float, steel: ToolSteel | None = None
) -> ToolField:
    """Return the heat field of a cylindrical tool: working face at `z`, its body above (below: depth < 0)."""
    face = np.array([[0.0, z], [radius, z]])
    back = np.array([[radius, z], [radius, z + depth], [0.0, z + depth], [0.0, z]])
    if depth < 0.0:
        face, back = face[::-1], back[::-1]
    return ToolField.build([face], back, size, T, steel)


@dataclass(frozen=True)
class ExtrusionDie:
    """Die for forward rod extrusion; z = 0 is the lower end of its land.

    Parameters
    ----------
    container_radius, exit_radius : float
        Radii before and behind the cone [mm].
    half_angle : float
        Angle between the cone and the axis [degrees].
    entry_radius, edge_radius : float
        Rounding from container to cone and from cone to land [mm]; shortened where the cone is too short.
    land : float
        Length of the calibrating land [mm].
    relief : float
        Radius at the lower end of the land, behind which the rod runs free [mm].
    """

    container_radius: float
    exit_radius: float
    half_angle: float
    entry_radius: float = 2.0
    edge_radius: float = 1.5
    land: float = 2.0
    relief: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.exit_radius < self.container_radius:
            raise InputError(
                f"forming: exit radius {self.exit_radius:g} mm with a container radius of "
                f"{self.container_radius:g} mm; allowed: 0 < exit radius < container radius"
            )
        if not 5.0 <= self.half_angle <= 85.0:
            raise InputError(f"forming: half_angle = {self.half_angle:g} degrees; allowed: 5 to 85")
        for name in ("entry_radius", "edge_radius", "land", "relief"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"forming: {name} = {getattr(self, name):g} mm; allowed: > 0")
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
            line((r1 + 40.0, -relief), (r1 + relief, -relief)),
            arc((r1 + relief, -relief), (r1, 0.0), (r1 + relief, 0.0), relief),
            line((r1, 0.0), (r1, land)),
            arc((r1, land), cone_start, (r1 + edge, land), edge),
            line(cone_start, cone_end),
            arc(cone_end, (r0, z_entry), (r0 - entry, z_entry), -entry),
            line((r0, z_entry), (r0, z_entry + container_length)),
        ]
        return np.array(rows), z_entry

    def heat_field(self, top: float, size: SizeField, T: float, steel: ToolSteel | None = None) -> ToolField:
        """Return the heat field of the die with its container up to z = `top`."""
        segments, z_entry = self.segments(1.0)
        inner = [piece[::-1] for piece in polylines(segments)[:0:-1]]
        inner[0] = np.array([[self.container_radius, top], [self.container_radius, z_entry]])
        start, end = inner[0][0], inner[-1][-1]
        outside = self.container_radius + max(1.5 * self.container_radius, 12.0)
        back = np.array([end, [outside, end[1]], [outside, top], start])
        return ToolField.build(inner, back, size, T, steel)


@dataclass(frozen=True)
class CupPunch:
    """Punch with a flat or conical nose, a land and a relieved shaft; z = 0 is the lowest point of the nose.

    Attributes
    ----------
    radius, edge_radius, land : float
        Radius at the land, rounding between nose and land, length of the land [mm].
    nose_angle : float
        Angle between the nose and a plane across the axis [degrees]; 0 is flat.
    tip_radius : float
        Rounding of a conical nose on the axis [mm].
    relief : float
        How far the shaft steps back behind the land [mm].
    """

    radius: float
    edge_radius: float
    land: float
    nose_angle: float = 0.0
    tip_radius: float = 2.0
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

    def heat_field(
        self, shaft: float, size: SizeField, T: float, steel: ToolSteel | None = None
    ) -> ToolField:
        """Return the heat field of the punch with `shaft` mm above the relief; `size` counts z from the tip."""
        face = [piece[::-1] for piece in polylines(self.segments(shaft))[::-1]]
        # The last piece crosses the axis; only its part at r >= 0 belongs to the mesh.
        beyond = face[0][face[0][:, 0] > 1e-6]
        face[0] = np.concatenate([[[0.0, 0.0]], beyond])
        top = face[-1][-1]
        back = np.array([top, [0.0, top[1]], [0.0, 0.0]])
        return ToolField.build(face, back, size, T, steel)
