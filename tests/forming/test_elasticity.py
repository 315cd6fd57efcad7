"""Elastic tools: Lame's cylinder, the spring of punch and press, rollback, bad input."""

from __future__ import annotations

import numpy as np
import pytest

from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.fe.surface_loads import bore_pressure
from forming.tools.elasticity import ElasticTools, bore_flexibility
from friction_models.common import InputError

COARSE = {"mesh_size": 0.6, "n_points": 40, "tool_heating": False}


def test_bore_of_a_thick_walled_cylinder():
    """The stresses from the boundary conditions, sigma = A -+ B / r^2, give the hoop strain of the bore."""
    a, b, E, nu, p = 10.0, 30.0, 210e3, 0.3, 1000.0
    A, B = np.linalg.solve([[1.0, -1.0 / a**2], [1.0, -1.0 / b**2]], [-p, 0.0])
    radial, hoop = A - B / a**2, A + B / a**2
    assert radial == pytest.approx(-p)
    assert p * bore_flexibility(a, b, E) == pytest.approx(a * (hoop - nu * radial) / E)
    # A hole in an infinite body: u = p a (1 + nu) / E.
    assert bore_flexibility(a, 1e6, E) == pytest.approx(a * 1.3 / E)


@pytest.mark.parametrize("kind", [ForwardRodExtrusion, BackwardCupExtrusion])
def test_the_die_widens_by_its_pressure(kind):
    process = kind(**COARSE, die_outer_diameter=60.0)
    result = process.run(0.08, 4.0)
    die = process.simulation.state.tools[0]
    expected = bore_flexibility(10.0, 30.0, 210e3) * die.pressure
    assert result.status == "ok", result.message
    assert 100.0 < die.pressure < 2000.0
    assert result.expansion[-1] == pytest.approx(expected, rel=0.1)
    assert (np.abs(np.diff(result.expansion)) < 0.02).all()
    assert result.compression.max() == 0.0 and abs(result.energy_balance) < 0.01


def test_a_short_contact_is_carried_by_the_wall_around_it():
    table = np.zeros((3, 6))
    table[:, 0], table[:, 4] = [800.0, 400.0, -1.0], -1.0
    weights = np.array([10.0, 10.0, 50.0])
    assert bore_pressure(table, weights) == pytest.approx(600.0)
    assert bore_pressure(table, weights, 10.0) == pytest.approx(600.0)
    assert bore_pressure(table, weights, 200.0) == pytest.approx(60.0)
    assert ElasticTools("a", 20.0, 20.0, 60.0).spread == pytest.approx(10.0 * 20.0)


def test_press_and_punch_shift_the_curve_by_their_spring():
    rigid = ForwardRodExtrusion(**COARSE).run(0.08, 4.5)
    result = ForwardRodExtrusion(**COARSE, press_stiffness=400.0, punch_length=100.0).run(0.08, 5.0)
    spring = 1.0 / (1.0 / 400.0 + 100.0 / (210.0 * np.pi * 10.0**2))
    assert result.status == "ok" and result.failed_increments < 10, result.message
    assert result.compression[-1] == pytest.approx(result.force[-1] / spring, rel=0.02)
    shifted = np.interp(result.stroke - result.force / spring, rigid.stroke, rigid.force)
    assert np.abs(result.force - shifted).mean() < 0.015 * rigid.max_force
    assert np.abs(result.stroke - result.compression).max() < 4.5
    # The ram's work is the punch's and what the spring keeps.
    assert result.work[-1] == pytest.approx(np.trapezoid(result.force, result.stroke), rel=0.01)
    energy = ForwardRodExtrusion(**COARSE)
    assert energy.elasticity.compliance == energy.elasticity.flexibility == 0.0


def test_restored_snapshot_of_elastic_tools_continues_bit_by_bit():
    process = BackwardCupExtrusion(**COARSE, die_outer_diameter=50.0, press_stiffness=500.0, nose_angle=8.0)
    process.start(0.08)
    for _ in range(8):
        process.advance(0.1)
    kept = process.snapshot()

    def go_on():
        for _ in range(5):
            process.advance(0.1)
        return process.loads(), process.force, process.compression, process.expansion

    first = go_on()
    process.restore(kept)
    second = go_on()
    assert np.array_equal(first[0], second[0]) and first[1:] == second[1:]
    assert first[2] > 0.0 and first[3] > 0.0


@pytest.mark.parametrize(
    "wrong",
    [
        {"die_outer_diameter": 21.0},
        {"press_stiffness": -5.0},
        {"punch_length": 0.0},
        {"press_stiffness": 300.0, "tool_modulus": float("nan")},
    ],
)
def test_impossible_tools_are_refused(wrong):
    name, value = list(wrong.items())[-1]
    for kind in (ForwardRodExtrusion, BackwardCupExtrusion):
        with pytest.raises(InputError, match=f"{name} = {value!r} .*; allowed:"):
            kind(**wrong)
