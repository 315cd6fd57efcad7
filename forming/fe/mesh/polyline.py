"""Plane polylines: arc length, distances, spacing after a size field, inside tests."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit

from .shape import FloatArray

#: Element size [mm] wanted at points of shape (n, 2).
SizeField = Callable[[FloatArray], FloatArray]
#: Turns of a surface beyond this angle are corners: they stay nodes at a remeshing.
CORNER = np.radians(35.0)


@njit(cache=True)
def arc_length(points: FloatArray) -> FloatArray:
    """Return the arc length at each point, shape (n,)."""
    lengths = np.zeros(points.shape[0])
    for i in range(1, points.shape[0]):
        step = np.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
        lengths[i] = lengths[i - 1] + step
    return lengths


@njit(cache=True)
def turns(points: FloatArray) -> FloatArray:
    """Return the angle by which the direction changes at each point, 0 to pi, shape (n,); 0 at both ends."""
    turn = np.zeros(points.shape[0])
    for i in range(1, points.shape[0] - 1):
        ar, az = points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1]
        br, bz = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
        turn[i] = abs(np.arctan2(ar * bz - az * br, ar * br + az * bz))
    return turn


def at_arc_length(s: FloatArray, lengths: FloatArray, points: FloatArray) -> FloatArray:
    """Return the positions at arc lengths `s`, by linear interpolation."""
    return np.column_stack([np.interp(s, lengths, points[:, 0]), np.interp(s, lengths, points[:, 1])])


def spaced(points: FloatArray, size: SizeField) -> FloatArray:
    """Return the arc lengths of an even number of pieces along `points` whose length follows `size`."""
    lengths = arc_length(points)
    s = np.linspace(0.0, lengths[-1], max(50, int(lengths[-1] / 0.05)))
    density = 1.0 / size(at_arc_length(s, lengths, points))
    count = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(s))])
    pieces = max(2, 2 * round(count[-1] / 2.0))
    return np.interp(np.linspace(0.0, count[-1], pieces + 1), count, s)


def distance_to_point(points: FloatArray, r: float, z: float) -> FloatArray:
    """Return the distance of each point to one point."""
    return np.hypot(points[:, 0] - r, points[:, 1] - z)


@njit(cache=True)
def distance_to_segment(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the distance of each point to the segment from `start` to `end`."""
    along = end - start
    square = along[0] ** 2 + along[1] ** 2 + 1e-30
    distance = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        dr, dz = points[i, 0] - start[0], points[i, 1] - start[1]
        t = min(1.0, max(0.0, (dr * along[0] + dz * along[1]) / square))
        distance[i] = np.hypot(dr - t * along[0], dz - t * along[1])
    return distance


@njit(cache=True)
def distance_to_arc(
    points: FloatArray, centre: tuple[float, float], radius: float, start: float, end: float
) -> FloatArray:
    """Return the distance of each point to the arc between two angles [degrees, counter-clockwise from r]."""
    middle, half = np.radians(0.5 * (start + end)), np.radians(0.5 * (end - start))
    cos, sin = np.cos(middle), np.sin(middle)
    distance = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        # Seen from the middle of the arc both halves are alike.
        dr, dz = points[i, 0] - centre[0], points[i, 1] - centre[1]
        along, across = dr * cos + dz * sin, abs(dz * cos - dr * sin)
        if np.arctan2(across, along) <= half:
            distance[i] = abs(np.hypot(along, across) - radius)
        else:
            distance[i] = np.hypot(along - radius * np.cos(half), across - radius * np.sin(half))
    return distance


def enclosed_volume(chain: FloatArray) -> float:
    """Return the volume of revolution inside a counter-clockwise chain that starts and ends on the axis."""
    r, z = chain.T
    r1, z1 = np.roll(chain, -1, axis=0).T
    return float(np.pi / 3.0 * ((z1 - z) * (r * r + r * r1 + r1 * r1)).sum())


@njit(cache=True)
def inside(points: FloatArray, polygon: FloatArray) -> np.ndarray:
    """Return which points lie inside the closed polygon (crossing number)."""
    result = np.zeros(points.shape[0], np.bool_)
    for p in range(points.shape[0]):
        r = points[p, 0]
        z = points[p, 1]
        odd = False
        j = polygon.shape[0] - 1
        for i in range(polygon.shape[0]):
            if (polygon[i, 1] > z) != (polygon[j, 1] > z):
                slope = (polygon[j, 0] - polygon[i, 0]) / (polygon[j, 1] - polygon[i, 1])
                if r < polygon[i, 0] + slope * (z - polygon[i, 1]):
                    odd = not odd
            j = i
        result[p] = odd
    return result


@njit(cache=True)
def distance_to_polygon(points: FloatArray, polygon: FloatArray) -> FloatArray:
    """Return the distance of each point to the closed polygon."""
    n = polygon.shape[0]
    # Start, direction and inverse square of the length of each edge.
    edges = np.empty((5, n))
    for i in range(n):
        j = i - 1 if i > 0 else n - 1
        er = polygon[i, 0] - polygon[j, 0]
        ez = polygon[i, 1] - polygon[j, 1]
        edges[0, i] = polygon[j, 0]
        edges[1, i] = polygon[j, 1]
        edges[2, i] = er
        edges[3, i] = ez
        edges[4, i] = 1.0 / (er * er + ez * ez + 1e-30)
    result = np.empty(points.shape[0])
    for p in range(points.shape[0]):
        best = 1e30
        for i in range(n):
            pr = points[p, 0] - edges[0, i]
            pz = points[p, 1] - edges[1, i]
            t = min(1.0, max(0.0, (pr * edges[2, i] + pz * edges[3, i]) * edges[4, i]))
            pr -= t * edges[2, i]
            pz -= t * edges[3, i]
            best = min(best, pr * pr + pz * pz)
        result[p] = np.sqrt(best)
    return result


@njit(cache=True)
def first_crossing(chain: FloatArray) -> int:
    """Return the first edge of a polyline that crosses a later one which is not its neighbour; -1: there is none."""
    last = chain.shape[0] - 2
    closed = chain[0, 0] == chain[last + 1, 0] and chain[0, 1] == chain[last + 1, 1]
    for i in range(last + 1):
        ar, az = chain[i, 0], chain[i, 1]
        br, bz = chain[i + 1, 0], chain[i + 1, 1]
        low_r, high_r = min(ar, br), max(ar, br)
        low_z, high_z = min(az, bz), max(az, bz)
        for j in range(i + 2, last + 1):
            if closed and i == 0 and j == last:
                continue
            cr, cz = chain[j, 0], chain[j, 1]
            dr, dz = chain[j + 1, 0], chain[j + 1, 1]
            if max(cr, dr) < low_r or min(cr, dr) > high_r or max(cz, dz) < low_z or min(cz, dz) > high_z:
                continue
            c_side = (br - ar) * (cz - az) - (bz - az) * (cr - ar)
            d_side = (br - ar) * (dz - az) - (bz - az) * (dr - ar)
            a_side = (dr - cr) * (az - cz) - (dz - cz) * (ar - cr)
            b_side = (dr - cr) * (bz - cz) - (dz - cz) * (br - cr)
            if c_side * d_side < 0.0 and a_side * b_side < 0.0:
                return i
    return -1
