"""States of effects that remember, advanced through every test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from ...effects.base import Effect, EffectContext
from ...expressions.ops import LoadColumns, NumpyOps
from ...loads import FloatArray
from ...loads.time_steps import rests, time_steps
from ..campaign.binning import BinnedTests
from .checked_call import called, shaped

OPS = NumpyOps()


def integrate(
    effect: Effect, campaign: BinnedTests, mu: FloatArray, shape: Mapping[str, FloatArray | float]
) -> dict[str, FloatArray]:
    """Advance the states of an effect through every test, all tests and parameter sets side by side.

    Returns the states at every point, shape (n, g) each.
    """
    if not effect.states_need_shapes:
        shape = {name: effect.start_shape()[name] for name in shape}
        known = campaign.integrated.get(effect.name)
        if known is not None and np.array_equal(known[0], mu):
            return known[1]
    sets = max((np.size(v) for v in shape.values()), default=1)
    begin = called(effect, "start_state", len(effect.states), shape)
    start = [shaped(effect, "start_state", s, (len(campaign.tests), sets)) for s in begin]
    dt = time_steps(campaign.loads, campaign.point_starts)
    pause = rests(campaign.loads, dt)
    history = _at_once(effect, campaign, mu, shape, start, dt, pause)
    if history is None:
        history = _step_by_step(effect, campaign, mu, shape, start, dt, pause)
    states = {name: h for (name, _), h in zip(effect.states, history, strict=True)}
    if not effect.states_need_shapes:
        campaign.integrated[effect.name] = (mu.copy(), states)
    return states


def _at_once(
    effect: Effect,
    campaign: BinnedTests,
    mu: FloatArray,
    shape: Mapping[str, FloatArray | float],
    start: Sequence[FloatArray],
    dt: FloatArray,
    pause: FloatArray,
) -> list[FloatArray] | None:
    """Return the states at every point where the steps of an effect are linear in them, else None.

    What a step keeps and adds is known for all points before the first one is made.
    """
    if type(effect).linear_step is Effect.linear_step:
        return None
    columns = LoadColumns(*(c[:, None] for c in campaign.loads.as_array().T))
    memory = EffectContext(mu=mu[:, None], system=campaign.system)

    def step(L: LoadColumns, seconds: FloatArray) -> tuple[FloatArray, ...]:
        return called(effect, "linear_step", 2 * len(start), OPS, L, shape, memory, seconds[:, None])

    sliding = step(columns, dt - pause)
    # the contact stood still first, then slid up to the point
    still = LoadColumns(0.0 * columns.v_rel, columns.T, columns.sigma_n, columns.sd, columns.psi)
    resting = step(still, pause) if pause.any() else None
    # point by point of all tests, the longest tests first: those that still run are the first of the step before
    number = np.arange(len(mu)) - campaign.point_starts[campaign.point_test]
    by_length = np.argsort(-np.bincount(campaign.point_test), kind="stable")
    order = np.lexsort((np.argsort(by_length)[campaign.point_test], number))
    ends = np.cumsum(np.bincount(number))
    history = []
    for k, begin in enumerate(start):
        keep, gain = sliding[2 * k : 2 * k + 2]
        if resting is not None:
            kept_at_rest, gained_at_rest = resting[2 * k : 2 * k + 2]
            keep, gain = keep * kept_at_rest, keep * gained_at_rest + gain
        size = len(mu), begin.shape[1]
        kept, gained = (shaped(effect, "linear_step", part, size)[order] for part in (keep, gain))
        states, now = np.empty(size), begin[by_length]
        for first, end in pairwise([0, *ends]):
            now = np.add(kept[first:end] * now[: end - first], gained[first:end], out=states[first:end])
        at_points = np.empty(size)
        at_points[order] = states
        history.append(at_points)
    return history


def _step_by_step(
    effect: Effect,
    campaign: BinnedTests,
    mu: FloatArray,
    shape: Mapping[str, FloatArray | float],
    start: Sequence[FloatArray],
    dt: FloatArray,
    pause: FloatArray,
) -> list[FloatArray]:
    """Return the states at every point, all tests one step further at a time."""
    n = len(campaign.loads)
    lengths = np.diff(np.r_[campaign.point_starts, n])
    matrix, current = campaign.loads.as_array(), [s.copy() for s in start]
    history = [np.empty((n, s.shape[1])) for s in start]
    for step in range(int(lengths.max())):
        running = lengths > step
        rows = campaign.point_starts[running] + step
        L = LoadColumns(*(matrix[rows, j : j + 1] for j in range(matrix.shape[1])))
        old = {name: c[running] for (name, _), c in zip(effect.states, current, strict=True)}
        memory = EffectContext(
            mu=mu[rows, None], state=old, system={k: v[rows] for k, v in campaign.system.items()}
        )
        if pause[rows].any():  # the contact stood still first, then slid up to here
            still = LoadColumns(0.0 * L.v_rel, L.T, L.sigma_n, L.sd, L.psi)
            held = called(effect, "advance", len(current), OPS, still, shape, memory, pause[rows, None])
            old = {name: v for (name, _), v in zip(effect.states, held, strict=True)}
            memory = EffectContext(mu=memory.mu, state=old, system=memory.system)
        new = called(effect, "advance", len(current), OPS, L, shape, memory, (dt - pause)[rows, None])
        for k, value in enumerate(new):
            value = shaped(effect, "advance", value, (len(rows), current[k].shape[1]))
            current[k][running] = value
            history[k][rows] = value
    return history
