"""All-quadrilateral meshing of any closed loop.

Triangles of twice the wanted size between every second boundary node, pairs of them merged to
quadrilaterals, then quadrilaterals split in four and triangles in three, smoothed, renumbered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import Delaunay

from .mesh_kernels import (
    candidate_pairs,
    choose_pairs,
    cuthill_mckee,
    elements_around,
    pack_points,
    qualities,
    smooth_guarded,
)
from .polyline import SizeField, distance_to_polygon, inside
from .shape import FloatArray, IntArray

BoolArray = npt.NDArray[np.bool_]


#: Triangles are merged where the quadrilateral has at least this scaled Jacobian: on a round boundary one of its quarters has half of it.
WORST_PAIR = 0.6
#: Inner points are chosen from a grid about so many times as fine as the smallest triangles. Its pitch is one of a series, so
#: many for each doubling.
PITCH, SERIES = 3.0, 8.0
#: Points of the grid lie off their places by up to this share of the pitch. On an even one four points often lie on a circle,
#: pairs of triangles are equally good, and chance in the last digit would choose between two meshes.
UNEVEN = 0.1


class MeshError(Exception):
    """No valid mesh for this loop at this size."""


@dataclass(frozen=True)
class Mesh:
    """Nodes, quadrilaterals, and the node numbers of the loop it was made from."""

    x: FloatArray
    quads: IntArray
    loop: IntArray
    quality: FloatArray


def quad_mesh(loop: FloatArray, size: SizeField) -> Mesh:
    """Mesh the inside of a counter-clockwise loop of nodes (an even number).

    Raises MeshError: the triangulation misses a boundary edge, or an element is folded.

    - `loop`, shape (n, 2): boundary nodes, kept exactly.
    - `size`: wanted element size [mm] at points of shape (m, 2).
    """
    coarse = np.ascontiguousarray(loop[::2])
    points, triangles, edges = _triangulate(coarse, size)
    n_points, n_coarse = len(points), len(coarse)
    sides = np.sort(edges, axis=1) @ np.array([n_points, 1])
    unique, side_of, count = np.unique(sides, return_inverse=True, return_counts=True)
    i = np.arange(n_coarse)
    j = (i + 1) % n_coarse
    boundary = np.minimum(i, j) * n_points + np.maximum(i, j)
    if not np.isin(boundary, unique).all() or count.max() > 2 or (count == 1).sum() != n_coarse:
        raise MeshError(f"{(~np.isin(boundary, unique)).sum()} boundary edges are missing")
    neighbours = _neighbours(side_of.reshape(3, -1).T, len(unique))
    quads, used = _pair(points, triangles, neighbours)
    on_boundary = np.searchsorted(unique, boundary)
    middles = 0.5 * (points[unique // n_points] + points[unique % n_points])
    middles[on_boundary] = loop[1::2]
    x, quads = _subdivide(points, middles, unique, quads, triangles[~used])
    nodes = np.empty(len(loop), dtype=np.int64)
    nodes[::2] = i
    nodes[1::2] = n_points + on_boundary
    used_nodes = np.zeros(len(x), dtype=bool)
    used_nodes[quads.ravel()] = True
    number = np.cumsum(used_nodes) - 1
    x, quads, nodes = x[used_nodes], number[quads], number[nodes]
    held = np.zeros(len(x), dtype=bool)
    held[nodes] = True
    smooth(x, quads, held, 6)
    x, quads, nodes = renumber(x, quads, nodes)
    quality = qualities(x, quads)
    if not quality.min() > 0.02:
        raise MeshError(f"an element has quality {quality.min():.3f}")
    return Mesh(x, quads, nodes, quality)


def _triangulate(coarse: FloatArray, size: SizeField) -> tuple[FloatArray, IntArray, IntArray]:
    """Return points (the coarse loop first), triangles and their edges (three blocks: 01, 12, 20)."""
    wanted = 2.0 * size(coarse)
    smallest = float(wanted.min())
    if not smallest > 0.0:
        raise MeshError(f"elements of {0.5 * smallest:g} mm")
    points = np.concatenate([coarse, _interior(coarse, wanted, size)])
    triangles = Delaunay(points).simplices.astype(np.int64)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))
    triangles = triangles[inside((a + b + c) / 3.0, coarse) & (area > 1e-6 * smallest**2)]
    return points, triangles, np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])


def _interior(coarse: FloatArray, wanted: FloatArray, size: SizeField) -> FloatArray:
    """Return points inside the loop: a layer along it first, then a packing of the rest.

    - `wanted`, shape (n,): sides of triangles at the points of the loop [mm].
    """
    tangent = np.roll(coarse, -1, axis=0) - np.roll(coarse, 1, axis=0)
    tangent /= np.hypot(*tangent.T)[:, None]
    # The height of a triangle with equal sides.
    layer = coarse + np.column_stack([-tangent[:, 1], tangent[:, 0]]) * wanted[:, None] * np.sqrt(0.75)
    good = inside(layer, coarse) & (distance_to_polygon(layer, coarse) > 0.7 * wanted)
    pitch = 2.0 ** (round(SERIES * math.log2(wanted.min() / PITCH)) / SERIES)
    grid = _graded_grid(coarse.min(axis=0), coarse.max(axis=0), pitch, size)
    grid = grid[inside(grid, coarse)]
    depth, grid_size = distance_to_polygon(grid, coarse), 2.0 * size(grid)
    deep = depth > 0.62 * grid_size
    order = np.argsort(np.round(depth[deep] / (PITCH * pitch), 1), kind="stable")
    candidates = np.concatenate([layer[good], grid[deep][order]])
    if len(candidates) == 0:
        return np.empty((0, 2))
    radius = 0.8 * np.concatenate([0.9 * wanted[good], grid_size[deep][order]])
    return candidates[pack_points(candidates, radius, coarse)]


def _graded_grid(low: FloatArray, high: FloatArray, pitch: float, size: SizeField) -> FloatArray:
    """Return points of a grid, its pitch two or four times as large where triangles are so many times as large as the smallest.

    It stands still in space, whatever it covers: a slightly other loop gets the same points.
    """
    first, last = np.floor(low / (4.0 * pitch)), np.ceil(high / (4.0 * pitch))
    blocks = 4.0 * np.stack(
        np.meshgrid(np.arange(first[0], last[0]), np.arange(first[1], last[1])), axis=-1
    ).reshape(-1, 2)
    larger = 2.0 * size(pitch * (blocks + 2.0)) / (PITCH * pitch)
    points = []
    for times, least, most in ((1, 0.0, 2.0), (2, 2.0, 4.0), (4, 4.0, np.inf)):
        places = np.arange(0, 4, times) + 0.5 * times
        inner = np.stack(np.meshgrid(places, places), axis=-1).reshape(-1, 2)
        chosen = blocks[(larger >= least) & (larger < most)]
        points.append((chosen[:, None] + inner).reshape(-1, 2))
    grid = np.concatenate(points)
    return pitch * (grid + UNEVEN * np.sin(grid @ np.array([[1.7, 3.1], [2.9, 1.3]])))


def _neighbours(sides: IntArray, n_sides: int) -> IntArray:
    """Return the triangle across the side opposite to each corner, -1 at the boundary."""
    n_t = len(sides)
    opposite = sides[:, [1, 2, 0]]
    flat = opposite.ravel()
    owner = np.repeat(np.arange(n_t), 3)
    order = np.argsort(flat, kind="stable")
    first_of_side = np.concatenate([[True], np.diff(flat[order]) != 0])
    first, second = np.full(n_sides, -1), np.full(n_sides, -1)
    first[flat[order][first_of_side]] = owner[order][first_of_side]
    second[flat[order][~first_of_side]] = owner[order][~first_of_side]
    return np.where(first[opposite] == np.arange(n_t)[:, None], second[opposite], first[opposite])


def _pair(points: FloatArray, triangles: IntArray, neighbours: IntArray) -> tuple[IntArray, BoolArray]:
    """Merge pairs of triangles, best first; return the quadrilaterals and which triangles were used."""
    quality, corners, members = candidate_pairs(points, triangles, neighbours)
    order = np.argsort(-quality, kind="stable")
    order = order[quality[order] >= WORST_PAIR]
    chosen, used = choose_pairs(order, members, len(triangles))
    return corners[chosen], used


def _subdivide(
    points: FloatArray, middles: FloatArray, sides: IntArray, quads: IntArray, triangles: IntArray
) -> tuple[FloatArray, IntArray]:
    """Split quadrilaterals in four and triangles in three through the middles of their sides."""
    n = len(points)

    def middle(a: IntArray, b: IntArray) -> IntArray:
        return n + np.searchsorted(sides, np.minimum(a, b) * n + np.maximum(a, b))

    x = np.concatenate([points, middles, points[quads].mean(axis=1), points[triangles].mean(axis=1)])
    a, b, c, d = quads.T
    ab, bc, cd, da = middle(a, b), middle(b, c), middle(c, d), middle(d, a)
    m = n + len(sides) + np.arange(len(quads))
    parts = [[a, ab, m, da], [ab, b, bc, m], [m, bc, c, cd], [da, m, cd, d]]
    a, b, c = triangles.T
    ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
    m = n + len(sides) + len(quads) + np.arange(len(triangles))
    parts += [[a, ab, m, ca], [ab, b, bc, m], [ca, m, bc, c]]
    return x, np.concatenate([np.column_stack(p) for p in parts]).astype(np.int64)


def smooth(x: FloatArray, quads: IntArray, held: BoolArray, sweeps: int) -> None:
    """Smooth the nodes that are not held, in place, without making the worst element around them worse.

    All nodes of the boundary are held.
    """
    smooth_guarded(x, quads, *elements_around(quads, len(x)), held, sweeps)


def renumber(x: FloatArray, quads: IntArray, nodes: IntArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Renumber the nodes so that equations over the mesh are quickly eliminated; `nodes` of the loop are translated too."""
    order = cuthill_mckee(quads, *elements_around(quads, len(x)), nodes[::2])
    number = np.empty(len(x), dtype=np.int64)
    number[order] = np.arange(len(x))
    return np.ascontiguousarray(x[order]), np.ascontiguousarray(number[quads]), number[nodes]


def grid_mesh(r: FloatArray, z: FloatArray) -> Mesh:
    """Return a structured mesh over the grid lines `r` and `z`; its loop runs counter-clockwise from (0, 0)."""
    n_r, n_z = len(r), len(z)
    number = (
        np.arange(n_r * n_z).reshape(n_z, n_r) if n_r <= n_z else np.arange(n_r * n_z).reshape(n_r, n_z).T
    )
    x = np.empty((n_r * n_z, 2))
    x[number.ravel()] = np.stack(np.meshgrid(r, z), axis=-1).reshape(-1, 2)
    corners = [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    loop = np.concatenate([number[0, :], number[1:, -1], number[-1, -2::-1], number[-2:0:-1, 0]])
    return Mesh(x, np.ascontiguousarray(quads, dtype=np.int64), loop, qualities(x, quads.astype(np.int64)))
