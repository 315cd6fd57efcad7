"""Surface nodes that reach the end of a rounding of a tool, where the workpiece may leave it.

An increment is a straight way with the direction of its end. A node that in one increment turns off a rounding
onto the straight surface behind it does not sink on the way: it is pushed against the tool, and the contact goes on where
there should be none. An increment therefore ends where a node arrives, and the one before ends shortly ahead of it.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .mesh.shape import FloatArray, IntArray
from .tooling import Tool

#: A node closer to the rounding than this slides along it [mm].
CLOSE = 1e-3
#: A node turns off the rounding in an increment if it arrives in this part of it.
SOON = 0.7


@njit(cache=True)
def ways(
    x: FloatArray, du: FloatArray, chain: IntArray, segments: FloatArray, offset: FloatArray
) -> FloatArray:
    """Return how far each surface node has to go to the end of the rounding that it slides on, shape (n, 2) [mm].

    The second column is how far it goes with the displacements `du` relative to the tool; 0: it is on no rounding.
    A node up to as far behind the end counts, too; its way is negative.
    """
    found = np.zeros((chain.shape[0], 2))
    for k in range(segments.shape[0]):
        radius = segments[k, 7]
        if segments[k, 0] == 0.0 or radius <= 0.0:
            continue
        cr = segments[k, 5] + offset[0]
        cz = segments[k, 6] + offset[1]
        r0 = segments[k, 1] + offset[0] - cr
        z0 = segments[k, 2] + offset[1] - cz
        r1 = segments[k, 3] + offset[0] - cr
        z1 = segments[k, 4] + offset[1] - cz
        sense = 1.0 if r0 * z1 - z0 * r1 > 0.0 else -1.0
        for i in range(chain.shape[0]):
            n = chain[i]
            dr = x[n, 0] - cr
            dz = x[n, 1] - cz
            distance = np.sqrt(dr * dr + dz * dz)
            if abs(distance - radius) > 0.1 * radius:
                continue
            along = sense * (dr * du[n, 1] - dz * du[n, 0]) / distance
            from_start = sense * (r0 * dz - z0 * dr)
            to_end = sense * (dr * z1 - dz * r1)
            left, behind = (to_end, from_start) if along > 0.0 else (from_start, to_end)
            way = radius * np.arcsin(max(-1.0, min(1.0, left / (distance * radius))))
            gap = distance - radius if way >= 0.0 else distance - np.hypot(radius, way)
            if behind > 0.0 and gap < CLOSE and way > -abs(along):
                found[i, 0] = way
                found[i, 1] = abs(along)
    return found


def until_arrival(x: FloatArray, velocity: FloatArray, chain: IntArray, tools: list[Tool], late: float) -> float:
    """Return the time until a node of the surface arrives at the end of a rounding [s]; inf: none slides on one.

    - `velocity`, shape (n, 2) [mm/s]; `late`: a node as close to the end as this has arrived [mm].
    """
    soonest = np.inf
    for tool in tools:
        way, speed = ways(x, velocity - tool.velocity, chain, tool.segments, tool.offset).T
        coming = (way > late) & (speed > 0.0)
        soonest = min(soonest, float((way[coming] / speed[coming]).min(initial=np.inf)))
    return soonest


@njit(cache=True)
def let_go(
    x: FloatArray,
    du: FloatArray,
    chain: IntArray,
    segments: FloatArray,
    offset: FloatArray,
    move: FloatArray,
    active: IntArray,
) -> None:
    """Free the nodes at the edge of a contact that turn off a rounding in an increment: the tool would pull at them."""
    n = chain.shape[0]
    way = ways(x, du - move, chain, segments, offset)
    for i in range(1, n - 1):
        if active[i] == 0 or way[i, 1] == 0.0 or way[i, 0] > SOON * way[i, 1]:
            continue
        for j in (i - 1, i + 1):
            r = x[chain[j], 0] - x[chain[i], 0]
            z = x[chain[j], 1] - x[chain[i], 1]
            ahead = (du[chain[i], 0] - move[0]) * r + (du[chain[i], 1] - move[1]) * z
            if active[j] == 0 and ahead > 0.5 * way[i, 1] * np.hypot(r, z):
                active[i] = 0
                break
