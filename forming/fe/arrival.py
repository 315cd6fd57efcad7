"""When points of the surface arrive: nodes at the end of a rounding of a tool, where they may leave it, points at a tool.

An increment is a straight way with the direction of its end. A node that in one increment turns off a rounding
onto the straight surface behind it does not sink on the way: it is pushed against the tool, and the contact goes on where
there should be none. An increment therefore ends where a node arrives, and the one before ends shortly ahead of it.

Whatever comes to a tool within an increment slides along it for the rest of that only.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

from .contact import gap_and_normal
from .mesh.shape import FloatArray, IntArray
from .tooling import Tool

#: A node closer to the rounding than this slides along it [mm].
CLOSE = 1e-3
#: A node this near to the end has arrived, as a share of the last way.
ARRIVED = 0.25
#: The way before the arrival is cut in two if it is longer than so many last ways.
LAST = 1.5


@njit(cache=True)
def soonest_arrival(
    x: FloatArray,
    velocity: FloatArray,
    chain: IntArray,
    segments: FloatArray,
    offset: FloatArray,
    late: float,
) -> tuple[float, float]:
    """Return the time until a surface node arrives at the end of a convex arc [s], inf: none does, and its speed [mm/s].

    - `velocity`, shape (n, 2): relative to the tool [mm/s].
    - `late`: nodes as close to the end as this do not count [mm].
    """
    soonest = np.inf
    speed = 0.0
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
            sine = (to_end if along > 0.0 else from_start) / (distance * radius)
            way = radius * np.arcsin(min(1.0, sine))
            if way > late and way < soonest * abs(along):
                speed = abs(along)
                soonest = way / speed
    return soonest, speed


def cut_at_arrival(
    x: FloatArray, velocity: FloatArray, chain: IntArray, tools: list[Tool], last: float, dt: float
) -> float:
    """Return the increment `dt` [s], cut where a surface node arrives at the end of a rounding, or its last way before.

    A last way that ends only just past the end stays whole. The rest of it would be an increment as short as it happens to
    be, and where the mesh is new, the body springs by some micrometres whatever the time: divided by next to none, that is
    a velocity with which no further increment converges.

    - `velocity`, shape (n, 2) [mm/s]; `last`: length of that last way [mm].
    """
    for tool in tools:
        time, speed = soonest_arrival(
            x, velocity - tool.velocity, chain, tool.segments, tool.offset, ARRIVED * last
        )
        if time < dt and time * speed >= LAST * last:
            dt = time - last / speed
        elif (dt - time) * speed > ARRIVED * last:
            dt = time
    return dt


@njit(cache=True)
def touching_shares(
    points: FloatArray,
    velocity: FloatArray,
    touching: npt.NDArray[np.bool_],
    segments: FloatArray,
    offset: FloatArray,
    dt: float,
) -> FloatArray:
    """Return for points the share of an increment that is left when they come to a tool, shape (n,).

    A point beside the tool that does not approach it comes in the middle: nothing is known of its way.

    - `points`, `velocity`, shape (n, 2): at the start of the increment; relative to the tool [mm/s].
    - `touching`, shape (n,): points that a tool touches all along; theirs is 1.
    """
    n = points.shape[0]
    shares = np.ones(n)
    for i in range(n):
        if touching[i]:
            continue
        gap, nr, nz = gap_and_normal(points[i, 0], points[i, 1], segments, offset[0], offset[1])
        if gap > 0.0:
            way = -(velocity[i, 0] * nr + velocity[i, 1] * nz) * dt
            shares[i] = max(0.0, 1.0 - gap / way) if way > 0.0 else 0.5
    return shares
