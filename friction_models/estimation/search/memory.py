"""States of effects that remember, advanced through every test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...common import InputError
from ...effects.base import Effect, EffectContext
from ...effects.time_course import Rows, TimeCourse
from ...expressions.ops import LoadColumns, NumpyOps
from ...loads import FloatArray
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
    states = states_along(effect, campaign.course, mu, campaign.system, shape)
    if not effect.states_need_shapes:
        campaign.integrated[effect.name] = (mu.copy(), states)
    return states


def states_along(
    effect: Effect,
    course: TimeCourse,
    mu: FloatArray | None,
    system: Mapping[str, FloatArray],
    shape: Mapping[str, FloatArray | float],
) -> dict[str, FloatArray]:
    """Return the states of an effect at all points of some tests, shape (n, g) each, for g sets of shape parameters side by side.

    Raises InputError: a method of the effect fails, or a state is not finite.
    """
    sets, names = max((np.size(v) for v in shape.values()), default=1), [name for name, _ in effect.states]
    begin = called(effect, "start_state", len(names), shape)
    start = [shaped(effect, "start_state", s, (len(course.starts), sets)) for s in begin]

    def told(rows: Rows, state: Mapping[str, FloatArray]) -> EffectContext:
        inside = {name: values[rows] for name, values in system.items()}
        return EffectContext(None if mu is None else mu[rows, None], state, inside)

    def linear_step(L: LoadColumns, seconds: FloatArray) -> list[FloatArray]:
        given = OPS, L, shape, told(slice(None), {}), seconds[:, None]
        size = len(seconds), sets
        return [
            shaped(effect, "linear_step", part, size)
            for part in called(effect, "linear_step", 2 * len(names), *given)
        ]

    def advance(
        rows: Rows, L: LoadColumns, held: Sequence[FloatArray], seconds: FloatArray
    ) -> list[FloatArray]:
        state = dict(zip(names, held, strict=True))
        given = OPS, L, shape, told(rows, state), seconds[:, None]
        size = len(seconds), sets
        return [shaped(effect, "advance", new, size) for new in called(effect, "advance", len(names), *given)]

    history = (
        course.at_once(start, linear_step) if effect.steps_linearly else course.step_by_step(start, advance)
    )
    for name, values in zip(names, history, strict=True):
        finite(effect, f"state {name!r}", [values], shape)
    return dict(zip(names, history, strict=True))


def check_step(
    effect: Effect, campaign: BinnedTests, mu: FloatArray, shape: Mapping[str, FloatArray | float]
) -> None:
    """Raise InputError if a short step of an effect is not what its rate says: fits take the steps, simulators the rate.

    Some points are tried, with the first set of shape parameters.
    """
    kind = type(effect)
    stepped = effect.steps_linearly or kind.advance is not Effect.advance
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
