"""The parameters that make measurements most likely, by Newton steps within a region that is trusted (Nocedal, Wright, ch. 4)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from ...loads import FloatArray

#: Value of parameters for which rounding leaves no solution.
UNSOLVED = 1e12


class Likelihood(NamedTuple):
    """What parameters, shape (k,), are worth: the smaller, the likelier."""

    value: float
    slope: FloatArray  #: Shape (k,).
    curvature: Callable[[], FloatArray]  #: Shape (k, k); asked for where a step is taken alone.


def most_likely(
    at: Callable[[FloatArray], Likelihood], start: FloatArray, steps: tuple[float, float], least_slope: float
) -> FloatArray:
    """Return the parameters of least value, shape (k,), from `start`.

    `steps` are the first and the largest step; the search ends where no slope is above `least_slope`.

    Examples
    --------
    >>> def bowl(x):
    ...     return Likelihood(float(x @ x), 2.0 * x, lambda: 2.0 * np.eye(2))
    >>> bool(np.max(np.abs(most_likely(bowl, np.array([3.0, -4.0]), (1.0, 10.0), 1e-3))) < 1e-3)
    True
    """
    last: list[tuple[FloatArray, Likelihood]] = []

    def solved(theta: FloatArray) -> Likelihood:
        # value, slope and curvature of one place are asked for one after the other
        if not (last and np.array_equal(last[0][0], theta)):
            last[:] = [(theta.copy(), at(theta))]
        return last[0][1]

    def value_and_slope(theta: FloatArray) -> tuple[float, FloatArray]:
        return solved(theta).value, solved(theta).slope

    def curvature(theta: FloatArray) -> FloatArray:
        return solved(theta).curvature()

    best = minimize(
        value_and_slope,
        start,
        jac=True,
        hess=curvature,
        method="trust-exact",
        options={"initial_trust_radius": steps[0], "max_trust_radius": steps[1], "gtol": least_slope},
    )
    return np.asarray(best.x)
