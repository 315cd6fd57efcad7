"""The time between the points of a test: while the contact slid, and while it stood still."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .tribo_loads import FloatArray, TriboLoads


def time_steps(loads: TriboLoads, point_starts: Sequence[int] | np.ndarray) -> FloatArray:
    """Return the time since the previous point of the same test [s]; 0 at the first point.

    Without a time column the step follows from distance and speed.

    Examples
    --------
    Without a time, 5 mm at 50 mm/s take 0.1 s:

    >>> loads = TriboLoads.from_array([[50, 20, 500, 0, 1], [50, 20, 500, 5, 1]])
    >>> time_steps(loads, [0]).tolist()
    [0.0, 0.1]
    """
    if loads.t is not None:
        dt = np.diff(loads.t, prepend=loads.t[:1])
    else:
        dt = np.maximum(np.diff(loads.sd, prepend=loads.sd[:1]), 0.0) / np.maximum(loads.v_rel, 1e-9)
    dt[np.asarray(point_starts, dtype=np.int64)] = 0.0
    return dt


#: A gap of time in a test is a rest when it is so much longer than the sliding, and so long at least [s].
REST_FACTOR, LEAST_REST = 5.0, 0.1
#: Steps from which on a test shows how long its points usually take.
LEAST_STEPS = 3


def rests(loads: TriboLoads, dt: FloatArray) -> FloatArray:
    """Return how much of each time step the contact stood still before it slid on [s].

    Points stand at equal distances, so a rest shows as time that the distance to the last point at the speed of this
    one does not need. A point that did not move since one that stood still is the instant of the start: until then, it
    rested. Others that do not move are left as they are: their speed says it. A rest is an exception: where most points of
    a test take longer than their speed says, the speed is not theirs (a set value), and only what is still longer counts.
    Without distance and speed nothing shows a rest.
    """
    if {"v_rel", "sd"} & set(loads.absent):
        return np.zeros(len(dt))
    way = np.diff(loads.sd, prepend=loads.sd[:1])
    sliding = np.maximum(way, 0.0) / np.maximum(loads.v_rel, 1e-9)
    rest = (way > 0.0) & (loads.v_rel > 0.0) & (dt > REST_FACTOR * sliding) & (dt - sliding > LEAST_REST)
    if rest.any():
        rest &= dt > REST_FACTOR * _usual(loads, dt, sliding) * sliding
    starts = (way <= 0.0) & (loads.v_rel > 0.0) & (np.r_[1.0, loads.v_rel[:-1]] == 0.0)
    return np.where(rest, dt - sliding, np.where(starts, dt, 0.0))


def _usual(loads: TriboLoads, dt: FloatArray, sliding: FloatArray) -> FloatArray:
    """Return by what factor the quicker points of each test take longer than their speed says, at least 1."""
    factor = np.ones(len(dt))
    for part in loads.segments():
        moved = (sliding[part] > 0.0) & (dt[part] > 0.0)
        if int(moved.sum()) >= LEAST_STEPS:
            times = dt[part][moved] / sliding[part][moved]
            factor[part] = max(float(np.quantile(times, 0.25, method="lower")), 1.0)
    return factor
