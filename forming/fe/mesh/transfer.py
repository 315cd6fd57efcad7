"""Transfer of the state from an old mesh to a new one over the same region."""

from __future__ import annotations

import numpy as np
from numba import njit

from .shape import ETA, N_GAUSS, XI, FloatArray, IntArray, local_coordinates

#: A point with local coordinates below this belongs to no other element.
WELL_INSIDE = 0.999
#: Search grid over a mesh: lowest r and z, width of a cell [mm], numbers of cells along r and z.
Grid = tuple[float, float, float, int, int]


@njit(cache=True)
def bin_elements(x: FloatArray, quads: IntArray, grid: Grid) -> tuple[IntArray, IntArray]:
    """Return for each cell of a grid the elements whose bounding box meets it, as (start, list)."""
    low_r, low_z, cell, n_r, n_z = grid
    box = np.empty((quads.shape[0], 4), np.int64)
    start = np.zeros(n_r * n_z + 1, np.int64)
    for e in range(quads.shape[0]):
        corners = x[quads[e]]
        box[e, 0] = max(0, int((corners[:, 0].min() - low_r) / cell))
        box[e, 1] = min(n_r - 1, int((corners[:, 0].max() - low_r) / cell))
        box[e, 2] = max(0, int((corners[:, 1].min() - low_z) / cell))
        box[e, 3] = min(n_z - 1, int((corners[:, 1].max() - low_z) / cell))
        for i in range(box[e, 0], box[e, 1] + 1):
            for j in range(box[e, 2], box[e, 3] + 1):
                start[i * n_z + j + 1] += 1
    for k in range(n_r * n_z):
        start[k + 1] += start[k]
    position = start.copy()
    members = np.empty(start[-1], np.int64)
    for e in range(quads.shape[0]):
        for i in range(box[e, 0], box[e, 1] + 1):
            for j in range(box[e, 2], box[e, 3] + 1):
                members[position[i * n_z + j]] = e
                position[i * n_z + j] += 1
    return start, members


@njit(cache=True)
def _miss(pr: float, pz: float, xi: float, eta: float, xe: FloatArray) -> float:
    """Return how far local coordinates miss their point, in element sizes; 0 where they were found.

    Far from an element they need not be: what Newton's method ends with can then look as if it were inside.
    """
    dr = -pr
    dz = -pz
    for a in range(4):
        n = 0.25 * (1.0 + XI[a] * xi) * (1.0 + ETA[a] * eta)
        dr += n * xe[a, 0]
        dz += n * xe[a, 1]
    size = abs(xe[2, 0] - xe[0, 0]) + abs(xe[2, 1] - xe[0, 1])
    miss = np.hypot(dr, dz) / size
    return miss if miss > 1e-3 else 0.0


@njit(cache=True)
def _beyond(pr: float, pz: float, xe: FloatArray) -> bool:
    """Return whether a point lies beyond a side of an element."""
    for a in range(4):
        b = (a + 1) % 4
        if (xe[b, 0] - xe[a, 0]) * (pz - xe[a, 1]) < (xe[b, 1] - xe[a, 1]) * (pr - xe[a, 0]):
            return True
    return False


