"""When surface nodes reach the end of a rounding of a tool, where the workpiece may leave it.

An increment is a straight way with the direction of its end. A node that in one increment turns off a rounding
onto the straight surface behind it does not sink on the way: it is pushed against the tool, and the contact goes on where
there should be none. An increment therefore ends where a node arrives, and the one before ends shortly ahead of it.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .mesh.shape import FloatArray, IntArray
from .tooling import Tool

#: A node closer to the tool than this slides along it [mm].
CLOSE = 1e-3


@njit(cache=True)
def _soonest(
    x: FloatArray, velocity: FloatArray, chain: IntArray, segments: FloatArray, offset: FloatArray, late: float
) -> float:
    """Return the time until the first node reaches the end of a convex arc [s], at least `late` mm of way from now."""
    soonest = np.inf
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
        for n in chain:
            dr = x[n, 0] - cr
            dz = x[n, 1] - cz
            distance = np.sqrt(dr * dr + dz * dz)
            from_start = sense * (r0 * dz - z0 * dr)
            to_end = sense * (dr * z1 - dz * r1)
            if distance - radius > CLOSE or from_start < 0.0 or to_end < 0.0:
                continue
            along = sense * (dr * velocity[n, 1] - dz * velocity[n, 0]) / distance
            left = to_end if along > 0.0 else from_start
            way = radius * np.arcsin(min(1.0, left / (distance * radius)))
            if abs(along) > 0.0 and way > late:
                soonest = min(soonest, way / abs(along))
    return soonest


def until_arrival(x: FloatArray, velocity: FloatArray, chain: IntArray, tools: list[Tool], late: float) -> float:
    """Return the time until a node of the surface arrives at the end of a rounding [s]; inf: none slides on one.

    - `velocity`, shape (n, 2) [mm/s]; `late`: a node as close to the end as this has arrived [mm].
    """
    return min(
        float(_soonest(x, velocity - t.velocity, chain, t.segments, t.offset, late)) for t in tools
    )
