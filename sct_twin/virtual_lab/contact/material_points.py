"""Points of the specimen's surface that move with the material, and the areas of the cones between them."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import PchipInterpolator

from friction_models.loads import FloatArray

#: Intervals on the face that touches the plate first, and on the surface up to the upper edge.
FACE, SIDE = 64, 64


class MaterialPoints:
    """Points on the lower face and the side of a specimen, followed in space from increment to increment.

    Nothing of the solver's mesh is kept: before an increment every point is looked up on the surface as it is, where it
    moves along as the nodes move. So it does not matter whether the nodes are still the same.

    - `outline`, shape (n, 2): corners of the undeformed specimen, from the lower to the upper axis point [mm].
    - `surface`, shape (m, 2): nodes of its surface, which cut a blunt corner a little [mm].
    """

    def __init__(self, outline: FloatArray, surface: FloatArray) -> None:
        parts = [_between(outline[0], outline[1], FACE)]
        lengths = np.hypot(*np.diff(outline[1:-1], axis=0).T)
        for a, b, length in zip(outline[1:-2], outline[2:-1], lengths):
            parts.append(_between(a, b, max(4, round(SIDE * length / lengths.sum())))[1:])
        #: Positions r, z [mm].
        self.at = self._on(surface, _foot(surface, _along(surface), np.concatenate(parts)))
        self.start_areas = cones(self.at)

    def follow(self, before: FloatArray, after: FloatArray) -> None:
        """Move with the surface nodes, shapes (m, 2) [mm]."""
        old, new = _along(before), _along(after)
        now = np.clip(PchipInterpolator(old, new)(_foot(before, old, self.at)), 0.0, new[-1])
        self.at = self._on(after, now)

    @staticmethod
    def _on(surface: FloatArray, place: FloatArray) -> FloatArray:
        """Return the positions r, z at lengths of a polyline, shape (n, 2)."""
        along = _along(surface)
        return np.column_stack([np.interp(place, along, coordinate) for coordinate in surface.T])

    def mean_expansion(self, edge: float, surface: FloatArray) -> float:
        """Return the mean of dA/dA0 over the contact, by area as it is now.

        - `edge`: length of the surface from the axis to the edge of the contact [mm].
        - `surface`: nodes as they are now, shape (m, 2) [mm].
        """
        now = cones(self.at)
        place = _foot(surface, _along(surface), self.at)
        inside = np.clip((edge - place[:-1]) / np.maximum(np.diff(place), 1e-12), 0.0, 1.0)
        # Part of the last cone: its area goes with the square of the radius at which it is cut.
        inner, outer = self.at[:-1, 0], self.at[1:, 0]
        cut = inner + inside * (outer - inner)
        whole = outer**2 - inner**2
        level = np.abs(whole) > 1e-9
        share = np.where(level, (cut**2 - inner**2) / np.where(level, whole, 1.0), inside)
        touching = now * np.clip(share, 0.0, 1.0)
        return float(touching @ (now / self.start_areas) / touching.sum())


def cones(points: FloatArray) -> FloatArray:
    """Return the areas of the truncated cones between neighbouring points (r, z) [mm2].

    >>> (cones(np.array([[0.0, 0.0], [3.0, 4.0]])) / math.pi).round(9).tolist()
    [15.0]
    """
    (r0, z0), (r1, z1) = points[:-1].T, points[1:].T
    return np.asarray(math.pi * (r0 + r1) * np.hypot(r1 - r0, z1 - z0))


def _between(a: FloatArray, b: FloatArray, count: int) -> FloatArray:
    return a + np.linspace(0.0, 1.0, count + 1)[:, None] * (b - a)


def _along(points: FloatArray) -> FloatArray:
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))


def _foot(surface: FloatArray, along: FloatArray, points: FloatArray) -> FloatArray:
    """Return how far along a polyline the place nearest to each point is, never back; shape (n,)."""
    start, step = surface[:-1], np.diff(surface, axis=0)
    square = np.maximum((step**2).sum(axis=1), 1e-300)
    offset = points[:, None, :] - start[None, :, :]
    share = np.clip((offset * step).sum(axis=2) / square, 0.0, 1.0)
    distance = np.hypot(*np.moveaxis(offset - share[:, :, None] * step, 2, 0))
    nearest = distance.argmin(axis=1)
    which = np.arange(len(points))
    return np.maximum.accumulate(along[nearest] + share[which, nearest] * np.diff(along)[nearest])
