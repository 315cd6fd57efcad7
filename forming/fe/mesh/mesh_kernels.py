"""Loops of the mesher: packing of points, pairing of triangles, quality, smoothing."""

from __future__ import annotations

import numpy as np
from numba import njit

from .shape import FloatArray, IntArray


@njit(cache=True)
def pack_points(candidates: FloatArray, radius: FloatArray, seeds: FloatArray) -> np.ndarray:
    """Return which candidates to keep: in order, each one that has no accepted point within its radius."""
    n_seeds = seeds.shape[0]
    n = candidates.shape[0]
    cell = radius.min()
    low_r = min(candidates[:, 0].min(), seeds[:, 0].min())
    low_z = min(candidates[:, 1].min(), seeds[:, 1].min())
    high_r = max(candidates[:, 0].max(), seeds[:, 0].max())
    high_z = max(candidates[:, 1].max(), seeds[:, 1].max())
    n_r = int((high_r - low_r) / cell) + 2
    n_z = int((high_z - low_z) / cell) + 2
    head = np.full((n_r, n_z), -1)
    following = np.full(n_seeds + n, -1)
    points = np.empty((n_seeds + n, 2))
    keep = np.zeros(n, np.bool_)
    count = 0
    for i in range(n_seeds + n):
        if i < n_seeds:
            r = seeds[i, 0]
            z = seeds[i, 1]
        else:
            r = candidates[i - n_seeds, 0]
            z = candidates[i - n_seeds, 1]
        a = int((r - low_r) / cell)
        b = int((z - low_z) / cell)
        free = True
        if i >= n_seeds:
            reach = radius[i - n_seeds]
            w = int(reach / cell) + 1
            for p in range(max(0, a - w), min(n_r, a + w + 1)):
                for q in range(max(0, b - w), min(n_z, b + w + 1)):
                    k = head[p, q]
                    while k >= 0:
                        if (points[k, 0] - r) ** 2 + (points[k, 1] - z) ** 2 < reach * reach:
                            free = False
                            break
                        k = following[k]
                    if not free:
                        break
                if not free:
                    break
            keep[i - n_seeds] = free
        if free:
            points[count, 0] = r
            points[count, 1] = z
            following[count] = head[a, b]
            head[a, b] = count
            count += 1
    return keep


@njit(cache=True)
def corner_quality(x: FloatArray, a: int, b: int, c: int, d: int) -> float:
    """Return the smallest sine of the four corners of a quadrilateral (scaled Jacobian)."""
    worst = 1e9
    corners = (a, b, c, d)
    for k in range(4):
        i = corners[k]
        j = corners[(k + 1) % 4]
        m = corners[(k + 3) % 4]
        ur = x[j, 0] - x[i, 0]
        uz = x[j, 1] - x[i, 1]
        wr = x[m, 0] - x[i, 0]
        wz = x[m, 1] - x[i, 1]
        sine = (ur * wz - uz * wr) / (np.sqrt((ur * ur + uz * uz) * (wr * wr + wz * wz)) + 1e-30)
        worst = min(worst, sine)
    return worst


@njit(cache=True)
def qualities(x: FloatArray, quads: IntArray) -> FloatArray:
    """Return the scaled Jacobian of each element, 1 for a rectangle, at most 0 for a folded one."""
    result = np.empty(quads.shape[0])
    for e in range(quads.shape[0]):
        result[e] = corner_quality(x, quads[e, 0], quads[e, 1], quads[e, 2], quads[e, 3])
    return result