@njit(cache=True)
def locate(
    pr: float,
    pz: float,
    x: FloatArray,
    quads: IntArray,
    grid: Grid,
    start: IntArray,
    members: IntArray,
    local: FloatArray,
    guess: int,
) -> int:
    """Return the element that holds the point, or the nearest; write its local coordinates, bounded to +-1.

    The element `guess` is looked at first. A point near its sides may be given to another one, which does not hang on the guess.
    """
    low_r, low_z, cell, n_r, n_z = grid
    ci = min(n_r - 1, max(0, int((pr - low_r) / cell)))
    cj = min(n_z - 1, max(0, int((pz - low_z) / cell)))
    xe = np.empty((4, 2))
    for a in range(4):
        xe[a, 0] = x[quads[guess, a], 0]
        xe[a, 1] = x[quads[guess, a], 1]
    if not _beyond(pr, pz, xe):
        local[0], local[1] = local_coordinates(pr, pz, xe)
        if max(abs(local[0]), abs(local[1])) < WELL_INSIDE and _miss(pr, pz, local[0], local[1], xe) == 0.0:
            return guess
    # The element that holds the point is one of the point's own cell, and the point is in its bounding box.
    for k in range(start[ci * n_z + cj], start[ci * n_z + cj + 1]):
        e = members[k]
        for a in range(4):
            xe[a, 0] = x[quads[e, a], 0]
            xe[a, 1] = x[quads[e, a], 1]
        if min(xe[0, 0], xe[1, 0], xe[2, 0], xe[3, 0]) <= pr <= max(
            xe[0, 0], xe[1, 0], xe[2, 0], xe[3, 0]
        ) and min(xe[0, 1], xe[1, 1], xe[2, 1], xe[3, 1]) <= pz <= max(
            xe[0, 1], xe[1, 1], xe[2, 1], xe[3, 1]
        ):
            local[0], local[1] = local_coordinates(pr, pz, xe)
            if max(abs(local[0]), abs(local[1])) <= 1.0 and _miss(pr, pz, local[0], local[1], xe) == 0.0:
                return e
    nearest = 0
    distance = 1e30
    for ring in range(6):
        for i in range(max(0, ci - ring), min(n_r, ci + ring + 1)):
            for j in range(max(0, cj - ring), min(n_z, cj + ring + 1)):
                if max(abs(i - ci), abs(j - cj)) != ring:
                    continue
                for k in range(start[i * n_z + j], start[i * n_z + j + 1]):
                    e = members[k]
                    for a in range(4):
                        xe[a, 0] = x[quads[e, a], 0]
                        xe[a, 1] = x[quads[e, a], 1]
                    xi, eta = local_coordinates(pr, pz, xe)
                    d = max(abs(xi), abs(eta))
                    miss = _miss(pr, pz, xi, eta, xe)
                    # What missed is outside, however small the coordinates: else it beats the element whose side is at the point.
                    if miss > 0.0:
                        d = max(d, 1.0) + miss
                    if d < distance:
                        distance = d
                        nearest = e
                        local[0] = min(1.0, max(-1.0, xi))
                        local[1] = min(1.0, max(-1.0, eta))
        if distance <= 1.0000001 or (ring >= 1 and distance < 1.6):
            break
    return nearest


