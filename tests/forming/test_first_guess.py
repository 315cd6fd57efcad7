"""What an increment starts from: the motion expected of the nodes, and the plastic strain at one point."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from forming.fe.body import Body
from forming.fe.element import radial_return
from forming.materials.materials import as_material


def test_a_body_that_accelerates_evenly_is_expected_where_it_comes_to():
    way = np.array([[2.0, -3.0]])
    body = Body.at_rest(np.zeros((1, 2)), np.zeros((0, 4), dtype=np.int64), np.zeros(1, dtype=np.int64), 20.0)
    ends = np.array([0.0, 0.1, 0.3, 0.35])

    def displacement(k: int) -> np.ndarray:
        # x = t + way t^2 / 2
        return (ends[k + 1] - ends[k]) + 0.5 * way * (ends[k + 1] ** 2 - ends[k] ** 2)

    for k in range(2):
        dt = ends[k + 1] - ends[k]
        body.accelerate(displacement(k) / dt, dt)
    assert body.expected(0.05, 1.0) == pytest.approx(displacement(2), rel=1e-12)
    # Without its acceleration it goes on as in the last increment.
    assert body.expected(0.05, 0.0) == pytest.approx(0.25 * displacement(1), rel=1e-12)


def test_the_first_velocity_is_no_acceleration():
    body = Body.at_rest(np.zeros((1, 2)), np.zeros((0, 4), dtype=np.int64), np.zeros(1, dtype=np.int64), 20.0)
    body.accelerate(np.array([[1.0, 2.0]]), 0.1)
    assert body.expected(0.1, 1.0) == pytest.approx(np.array([[0.1, 0.2]]))
    body.accelerate(np.array([[2.0, 2.0]]), 0.1)
    body.guess(np.array([[1.0, 2.0]]))
    assert body.expected(0.1, 1.0) == pytest.approx(np.array([[0.1, 0.2]]))


@pytest.mark.parametrize("guess", [0.0, 0.7, 0.9, 0.99, 1.005, 1.3])
@pytest.mark.parametrize("flow", [1e-4, 0.01, 0.2])
def test_the_flow_stress_after_an_increment_is_that_of_its_plastic_strain(flow, guess):
    m = as_material(None).vector()
    strain, T, dt, g3 = 0.3, 80.0, 0.02, 3.0 * m[6]

    def stress(dp: float) -> float:
        # Hensel and Spittel, with the floors of strain and rate.
        e, r = np.hypot(strain + dp, m[8]), np.hypot(dp / dt, m[9])
        return float(m[0] * np.exp(m[1] * T + m[4] / e) * e ** m[2] * r ** (m[3] + m[5] * T))

    q = stress(flow) + g3 * flow
    known = brentq(lambda dp: q - g3 * dp - stress(dp), 0.0, q / g3, xtol=1e-15)
    dp, y, _ = radial_return(q, strain, T, dt, m, guess * known)
    assert y == pytest.approx(stress(known), rel=2e-6)
    assert q - g3 * dp == pytest.approx(y, rel=1e-5)
