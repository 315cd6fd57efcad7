"""Columns of cells below a surface: regridding, conduction, and how their heat falls to the nodes of the mesh.

A column holds the heat per volume above the temperature of the mesh [N/mm2], in cells whose faces stand at fixed shares
`faces` of its depth. Its lower end stays at the temperature of the mesh: what arrives there, the mesh takes over.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ..mesh.shape import FloatArray, IntArray, nodal_volumes, surface_weights

#: Least depth of a column as a share of the distance to its end.
LEAST = 0.2


@njit(cache=True)
def outward_normals(x: FloatArray, chain: IntArray) -> FloatArray:
    """Return the outward normals at the nodes of a surface with the body on its left, shape (n, 2)."""
    n = chain.shape[0]
    normals = np.zeros((n, 2))
    closed = x[chain[0], 0] == x[chain[n - 1], 0] and x[chain[0], 1] == x[chain[n - 1], 1]
    for i in range(n - 1):
        a, b = chain[i], chain[i + 1]
        length = np.hypot(x[b, 0] - x[a, 0], x[b, 1] - x[a, 1])
        nr = (x[b, 1] - x[a, 1]) / length
        nz = -(x[b, 0] - x[a, 0]) / length
        for k in (i, i + 1):
            normals[k, 0] += nr
            normals[k, 1] += nz
    if closed:
        normals[0] += normals[n - 1]
        normals[n - 1] = normals[0]
    for i in range(n):
        normals[i] /= np.hypot(normals[i, 0], normals[i, 1]) + 1e-30
    return normals


@njit(cache=True)
def column_depths(x: FloatArray, chain: IntArray, nodes: IntArray, shares: FloatArray) -> FloatArray:
    """Return how deep the lower ends of the columns lie below the surface [mm], shape (n,).

    - `nodes`, `shares`, shape (n, 4): nodes around the ends, and their shares.
    """
    n = chain.shape[0]
    depths = np.empty(n)
    normals = outward_normals(x, chain)
    for i in range(n):
        r = x[chain[i], 0]
        z = x[chain[i], 1]
        for a in range(4):
            r -= shares[i, a] * x[nodes[i, a], 0]
            z -= shares[i, a] * x[nodes[i, a], 1]
        depths[i] = max(r * normals[i, 0] + z * normals[i, 1], LEAST * np.hypot(r, z))
    return depths


@njit(cache=True)
def regrid(
    heat: FloatArray, before: FloatArray, after: FloatArray, faces: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return columns of depth `after` with the heat of columns of depth `before`, and what lay deeper [N/mm].

    - `heat`, shape (n, m): per volume; `before`, `after`, shape (n,): depths [mm].
    """
    n, m = heat.shape
    new = np.zeros((n, m))
    spilled = np.zeros(n)
    for i in range(n):
        cell = 0
        filled = 0.0
        below = 0.0
        for j in range(m):
            face = after[i] * faces[j + 1]
            while cell < m and before[i] * faces[cell + 1] <= face:
                filled += heat[i, cell] * before[i] * (faces[cell + 1] - faces[cell])
                cell += 1
            upto = filled
            if cell < m:
                upto += heat[i, cell] * max(face - before[i] * faces[cell], 0.0)
            new[i, j] = (upto - below) / (after[i] * (faces[j + 1] - faces[j]))
            below = upto
        total = 0.0
        for j in range(m):
            total += heat[i, j] * before[i] * (faces[j + 1] - faces[j])
        spilled[i] = total - below
    return new, spilled


