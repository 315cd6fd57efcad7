"""States of effects that remember, advanced through every test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ...common import InputError
from ...effects.base import Effect, EffectContext
from ...expressions.ops import LoadColumns, NumpyOps
from ...loads import FloatArray
from ...loads.time_steps import rests, time_steps
from ..campaign.binned_tests import BinnedTests
from .checked_call import called, finite, shaped

OPS = NumpyOps()
#: Points at which steps are compared with rates; a short step changes a state by such a share of it, and takes so many seconds at most.
TRIED, SHORT, SHORTEST = 5, 1e-5, 1e-6
#: Share of the rate within which it agrees with the step, and share of the state a second that rounding makes of a short step.
AGREES, ROUNDED = 0.01, 1e-6


def integrate(
    effect: Effect, campaign: BinnedTests, mu: FloatArray, shape: Mapping[str, FloatArray | float]
) -> dict[str, FloatArray]:
    """Advance the states of an effect through every test, all tests and parameter sets side by side.

    Returns the states at every point, shape (n, g) each. Raises InputError: a method of the effect fails, or a state is not finite.
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
    march = _March(effect, campaign, mu, shape, start, dt, rests(campaign.loads, dt))
    linear = type(effect).linear_step is not Effect.linear_step
    history = march.at_once() if linear else march.step_by_step()
    states = {name: h for (name, _), h in zip(effect.states, history, strict=True)}
    for name, values in states.items():
        finite(effect, f"state {name!r}", [values], shape)
    if not effect.states_need_shapes:
        campaign.integrated[effect.name] = (mu.copy(), states)
    return states


def check_step(
    effect: Effect, campaign: BinnedTests, mu: FloatArray, shape: Mapping[str, FloatArray | float]
) -> None:
    """Raise InputError if a short step of an effect is not what its rate says: fits take the steps, simulators the rate.

    Some points are tried, with the first set of shape parameters.
    """
    kind = type(effect)
    stepped = kind.linear_step is not Effect.linear_step or kind.advance is not Effect.advance
    if kind.rate is Effect.rate or not stepped:
        return
    moving = np.flatnonzero(campaign.loads.v_rel > 0.0)
    rows = moving[np.linspace(0, len(moving) - 1, min(len(moving), TRIED)).astype(int)]
    one = {name: float(np.ravel(value)[0]) for name, value in shape.items()}
    names = [name for name, _ in effect.states]
    begin = called(effect, "start_state", len(names), one)
    values = [np.full((len(rows), 1), np.ravel(b)[0] + 0.1 * max(abs(np.ravel(b)[0]), 1.0)) for b in begin]
    system = {name: column[rows] for name, column in campaign.system.items()}
    context = EffectContext(mu=mu[rows, None], state=dict(zip(names, values, strict=True)), system=system)
    L = LoadColumns.from_matrix(OPS, campaign.loads.as_array()[rows])
    rates = called(effect, "rate", len(names), OPS, L, one, context)
    fastest = np.max([np.abs(r) / np.abs(v) for r, v in zip(rates, values, strict=True)], axis=0)
    dt = np.minimum(SHORT / np.maximum(fastest, 1e-300), SHORTEST)
    after = called(effect, "advance", len(names), OPS, L, one, context, dt)
    for name, value, new, rate in zip(names, values, after, rates, strict=True):
        change = (new - value) / dt
        off = np.abs(change - rate) > AGREES * np.abs(rate) + ROUNDED * np.abs(value)
        if off.any():
            k = int(np.argmax(off))
            stated, stepped_by = (float(np.broadcast_to(x, off.shape)[k, 0]) for x in (rate, change))
            raise InputError(
                f"effect {effect.name!r}: a short step changes state {name!r} by {stepped_by:.3g} a second, its rate by {stated:.3g}; "
                "allowed: the same law in both"
            )


@dataclass(frozen=True)
class _March:
    """The states of one effect on their way through all tests; both ways give the same states at every point, shape (n, g) each."""

    effect: Effect
    campaign: BinnedTests
    mu: FloatArray
    shape: Mapping[str, FloatArray | float]
    start: Sequence[FloatArray]  #: Of each state, shape (tests, g).
    dt: FloatArray  #: Since the point before, shape (n,).
    pause: FloatArray  #: Part of it in which the contact stood still first, then slid up to the point.

    def at_once(self) -> list[FloatArray]:
        """Advance states whose steps are linear in them: what a step keeps and adds is known for all points before the first one is made."""
        point_test, starts = self.campaign.point_test, self.campaign.point_starts
        loads = LoadColumns.from_matrix(OPS, self.campaign.loads.as_array())
        memory = EffectContext(mu=self.mu[:, None], system=self.campaign.system)

        def step(L: LoadColumns, seconds: FloatArray) -> tuple[FloatArray, ...]:
            count = 2 * len(self.start)
            return called(self.effect, "linear_step", count, OPS, L, self.shape, memory, seconds[:, None])

        sliding = step(loads, self.dt - self.pause)
        resting = step(loads.at_rest(), self.pause) if self.pause.any() else None
        # point by point of all tests, the longest tests first: those that still run are the first of the step before
        number = np.arange(len(self.mu)) - starts[point_test]
        by_length = np.argsort(-np.bincount(point_test), kind="stable")
        order = np.lexsort((np.argsort(by_length)[point_test], number))
        ends = np.cumsum(np.bincount(number))
        history = []
        for k, begin in enumerate(self.start):
            keep, gain = sliding[2 * k : 2 * k + 2]
            if resting is not None:
                kept_at_rest, gained_at_rest = resting[2 * k : 2 * k + 2]
                keep, gain = keep * kept_at_rest, keep * gained_at_rest + gain
            size = len(self.mu), begin.shape[1]
            kept, gained = (shaped(self.effect, "linear_step", part, size)[order] for part in (keep, gain))
            states, now = np.empty(size), begin[by_length]
            for first, end in pairwise([0, *ends]):
                now = np.add(kept[first:end] * now[: end - first], gained[first:end], out=states[first:end])
            at_points = np.empty(size)
            at_points[order] = states
            history.append(at_points)
        return history

    def step_by_step(self) -> list[FloatArray]:
        """Advance any states, all tests one step further at a time."""
        campaign, pause = self.campaign, self.pause
        n = len(campaign.loads)
        lengths = np.diff(np.r_[campaign.point_starts, n])
        matrix, current = campaign.loads.as_array(), [s.copy() for s in self.start]
        history = [np.empty((n, s.shape[1])) for s in self.start]
        for step in range(int(lengths.max())):
            running = lengths > step
            rows = campaign.point_starts[running] + step
            L = LoadColumns.from_matrix(OPS, matrix[rows])
            held: Sequence[FloatArray] = [c[running] for c in current]
            if pause[rows].any():
                held = self._advanced(held, rows, L.at_rest(), pause)
            for k, value in enumerate(self._advanced(held, rows, L, self.dt - pause)):
                value = shaped(self.effect, "advance", value, (len(rows), current[k].shape[1]))
                current[k][running] = value
                history[k][rows] = value
        return history

    def _advanced(
        self, held: Sequence[FloatArray], rows: npt.NDArray[np.intp], L: LoadColumns, seconds: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return the states held at some points after these seconds, shape (rows, g) each."""
        state = {name: value for (name, _), value in zip(self.effect.states, held, strict=True)}
        system = {name: values[rows] for name, values in self.campaign.system.items()}
        memory = EffectContext(mu=self.mu[rows, None], state=state, system=system)
        return called(self.effect, "advance", len(held), OPS, L, self.shape, memory, seconds[rows, None])
