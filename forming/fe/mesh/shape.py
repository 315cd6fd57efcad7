"""Four-node quadrilateral: shape functions at the 2 x 2 Gauss points and elsewhere."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

# The kernels are compiled without fast-math flags, but for two that call no other: with them the last bits depend on what
# else was compiled before - two processes that meet an empty cache would then not give the same numbers.

GAUSS = 1.0 / np.sqrt(3.0)
XI = np.array([-1.0, 1.0, 1.0, -1.0])
ETA = np.array([-1.0, -1.0, 1.0, 1.0])
#: Shape functions and their derivatives, [Gauss point, node]; Gauss point g lies towards node g.
N_GAUSS = 0.25 * (1.0 + np.outer(XI, XI) * GAUSS) * (1.0 + np.outer(ETA, ETA) * GAUSS)
DN_DXI = 0.25 * XI * (1.0 + np.outer(ETA, ETA) * GAUSS)
DN_DETA = 0.25 * ETA * (1.0 + np.outer(XI, XI) * GAUSS)


@njit(cache=True)
def gradients(xe: FloatArray, g: int, dn: FloatArray) -> tuple[float, float, float]:
    """Fill dn[4, 2] with dN/d(r, z) at Gauss point g; return (det J * r, r, det J)."""
    j00 = 0.0
    j01 = 0.0
    j10 = 0.0
    j11 = 0.0
    r = 0.0
    for a in range(4):
        j00 += DN_DXI[g, a] * xe[a, 0]
        j01 += DN_DXI[g, a] * xe[a, 1]
        j10 += DN_DETA[g, a] * xe[a, 0]
        j11 += DN_DETA[g, a] * xe[a, 1]
        r += N_GAUSS[g, a] * xe[a, 0]
    det = j00 * j11 - j01 * j10
    # Divisions cost many times as much as products.
    inverse = 1.0 / det
    for a in range(4):
        dn[a, 0] = inverse * (j11 * DN_DXI[g, a] - j01 * DN_DETA[g, a])
        dn[a, 1] = inverse * (j00 * DN_DETA[g, a] - j10 * DN_DXI[g, a])
    return det * r, r, det


@njit(cache=True)
def half_bandwidth(quads: IntArray) -> int:
    """Return the largest distance between two node numbers of one element."""
    largest = 0
    for e in range(quads.shape[0]):
        low = min(quads[e, 0], quads[e, 1], quads[e, 2], quads[e, 3])
        high = max(quads[e, 0], quads[e, 1], quads[e, 2], quads[e, 3])
        largest = max(largest, high - low)
    return largest


@njit(cache=True)
def last_rows(quads: IntArray, n_nodes: int, each: int) -> IntArray:
    """Return for each column of a matrix over the mesh the last row in which it or one before it has an entry.

    - `each`: unknowns of a node.
    - returns: shape (each * n_nodes,).
    """
    last = np.zeros(each * n_nodes, np.int64)
    for e in range(quads.shape[0]):
        nodes = quads[e]
        low = each * min(nodes[0], nodes[1], nodes[2], nodes[3])
        last[low] = max(last[low], each * (max(nodes[0], nodes[1], nodes[2], nodes[3]) + 1) - 1)
    for i in range(1, each * n_nodes):
        last[i] = max(last[i], last[i - 1])
    return last


@njit(cache=True)
def gauss_volumes(x: FloatArray, quads: IntArray) -> FloatArray:
    """Return the volume of each Gauss point's share, [element, Gauss point], over the full turn [mm3]."""
    volumes = np.empty((quads.shape[0], 4))
    xe = np.empty((4, 2))
    dn = np.empty((4, 2))
    for e in range(quads.shape[0]):
        for a in range(4):
            xe[a, 0] = x[quads[e, a], 0]
            xe[a, 1] = x[quads[e, a], 1]
        for g in range(4):
            w, _, _ = gradients(xe, g, dn)
            volumes[e, g] = 2.0 * np.pi * w
    return volumes


@njit(cache=True)
def nodal_volumes(x: FloatArray, quads: IntArray) -> FloatArray:
    """Return the volume per radian that belongs to each node [mm3], as the lumped heat capacity counts it."""
    volumes = np.zeros(x.shape[0])
    xe = np.empty((4, 2))
    dn = np.empty((4, 2))
    for e in range(quads.shape[0]):
        for a in range(4):
            xe[a, 0] = x[quads[e, a], 0]
            xe[a, 1] = x[quads[e, a], 1]
        for g in range(4):
            w, _, _ = gradients(xe, g, dn)
            for a in range(4):
                volumes[quads[e, a]] += w * N_GAUSS[g, a]
    return volumes


@njit(cache=True)
def local_coordinates(px: float, py: float, xe: FloatArray) -> tuple[float, float]:
    """Return (xi, eta) of a point in the element with corners xe[4, 2], by Newton, bounded to +-3."""
    xi = 0.0
    eta = 0.0
    for _ in range(8):
        fx = -px
        fy = -py
        a = 0.0
        b = 0.0
        c = 0.0
        d = 0.0
        for k in range(4):
            n = 0.25 * (1.0 + XI[k] * xi) * (1.0 + ETA[k] * eta)
            n_xi = 0.25 * XI[k] * (1.0 + ETA[k] * eta)
            n_eta = 0.25 * ETA[k] * (1.0 + XI[k] * xi)
            fx += n * xe[k, 0]
            fy += n * xe[k, 1]
            a += n_xi * xe[k, 0]
            b += n_eta * xe[k, 0]
            c += n_xi * xe[k, 1]
            d += n_eta * xe[k, 1]
        det = a * d - b * c
        step_xi = -(d * fx - b * fy) / det
        step_eta = -(a * fy - c * fx) / det
        xi = min(3.0, max(-3.0, xi + step_xi))
        eta = min(3.0, max(-3.0, eta + step_eta))
        if abs(step_xi) + abs(step_eta) < 1e-7:
            break
    return xi, eta


@njit(cache=True)
def surface_weights(x: FloatArray, chain: IntArray, weights: FloatArray) -> None:
    """Write the surface area per radian that belongs to each node of the chain (consistent, lumped)."""
    weights[:] = 0.0
    for i in range(chain.shape[0] - 1):
        a = chain[i]
        b = chain[i + 1]
        length = np.hypot(x[a, 0] - x[b, 0], x[a, 1] - x[b, 1])
        weights[i] += length * (2.0 * x[a, 0] + x[b, 0]) / 6.0
        weights[i + 1] += length * (x[a, 0] + 2.0 * x[b, 0]) / 6.0