@njit(cache=True)
def patch_range(quads: IntArray, gauss: FloatArray, n_nodes: int) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and largest value of each field in each element and its neighbours, [e, c]."""
    n_e, fields = quads.shape[0], gauss.shape[2]
    lowest = np.full((n_nodes, fields), np.inf)
    highest = -lowest
    low = np.full((n_e, fields), np.inf)
    high = -low
    for e in range(n_e):
        for c in range(fields):
            smallest = min(gauss[e, 0, c], gauss[e, 1, c], gauss[e, 2, c], gauss[e, 3, c])
            largest = max(gauss[e, 0, c], gauss[e, 1, c], gauss[e, 2, c], gauss[e, 3, c])
            for a in range(4):
                n = quads[e, a]
                lowest[n, c] = min(lowest[n, c], smallest)
                highest[n, c] = max(highest[n, c], largest)
    for e in range(n_e):
        for a in range(4):
            n = quads[e, a]
            for c in range(fields):
                low[e, c] = min(low[e, c], lowest[n, c])
                high[e, c] = max(high[e, c], highest[n, c])
    return low, high


@njit(cache=True)
def interpolate_state(
    x_old: FloatArray,
    quads_old: IntArray,
    gauss_old: FloatArray,
    low: FloatArray,
    high: FloatArray,
    nodal_old: FloatArray,
    x_new: FloatArray,
    quads_new: IntArray,
    grid: Grid,
    start: IntArray,
    members: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the fields of Gauss points [e, g, c] and nodes [n, c] on the new mesh.

    Gauss point fields are taken bilinearly from the points of the owner element alone: averaging over
    nodes first would smear the shear layer at the surface. Towards the element's edge this extrapolates, so
    the value is kept within the range of the element and its neighbours: otherwise the many remeshings
    of a long run amplify a peak without bound.
    """
    gauss_new = np.zeros((quads_new.shape[0], 4, gauss_old.shape[2]))
    nodal_new = np.zeros((x_new.shape[0], nodal_old.shape[1]))
    local = np.zeros(2)
    stretch = np.sqrt(3.0)
    k = 0
    for e in range(quads_new.shape[0]):
        for g in range(4):
            pr = 0.0
            pz = 0.0
            for a in range(4):
                pr += N_GAUSS[g, a] * x_new[quads_new[e, a], 0]
                pz += N_GAUSS[g, a] * x_new[quads_new[e, a], 1]
            k = locate(pr, pz, x_old, quads_old, grid, start, members, local, k)
            for a in range(4):
                weight = 0.25 * (1.0 + XI[a] * local[0] * stretch) * (1.0 + ETA[a] * local[1] * stretch)
                for c in range(gauss_old.shape[2]):
                    gauss_new[e, g, c] += weight * gauss_old[k, a, c]
            for c in range(gauss_old.shape[2]):
                gauss_new[e, g, c] = min(high[k, c], max(low[k, c], gauss_new[e, g, c]))
    for n in range(x_new.shape[0]):
        k = locate(x_new[n, 0], x_new[n, 1], x_old, quads_old, grid, start, members, local, k)
        for a in range(4):
            weight = 0.25 * (1.0 + XI[a] * local[0]) * (1.0 + ETA[a] * local[1])
            for c in range(nodal_old.shape[1]):
                nodal_new[n, c] += weight * nodal_old[quads_old[k, a], c]
    return gauss_new, nodal_new


def search_grid(x: FloatArray, quads: IntArray) -> Grid:
    """Return a search grid over a mesh."""
    low_r, low_z = x.min(axis=0) - 1e-6
    high_r, high_z = x.max(axis=0)
    cell = 0.5 * float(np.sqrt((high_r - low_r) * (high_z - low_z) * 4.0 / len(quads)))
    return low_r, low_z, cell, int((high_r - low_r) / cell) + 1, int((high_z - low_z) / cell) + 1


def shape_weights(points: FloatArray, x: FloatArray, quads: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the nodes of the element around each point, or of the nearest, and their shape functions, shape (n, 4)."""
    grid = search_grid(x, quads)
    local, found = _located(points, x, quads, grid, *bin_elements(x, quads, grid))
    return quads[found], 0.25 * (1.0 + np.outer(local[:, 0], XI)) * (1.0 + np.outer(local[:, 1], ETA))


@njit(cache=True)
def _located(
    points: FloatArray, x: FloatArray, quads: IntArray, grid: Grid, start: IntArray, members: IntArray
) -> tuple[FloatArray, IntArray]:
    """Return the local coordinates of points, shape (n, 2), and the elements they belong to, shape (n,)."""
    local, found = np.zeros((points.shape[0], 2)), np.empty(points.shape[0], np.int64)
    for i in range(points.shape[0]):
        guess = found[i - 1] if i > 0 else 0
        found[i] = locate(points[i, 0], points[i, 1], x, quads, grid, start, members, local[i], guess)
    return local, found


def transfer(
    x_old: FloatArray,
    quads_old: IntArray,
    gauss_old: FloatArray,
    nodal_old: FloatArray,
    x_new: FloatArray,
    quads_new: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """Return Gauss point fields, shape (n_e, 4, c), and nodal fields, shape (n, d), on the new mesh."""
    grid = search_grid(x_old, quads_old)
    start, members = bin_elements(x_old, quads_old, grid)
    low, high = patch_range(quads_old, gauss_old, len(x_old))
    return interpolate_state(
        x_old, quads_old, gauss_old, low, high, nodal_old, x_new, quads_new, grid, start, members
    )
