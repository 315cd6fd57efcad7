"""All-quadrilateral meshing of any closed loop.

Triangles of twice the wanted size between every second boundary node, pairs of them merged to
quadrilaterals, then quadrilaterals split in four and triangles in three, smoothed, renumbered.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order
from scipy.spatial import Delaunay

from .mesh_kernels import candidate_pairs, choose_pairs, pack_points, qualities, relax_edges, smooth_guarded
from .polyline import SizeField, distance_to_polygon, inside
from .shape import FloatArray, IntArray, last_rows

BoolArray = npt.NDArray[np.bool_]


#: Triangles are merged where the quadrilateral has at least this scaled Jacobian.
WORST_PAIR = 0.35
#: Inner points are chosen from a grid so many times as fine as the smallest triangles.
PITCH = 3.0
#: Nodes from which a numbering is tried.
STARTS = 12


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
    points = np.concatenate([coarse, _interior(coarse, size)])
    n_fixed = len(coarse)
    smallest = 2.0 * float(size(coarse).min())
    rounds = 3
    for k in range(rounds + 1):
        triangles = Delaunay(points).simplices.astype(np.int64)
        area = _areas(points, triangles)
        keep = inside(points[triangles].mean(axis=1), coarse) & (np.abs(area) > 1e-6 * smallest**2)
        triangles, area = triangles[keep], area[keep]
        triangles[area < 0] = triangles[area < 0][:, [0, 2, 1]]
        if k == rounds:
            break
        edges = _unique_edges(_edges(triangles), len(points))
        wanted = 2.0 * size(points)
        before = points.copy()
        relax_edges(points, edges, n_fixed, wanted, 4)
        free = np.arange(n_fixed, len(points))
        outside = ~inside(points[free], coarse)
        points[free[outside]] = before[free[outside]]
        near = distance_to_polygon(points[free], coarse) < 0.35 * wanted[free]
        points = np.delete(points, free[near], axis=0)
    used = np.zeros(len(points), dtype=bool)
    used[:n_fixed] = True
    used[triangles.ravel()] = True
    number = np.cumsum(used) - 1
    triangles = number[triangles]
    return points[used], triangles, _edges(triangles)


def _interior(coarse: FloatArray, size: SizeField) -> FloatArray:
    """Return start points inside the loop: a layer along it first, then a packing of the rest."""
    wanted = 2.0 * size(coarse)
    smallest = float(wanted.min())
    if not smallest > 0.0:
        raise MeshError(f"elements of {0.5 * smallest:g} mm")
    tangent = np.roll(coarse, -1, axis=0) - np.roll(coarse, 1, axis=0)
    tangent /= np.hypot(*tangent.T)[:, None]
    layer = coarse + np.column_stack([-tangent[:, 1], tangent[:, 0]]) * wanted[:, None] * 0.95
    good = inside(layer, coarse) & (distance_to_polygon(layer, coarse) > 0.7 * wanted)
    grid = _graded_grid(coarse.min(axis=0), coarse.max(axis=0), smallest / PITCH, smallest, size)
    grid = grid[inside(grid, coarse)]
    depth, grid_size = distance_to_polygon(grid, coarse), 2.0 * size(grid)
    deep = depth > 0.62 * grid_size
    order = np.argsort(np.round(depth[deep] / smallest, 1), kind="stable")
    candidates = np.concatenate([layer[good], grid[deep][order]])
    if len(candidates) == 0:
        return np.empty((0, 2))
    radius = 0.8 * np.concatenate([0.9 * wanted[good], grid_size[deep][order]])
    return candidates[pack_points(candidates, radius, coarse)]


def _graded_grid(
    low: FloatArray, high: FloatArray, pitch: float, smallest: float, size: SizeField
) -> FloatArray:
    """Return a grid of points in rows, of which every second or fourth stays where triangles are four or eight times as large."""
    columns, rows = np.ceil((high - low) / (4.0 * pitch)).astype(np.int64)
    r, z = (low[k] + pitch * (np.arange(4 * n) + 0.5) for k, n in enumerate((columns, rows)))
    middles = np.stack(np.meshgrid(r[2::4] - 0.5 * pitch, z[2::4] - 0.5 * pitch), axis=-1)
    larger = 2.0 * size(middles.reshape(-1, 2)) / smallest
    every = np.array([1, 2, 4])[np.digitize(larger, (4.0, 8.0))].reshape(rows, columns)
    every = every.repeat(4, axis=0).repeat(4, axis=1)
    j, i = np.ogrid[: 4 * rows, : 4 * columns]
    j, i = np.nonzero((i % every == 0) & (j % every == 0))
    points = np.column_stack([r[i], z[j]])
    return points[(points < high).all(axis=1)]


def _edges(triangles: IntArray) -> IntArray:
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def _unique_edges(edges: IntArray, n: int) -> IntArray:
    """Return each of the edges between `n` points once, its lower number first, in rising order, shape (m, 2)."""
    keys = np.unique(edges.min(axis=1) * n + edges.max(axis=1))
    return np.column_stack(np.divmod(keys, n))


def _areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


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
    """Smooth the nodes that are not held, in place, without making the worst element around them worse."""
    n = len(x)
    edges = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
    edges = _unique_edges(edges, n)
    edges = np.concatenate([edges, edges[:, ::-1]])
    edges = edges[np.argsort(edges[:, 0], kind="stable")]
    corners = quads.ravel()
    order = np.argsort(corners, kind="stable")
    numbers = np.arange(n + 1)
    smooth_guarded(
        x,
        quads,
        np.searchsorted(edges[:, 0], numbers),
        np.ascontiguousarray(edges[:, 1]),
        np.searchsorted(corners[order], numbers),
        order // 4,
        held,
        sweeps,
    )


def renumber(x: FloatArray, quads: IntArray, nodes: IntArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Renumber the nodes so that equations over the mesh are quickly eliminated; `nodes` of the loop are translated too.

    Cuthill and McKee (ACM 1969) number in the order of a breadth-first search, neighbours of few neighbours first. Where it
    starts decides how wide the fronts get: several nodes of the loop are tried.
    """
    n = len(x)
    rows, columns = np.repeat(quads, 4, axis=1).ravel(), np.tile(quads, (1, 4)).ravel()
    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(n, n)).tocsr()
    by_neighbours = np.argsort(np.diff(graph.indptr), kind="stable")
    place = np.empty(n, dtype=np.int64)
    place[by_neighbours] = np.arange(n)
    graph = graph[by_neighbours][:, by_neighbours]
    graph.sort_indices()
    best, least = np.arange(n), np.inf
    for start in place[nodes[:: -(-len(nodes) // STARTS)]]:
        order = by_neighbours[breadth_first_order(graph, start, return_predecessors=False)]
        number = np.empty(n, dtype=np.int64)
        number[order] = np.arange(n)
        width = last_rows(number[quads], n, 2) - np.arange(2 * n)
        work = float(width @ width)
        if work < least:
            best, least = order, work
    number = np.empty(n, dtype=np.int64)
    number[best] = np.arange(n)
    return np.ascontiguousarray(x[best]), np.ascontiguousarray(number[quads]), number[nodes]


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
