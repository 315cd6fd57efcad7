"""Rigid tools: chains of lines and arcs with the workpiece on their left-hand side."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from friction_models.loads import InputError

from .fe.shape import FloatArray

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
        Surface temperature [degC], constant.
    """

    name: str
    segments: FloatArray
    velocity: FloatArray = field(default_factory=lambda: np.zeros(2))
    offset: FloatArray = field(default_factory=lambda: np.zeros(2))
    reach: float = 1.0
    temperature: float = 20.0

    @property
    def speed(self) -> float:
        """Magnitude of the velocity [mm/s]."""
        return float(np.hypot(*self.velocity))


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
    """

    container_radius: float
    exit_radius: float
    half_angle: float
    entry_radius: float = 2.0
    edge_radius: float = 1.5
    land: float = 2.0

    def __post_init__(self) -> None:
        if not 0.0 < self.exit_radius < self.container_radius:
            raise InputError(
                f"forming: exit radius {self.exit_radius:g} mm with a container radius of "
                f"{self.container_radius:g} mm; allowed: 0 < exit radius < container radius"
            )
        if not 5.0 <= self.half_angle <= 85.0:
            raise InputError(f"forming: half_angle = {self.half_angle:g} degrees; allowed: 5 to 85")
        for name in ("entry_radius", "edge_radius", "land"):
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
        edge, entry, land = self.edge_radius, self.entry_radius, self.land
        relief = 1.0
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
