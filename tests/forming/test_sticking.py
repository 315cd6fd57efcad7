"""Friction that sticks: a run goes on where the friction stress has reached shear yield."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from forming import BackwardCupExtrusion, ForwardRodExtrusion, PowerLaw
from forming.fe.contact import FACING, SHEAR, add_contact
from forming.fe.increment import Attempt, StepError, solve_increment


def shear_at(gap, held):
    """Friction stress of a node that slides fast along a plate, mu = 10, k = 300 MPa, 1e5 MPa/mm."""
    plate = np.array([[0.0, -1.0, 0.0, 90.0, 0.0, 0.0, 0.0, 0.0]])
    x = np.array([[1.0, gap], [2.0, 5.0]])
    du = np.array([[1.0, 0.0], [1.0, 0.0]])
    table, mu, still = np.zeros((2, FACING + 1)), np.full(2, 10.0), np.zeros(2)
    on, released = np.array([1, 0]), np.zeros(2, dtype=np.int64)
    add_contact(
        x, du, np.array([0, 1]), np.ones(2), plate, still, still, 1.0, mu, np.full(2, 300.0), 1e5, 1e-6, 1.0,
        0.0, np.zeros((2, 4)), np.zeros(4), np.zeros(2), table, on, released, False, np.full(2, held),
    )  # fmt: skip
    return abs(table[0, SHEAR])


def test_a_held_limit_does_not_follow_the_pressure():
    """mu p = 1e6 gap below k: 100 MPa at 0.1 um; capped at 300; held, it is what it was."""
    assert shear_at(-1e-4, -1.0) == pytest.approx(100.0)
    assert shear_at(-2e-3, -1.0) == pytest.approx(300.0)
    assert shear_at(-1e-4, 250.0) == shear_at(-2e-3, 250.0) == pytest.approx(250.0)
    assert Attempt.number(0).hold_limits > 30 > Attempt.number(1).hold_limits


class Repeats:
    """Solves increments; each that is repeated with held friction limits also without, and counts what only one of both solves."""

    def __init__(self):
        self.only_held = self.only_free = 0

    def __call__(self, body, tools, material, dt, mu, settings, attempt, *more):
        def solved(choice):
            try:
                return solve_increment(body, tools, material, dt, mu, settings, choice, *more)
            except StepError:
                return None

        if attempt.hold_limits < Attempt.hold_limits:
            held, free = solved(attempt), solved(replace(attempt, hold_limits=Attempt.hold_limits))
            self.only_held += held is not None and free is None
            self.only_free += held is None and free is not None
        return solve_increment(body, tools, material, dt, mu, settings, attempt, *more)


@pytest.mark.nightly
def test_a_cup_goes_on_where_it_sticks_to_its_tools(monkeypatch):
    """mu = 10: the limit k acts nearly everywhere, the wall of the cup sticks to the container; some increments need held limits."""
    repeats = Repeats()
    monkeypatch.setattr("forming.fe.simulation.solve_increment", repeats)
    # A handful of increments in each run: one run alone tells little.
    for mesh_size in (0.8, 0.9):
        process = BackwardCupExtrusion(mesh_size=mesh_size, n_points=40)
        result = process.run(10.0, 8.0)
        assert result.status == "ok", result.message
        assert 0.99 < result.max_tau_over_k < 1.03
        assert abs(result.energy_balance) < 3.5e-3 and abs(result.volume_change) < 1e-3
    assert repeats.only_held > repeats.only_free
    # Rubbing at shear yield along the container takes much more than Coulomb friction.
    assert result.force[-1] > 1.3 * process.run(0.1, 8.0).force[-1]


@pytest.mark.parametrize("stress", [pytest.param(100.0, marks=pytest.mark.nightly), 400.0])
def test_a_rod_that_does_not_harden_goes_on_where_it_begins_to_stick(stress):
    """At mu p = k the container slips at the stress at which the surface shears: the residual falls slowly."""
    process = ForwardRodExtrusion(mesh_size=0.6, n_points=40, material=PowerLaw(yield_stress=stress))
    result = process.run(0.3, 2.0)
    assert result.status == "ok", result.message
    assert abs(result.energy_balance) < 3.5e-3 and abs(result.volume_change) < 1e-3
    assert 0.97 < result.max_tau_over_k < 1.03