@njit(cache=True)
def conduct(
    heat: FloatArray,
    depth: FloatArray,
    faces: FloatArray,
    capacity: FloatArray,
    conductivity: FloatArray,
    dt: float,
    steps: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Advance columns by `dt` [s] in `steps` implicit steps, without and with a heat flux at the surface.

    - `capacity`, `conductivity`, shape (n,): of a volume [N/(mm2 K)], and [N/(s K)].
    - returns: heat without flux; what a flux of 1 N/(mm s) adds to it, shape (n, m); shape (n, 4): temperature of the
      surface without flux [K] and per flux, mean flow out of the lower end without flux [N/(mm s)] and per flux.
    """
    n, m = heat.shape
    # A row for each cell: all columns are worked on at once.
    own, added = heat.T.copy(), np.zeros((m, n))
    width, lower, ratio, pivot = np.empty((m, n)), np.empty((m, n)), np.empty((m, n)), np.empty((m, n))
    out, ends = np.zeros(n), np.zeros((n, 4))
    h = dt / steps
    for j in range(m):
        for i in range(n):
            # out[i] between cell j - 1 and cell j; the last one to the lower end.
            lower[j, i] = out[i]
            half = 0.5 * depth[i] * (faces[min(j + 2, m)] - faces[j])
            out[i] = conductivity[i] / capacity[i] / half
            width[j, i] = depth[i] * (faces[j + 1] - faces[j]) / h
            diagonal = width[j, i] + lower[j, i] + out[i]
            pivot[j, i] = diagonal - (lower[j, i] * ratio[j - 1, i] if j > 0 else 0.0)
            ratio[j, i] = out[i] / pivot[j, i]
    for _ in range(steps):
        for j in range(m):
            for i in range(n):
                own[j, i] *= width[j, i]
                added[j, i] *= width[j, i]
                if j == 0:
                    added[j, i] += 1.0
                else:
                    own[j, i] += lower[j, i] * own[j - 1, i]
                    added[j, i] += lower[j, i] * added[j - 1, i]
                own[j, i] /= pivot[j, i]
                added[j, i] /= pivot[j, i]
        for j in range(m - 2, -1, -1):
            for i in range(n):
                own[j, i] += ratio[j, i] * own[j + 1, i]
                added[j, i] += ratio[j, i] * added[j + 1, i]
        for i in range(n):
            ends[i, 2] += out[i] * own[m - 1, i] / steps
            ends[i, 3] += out[i] * added[m - 1, i] / steps
    for i in range(n):
        first = 0.5 * depth[i] * faces[1]
        ends[i, 0] = own[0, i] / capacity[i]
        ends[i, 1] = added[0, i] / capacity[i] + first / conductivity[i]
    return own.T.copy(), added.T.copy(), ends


@njit(cache=True)
def heat_at_nodes(
    heat: FloatArray,
    depth: FloatArray,
    faces: FloatArray,
    area: FloatArray,
    chain: IntArray,
    middle: FloatArray,
    nodes: IntArray,
    shares: FloatArray,
    n_nodes: int,
) -> FloatArray:
    """Return the heat of the columns as it falls to the nodes of the mesh, per radian [N mm].

    Between the surface, the middle and the lower end it is shared out linearly.

    - `area`, shape (n,): of each column, per radian [mm2]; `middle`, shape (n,): depth of the middle point [mm].
    - `nodes`, `shares`, shape (2, n, 4): nodes around the middle point and the lower end, and their shares.
    """
    total = np.zeros(n_nodes)
    n, m = heat.shape
    for i in range(n):
        at_surface = 0.0
        at_middle = 0.0
        at_end = 0.0
        for j in range(m):
            z = 0.5 * depth[i] * (faces[j] + faces[j + 1])
            amount = heat[i, j] * depth[i] * (faces[j + 1] - faces[j]) * area[i]
            if z < middle[i]:
                u = z / middle[i]
                at_surface += (1.0 - u) * amount
                at_middle += u * amount
            else:
                u = (z - middle[i]) / (depth[i] - middle[i])
                at_middle += (1.0 - u) * amount
                at_end += u * amount
        total[chain[i]] += at_surface
        for a in range(4):
            total[nodes[0, i, a]] += shares[0, i, a] * at_middle
            total[nodes[1, i, a]] += shares[1, i, a] * at_end
    return total


@njit(cache=True)
def before_step(
    x: FloatArray,
    chain: IntArray,
    nodes: IntArray,
    shares: FloatArray,
    heat: FloatArray,
    depth_before: FloatArray,
    area_before: FloatArray,
    faces: FloatArray,
    capacity: FloatArray,
    conductivity: FloatArray,
    dt: float,
    steps: int,
    conductance: FloatArray,
    outside: FloatArray,
    power: FloatArray,
    share: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Conduct in the columns, and say how the flux into them follows from the temperature of the mesh at the surface.

    - `nodes`, `shares`: those around the lower ends; `conductance`, `outside`, `power`, `share`: see `Exchange`.
    - returns: depth [mm] and area per radian [mm2]; heat without flux, and what a flux of 1 N/(mm s) adds; shape (n, 4):
      temperature of the surface without flux [K] and per flux, flux at 0 degC [N/(mm s)] and how it falls per kelvin; shape
      (2, n): heat that enters the mesh [N mm/s] and how it falls per kelvin.
    """
    n = chain.shape[0]
    area = np.zeros(n)
    surface_weights(x, chain, area)
    area *= share
    depth = column_depths(x, chain, nodes, shares)
    # The surface stretches and the columns become thinner; a column that is too deep now leaves its end to the mesh.
    regridded, spilled = regrid(heat, depth_before * area_before / area, depth, faces)
    own, added, ends = conduct(regridded, depth, faces, capacity, conductivity, dt, steps)
    entering = np.empty((2, n))
    for i in range(n):
        h = conductance[i] / area[i]
        bare, by_flux, flow, flow_by_flux = ends[i]
        slope = h / (1.0 + h * by_flux)
        flux = (power[i] + outside[i]) / area[i] / (1.0 + h * by_flux) - slope * bare
        ends[i, 2] = flux
        ends[i, 3] = slope
        entering[0, i] = area[i] * (flow + flow_by_flux * flux + spilled[i] / dt)
        entering[1, i] = area[i] * flow_by_flux * slope
    return depth, area, own, added, ends, entering


@njit(cache=True)
def spread(
    x: FloatArray,
    quads: IntArray,
    heat: FloatArray,
    depth: FloatArray,
    faces: FloatArray,
    area: FloatArray,
    chain: IntArray,
    nodes: IntArray,
    shares: FloatArray,
) -> FloatArray:
    """Return the heat of the columns over the volumes of the nodes that it falls to [N/mm2]; see `heat_at_nodes`."""
    volumes = nodal_volumes(x, quads)
    middle = np.empty(chain.shape[0])
    for i in range(chain.shape[0]):
        # The node of a flat surface owns half of the element below it.
        middle[i] = min(2.0 * volumes[chain[i]] / area[i], 0.5 * depth[i])
    total = heat_at_nodes(heat, depth, faces, area, chain, middle, nodes, shares, x.shape[0])
    for i in range(x.shape[0]):
        total[i] /= volumes[i]
    return total