@njit(cache=True)
def candidate_pairs(
    x: FloatArray, triangles: IntArray, neighbours: IntArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return for each inner side the quality, the corners and the two triangles of the merged quadrilateral."""
    n_t = triangles.shape[0]
    quality = np.empty(3 * n_t)
    corners = np.empty((3 * n_t, 4), np.int64)
    members = np.empty((3 * n_t, 2), np.int64)
    m = 0
    for t in range(n_t):
        for k in range(3):
            u = neighbours[t, k]
            if u > t:
                b = triangles[t, (k + 1) % 3]
                c = triangles[t, (k + 2) % 3]
                d = triangles[u, 0] + triangles[u, 1] + triangles[u, 2] - b - c
                corners[m, 0] = triangles[t, k]
                corners[m, 1] = b
                corners[m, 2] = d
                corners[m, 3] = c
                members[m, 0] = t
                members[m, 1] = u
                quality[m] = corner_quality(x, triangles[t, k], b, d, c)
                m += 1
    return quality[:m], corners[:m], members[:m]


@njit(cache=True)
def choose_pairs(order: IntArray, members: IntArray, n_triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Return which pairs to merge, taken in `order` while both triangles are free, and which are used."""
    used = np.zeros(n_triangles, np.bool_)
    chosen = np.zeros(members.shape[0], np.bool_)
    for i in order:
        t = members[i, 0]
        u = members[i, 1]
        if not used[t] and not used[u]:
            used[t] = True
            used[u] = True
            chosen[i] = True
    return chosen, used


@njit(cache=True)
def elements_around(quads: IntArray, n: int) -> tuple[IntArray, IntArray]:
    """Return corners of elements by node: those of node i are ``corners[first[i] : first[i + 1]]``, each 4 element + place."""
    first = np.zeros(n + 1, np.int64)
    for e in range(quads.shape[0]):
        for a in range(4):
            first[quads[e, a] + 1] += 1
    for i in range(n):
        first[i + 1] += first[i]
    place = first.copy()
    corners = np.empty(4 * quads.shape[0], np.int64)
    for e in range(quads.shape[0]):
        for a in range(4):
            node = quads[e, a]
            corners[place[node]] = 4 * e + a
            place[node] += 1
    return first, corners


@njit(cache=True)
def smooth_guarded(
    x: FloatArray, quads: IntArray, first: IntArray, corners: IntArray, held: np.ndarray, sweeps: int
) -> None:
    """Move free nodes towards the mean of their neighbours where the worst element around does not suffer.

    Corner c is ``quads[c // 4, c % 4]``; those at node i are ``corners[first[i] : first[i + 1]]``.
    """
    quality, moved = qualities(x, quads), np.empty(np.diff(first).max())
    for _ in range(sweeps):
        for i in range(x.shape[0]):
            if held[i]:
                continue
            mean_r = 0.0
            mean_z = 0.0
            n = first[i + 1] - first[i]
            before = 1e9
            # Inside the mesh, the next corner of each element around is another neighbour.
            for c in corners[first[i] : first[i + 1]]:
                neighbour = quads[c // 4, (c + 1) % 4]
                mean_r += x[neighbour, 0] / n
                mean_z += x[neighbour, 1] / n
                before = min(before, quality[c // 4])
            old_r = x[i, 0]
            old_z = x[i, 1]
            weight = 0.7
            for _attempt in range(2):
                x[i, 0] = old_r + weight * (mean_r - old_r)
                x[i, 1] = old_z + weight * (mean_z - old_z)
                after = 1e9
                for k in range(n):
                    e = corners[first[i] + k] // 4
                    moved[k] = corner_quality(x, quads[e, 0], quads[e, 1], quads[e, 2], quads[e, 3])
                    after = min(after, moved[k])
                if after >= min(before, 0.75):
                    for k in range(n):
                        quality[corners[first[i] + k] // 4] = moved[k]
                    break
                x[i, 0] = old_r
                x[i, 1] = old_z
                weight *= 0.4


@njit(cache=True)
def _nodes_around(quads: IntArray, first: IntArray, corners: IntArray) -> tuple[IntArray, IntArray]:
    """Return the other nodes of the elements around each node, once each, and where those of node i begin, shape (n + 1,)."""
    n = first.shape[0] - 1
    begins = np.zeros(n + 1, np.int64)
    neighbours = np.empty(3 * corners.shape[0], np.int64)
    seen_from = np.full(n, -1)
    count = 0
    for i in range(n):
        seen_from[i] = i
        for c in corners[first[i] : first[i + 1]]:
            for a in range(4):
                node = quads[c // 4, a]
                if seen_from[node] != i:
                    seen_from[node] = i
                    neighbours[count] = node
                    count += 1
        begins[i + 1] = count
    return neighbours, begins


@njit(cache=True)
def cuthill_mckee(quads: IntArray, first: IntArray, corners: IntArray, starts: IntArray) -> IntArray:
    """Return the nodes of a mesh in an order in which equations over it are quickly eliminated.

    Cuthill and McKee (ACM 1969) take them in the order of a breadth-first search, neighbours of few neighbours first. Where it
    starts decides how wide the fronts get: the order from the best of the `starts` is returned. `first` and `corners` as in
    `smooth_guarded`.
    """
    n = first.shape[0] - 1
    neighbours, begins = _nodes_around(quads, first, corners)
    best = np.arange(n)
    least = np.inf
    for start in starts:
        order = np.full(n, start)
        reached = np.zeros(n, np.bool_)
        reached[start] = True
        count = 1
        # Squared widths of the columns: down to the last row in which one or those before have an entry.
        work = 0.0
        for k in range(n):
            begin = count
            for node in neighbours[begins[order[k]] : begins[order[k] + 1]]:
                if reached[node]:
                    continue
                reached[node] = True
                elements = first[node + 1] - first[node]
                place = count
                while place > begin:
                    before = order[place - 1]
                    if first[before + 1] - first[before] <= elements:
                        break
                    order[place] = before
                    place -= 1
                order[place] = node
                count += 1
            work += float(count - k) ** 2
            if work >= least:
                break
        if work < least and count == n:
            best, least = order, work
    return best
