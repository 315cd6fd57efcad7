"""The heat balance against closed solutions."""

from __future__ import annotations

import numpy as np

from benchmarks.literature.heat import EFFUSIVITY_PLATE, EFFUSIVITY_SPECIMEN, LENGTH, HeatedContact


def test_rise_lies_near_the_two_half_space_solution() -> None:
    v, sigma, mu, n = 200.0, 1000.0, 0.08, 400
    dt = 0.2 / n
    contact = HeatedContact(1, share=1.0)
    one = np.ones(1)
    for _ in range(n):
        rise = contact.step(mu * one, sigma * one, v * one, dt * one)
    q = mu * sigma * v * 1e3
    specimen = q * np.sqrt(4 * 0.2 / np.pi) / EFFUSIVITY_SPECIMEN
    plate = 2 / 3 * q * np.sqrt(4 * (LENGTH / 0.2) / np.pi) / EFFUSIVITY_PLATE
    assert abs(rise[0] / (1.0 / (1.0 / specimen + 1.0 / plate)) - 1.0) < 0.2


def test_kernel_of_the_half_space() -> None:
    # Nearly no heat into the plate at extreme transit times is not reachable; check the kernel itself.
    from benchmarks.literature.heat import _RATES, _WEIGHTS

    for t in (1e-3, 1e-2, 0.1, 1.0, 5.0):
        assert abs(np.sum(_WEIGHTS * np.exp(-_RATES * t)) * np.sqrt(np.pi * t) - 1.0) < 0.15


def test_no_friction_no_heat_and_more_friction_more_heat() -> None:
    one = np.ones(1)
    rises = []
    for mu in (0.0, 0.05, 0.1):
        contact = HeatedContact(1)
        for _ in range(50):
            rise = contact.step(mu * one, 1000 * one, 100 * one, 1e-3 * one)
        rises.append(float(rise[0]))
    assert rises[0] == 0.0 and 0.0 < rises[1] < rises[2]
