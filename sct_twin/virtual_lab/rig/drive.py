"""Motion of the virtual plate: the commanded speed of a protocol, and the plate on its elastic drive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit

from friction_models.loads import FloatArray

#: Samples a second.
RATE = 1000.0
#: Integration steps of the elastic drive in a sample interval.
_SUBSTEPS = 20


def commanded(
    speeds: Sequence[float],
    distance: float,
    acceleration: float,
    hold: tuple[float, float] | None = None,
) -> FloatArray:
    """Return the commanded plate speed [mm/s], one value a sample, at least as far as `distance` [mm].

    - `speeds`: set values on equal parts of the distance [mm/s].
    - `acceleration`: largest acceleration of the half cosines between set values [mm/s2].
    - `hold`, (distance, time): the plate stops at this distance [mm] and stands so long [s].
    """
    stops: list[tuple[float, float, float]] = []
    share = distance / len(speeds)
    for k, speed in enumerate(speeds):
        begin, end = k * share, (k + 1) * share
        if hold is not None and begin <= hold[0] < end:
            stops += [(speed, hold[0], 0.0), (0.0, hold[0], hold[1])]
            begin = hold[0]
        stops.append((speed, end, 0.0))
    pieces: list[FloatArray] = []
    now = sd = 0.0
    for number, (speed, end, rest) in enumerate(stops):
        ramp = max(0.5 * np.pi * abs(speed - now) / acceleration, 0.02) if speed != now else 0.0
        if now > 0.0 and speed > 0.0:
            # A step is over within half of its part: drives accelerate a moving plate harder than a resting one.
            ramp = min(ramp, share / (speed + now))
        if rest > 0.0:
            # A stop: the ramp down comes first, then the plate stands.
            time = ramp + rest
        else:
            braking = number + 1 < len(stops) and stops[number + 1][0] == 0.0
            brake = max(0.5 * np.pi * speed / acceleration, 0.02) * 0.5 * speed if braking else 0.0
            time = ramp + max(end - brake - sd - 0.5 * (speed + now) * ramp, 0.0) / speed
        count = int(np.ceil(time * RATE)) + (1 if number + 1 == len(stops) else 0)
        t = np.arange(count) / RATE
        phase = np.clip(t / ramp, 0.0, 1.0) if ramp > 0.0 else np.ones(count)
        pieces.append(now + (speed - now) * 0.5 * (1.0 - np.cos(np.pi * phase)))
        sd += 0.5 * (speed + now) * min(ramp, time) + speed * max(time - ramp, 0.0)
        now = speed
    return np.concatenate(pieces)


@njit(cache=True)
def on_elastic_drive(
    drive: FloatArray,
    normal: float,
    mu: float,
    static: float,
    static_length: float,
    stiffness: float,
    damping: float,
    mass: float,
) -> tuple[FloatArray, FloatArray]:  # pragma: no cover - compiled
    """Return plate position [mm] and the force in the drive [N] at the samples.

    The drive pulls the plate through a spring and a damper. A plate at rest stays there until the drive
    overcomes static friction; that share is lost over the first slip.

    - `drive`, shape (n,): position of the drive [mm] at the samples.
    - `normal`: normal force [N].
    - `mu`, `static`: friction coefficient while sliding, and what is added to it at rest.
    - `static_length`: slip over which the addition falls to a half [mm].
    - `stiffness`, `damping`, `mass`: spring [N/mm], damper [N s/mm], plate [N s2/mm].
    """
    n = len(drive)
    position, force = np.zeros(n), np.zeros(n)
    x = v = 0.0
    dt = 1.0 / RATE
    step = dt / _SUBSTEPS
    for k in range(n - 1):
        speed = (drive[k + 1] - drive[k]) / dt
        for j in range(_SUBSTEPS):
            share = (j + 1) / _SUBSTEPS
            pull = stiffness * (drive[k] + share * (drive[k + 1] - drive[k]) - x) + damping * (speed - v)
            friction = (mu + static / (1.0 + (x / static_length) ** 2)) * normal
            if v <= 0.0 and pull <= friction:
                v = 0.0
            else:
                v = max(v + step * (pull - friction) / mass, 0.0)
            x += step * v
        position[k + 1] = x
        force[k + 1] = stiffness * (drive[k + 1] - x) + damping * (speed - v)
    return position, force
