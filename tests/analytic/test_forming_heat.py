"""Heat data over temperature, convection and radiation against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from forming.fe.body import Body
from forming.fe.heat.conduction import heat_step
from forming.fe.heat.properties import integral, mean_between, value_at
from forming.fe.heat_exchange import Environment, HeatExchange, exchange_heat, exposed
from forming.fe.mesh.mesher import grid_mesh
from forming.fe.mesh.shape import surface_weights
from forming.fe.state import Energy
from forming.fe.tooling import plate
from forming.materials.materials import steel_16MnCr5

#: J/(kg K) of carbon steel after EN 1993-1-2.
T_STEEL = np.arange(20.0, 700.0, 40.0)
CP_STEEL = tuple(zip(T_STEEL, 425 + 0.773 * T_STEEL - 1.69e-3 * T_STEEL**2 + 2.22e-6 * T_STEEL**3))


def cylinder(T, radius=5.0, height=10.0):
    mesh = grid_mesh(np.linspace(0.0, radius, 5), np.linspace(0.0, height, 7))
    chain = np.ascontiguousarray(mesh.loop[: 2 * 4 + 6 + 1])
    return Body.at_rest(mesh.x, mesh.quads, chain, T)


def cool(body, material, heat, times, dt):
    """Let a body hang in the air; return the mean temperatures at `times` and the energy account."""
    tool = plate(-100.0, widest=5.0)
    table = np.zeros((len(body.chain), 7))
    table[:, 3] = 100.0
    weights = np.zeros(len(body.chain))
    surface_weights(body.x, body.chain, weights)
    source, account, means = np.zeros((len(body.quads), 4)), Energy(), []
    for k in range(1, round(times[-1] / dt) + 1):
        body.T = exchange_heat(body, [tool], [table], weights, source, material, heat, dt, account)
        if any(k == round(t / dt) for t in times):
            means.append(float(body.T.mean()))
    return np.array(means), account


def test_a_small_body_cools_in_still_air_exponentially():
    """Lumped body: T - Tu decays with h A / (rho c V)."""
    steel = steel_16MnCr5()
    air = HeatExchange(environment=Environment(T=30.0, h=0.05, radiation=False))
    times = np.array([20.0, 60.0])
    body = cylinder(230.0)
    means, account = cool(body, steel, air, times, 0.2)
    surface, volume = 2 * np.pi * 5.0 * (5.0 + 10.0), np.pi * 25.0 * 10.0
    expected = 30.0 + 200.0 * np.exp(-0.05 * surface / (steel.heat_capacity * volume) * times)
    assert means == pytest.approx(expected, rel=3e-3)
    lost = steel.heat_capacity * volume * (230.0 - body.T.mean())
    assert account.heat_to_environment == pytest.approx(lost, rel=1e-3)
    assert account.heat_content - account.heat_start == pytest.approx(-account.heat_to_environment, rel=1e-9)


def test_a_radiating_body_follows_the_law_of_stefan_and_boltzmann():
    """Reference: the ordinary differential equation of a lumped body, solved by another integrator."""
    steel = replace(steel_16MnCr5(), emissivity=0.8, T_range=None)
    room = HeatExchange(environment=Environment(T=20.0, h=0.0))
    times = np.array([30.0, 120.0])
    means, _ = cool(cylinder(500.0), steel, room, times, 0.5)
    ratio = 2 * (5.0 + 10.0) / (5.0 * 10.0) / steel.heat_capacity

    def cooling(t, T):
        return -0.8 * 5.670374e-11 * ratio * ((T + 273.15) ** 4 - 293.15**4)

    reference = solve_ivp(cooling, (0.0, 120.0), [500.0], t_eval=times, rtol=1e-9).y[0]
    assert means == pytest.approx(reference, abs=1.0)


def test_radiation_and_convection_come_to_rest_at_the_environment():
    body = cylinder(300.0)
    heat = HeatExchange(environment=Environment(T=80.0, h=0.1))
    means, _ = cool(body, steel_16MnCr5(), heat, [4000.0], 10.0)
    assert means[-1] == pytest.approx(80.0, abs=0.01)


def test_insulated_surfaces_lose_nothing():
    body = cylinder(300.0)
    means, account = cool(body, steel_16MnCr5(), HeatExchange(environment=None), [10.0], 1.0)
    assert means[-1] == pytest.approx(300.0, abs=1e-9) and account.heat_to_environment == 0.0


def test_a_gap_shelters_a_surface():
    tool = plate(widest=5.0)
    table = np.zeros((4, 6))
    table[:, 0] = [500.0, 0.0, 0.0, 0.0]
    table[:, 3] = [-0.005, 0.5, 3.0, -40.0]  # in contact, in a gap, free, behind the tool
    assert exposed([table], [tool], 2.0).tolist() == [False, False, True, True]


def test_heat_over_temperature_conserves_enthalpy():
    """Heat released once, c over T: the body ends where the enthalpy has risen by the heat, at any step."""
    mesh = grid_mesh(np.linspace(0.0, 5.0, 6), np.linspace(0.0, 4.0, 5))
    capacity = tuple((T, c * 7.85e-3) for T, c in CP_STEEL)
    source = np.full((len(mesh.quads), 4), 1200.0)
    T = np.full(len(mesh.x), 20.0)
    T = heat_step(mesh.x, mesh.quads, T, source, capacity, 42.0, 0.5)
    rise = integral(capacity, T) - integral(capacity, 20.0)
    assert rise == pytest.approx(1200.0, rel=1e-4)
    # The numbers of 20 degC would give another 50 K.
    assert 1200.0 / float(value_at(capacity, 20.0)) > T.max() - 20.0 + 45.0


def test_steady_conduction_with_k_over_T_meets_the_kirchhoff_transform():
    """Rod between 20 and 420 degC, k = 20 to 40: the integral of k is linear along it."""
    conductivity = ((20.0, 20.0), (420.0, 40.0))
    z = np.linspace(0.0, 10.0, 21)
    mesh = grid_mesh(np.linspace(0.0, 1.0, 3), z)
    ends = np.flatnonzero((mesh.x[:, 1] == 0.0) | (mesh.x[:, 1] == 10.0))
    held = np.where(mesh.x[ends, 1] == 0.0, 20.0, 420.0)
    T = np.full(len(mesh.x), 220.0)
    zero = np.zeros((len(mesh.quads), 4))
    for _ in range(200):
        T = heat_step(
            mesh.x, mesh.quads, T, zero, 3.69, conductivity, 1.0, (ends, np.full(len(ends), 1e7), held)
        )
    potential = integral(conductivity, T) - integral(conductivity, 20.0)
    total = integral(conductivity, 420.0) - integral(conductivity, 20.0)
    assert potential == pytest.approx(total * mesh.x[:, 1] / 10.0, abs=2e-3 * total)
    # Constant k would give 220 in the middle.
    assert T[np.abs(mesh.x[:, 1] - 5.0) < 1e-9] == pytest.approx(252.5, abs=2.0)


def test_a_table_of_one_value_is_the_constant():
    mesh = grid_mesh(np.linspace(0.0, 5.0, 6), np.linspace(0.0, 4.0, 5))
    T = 20.0 + mesh.x[:, 0] ** 2
    source = np.full((len(mesh.quads), 4), 10.0)
    flat = ((0.0, 3.69), (500.0, 3.69)), ((0.0, 42.0), (500.0, 42.0))
    constant = heat_step(mesh.x, mesh.quads, T, source, 3.69, 42.0, 0.1)
    assert heat_step(mesh.x, mesh.quads, T, source, *flat, 0.1) == pytest.approx(constant, rel=1e-12)


def test_mean_and_integral_of_a_property():
    k = ((0.0, 10.0), (100.0, 20.0))
    assert integral(k, np.array([-10.0, 0.0, 50.0, 100.0, 200.0])) == pytest.approx(
        [-100, 0, 625, 1500, 3500]
    )
    T0, T1 = np.array([0.0, 50.0]), np.array([100.0, 50.0])
    assert mean_between(k, T0, T1) == pytest.approx([15.0, 15.0])
    shifted = ((20.0, 10.0), (120.0, 20.0))
    assert integral(shifted, 120.0) - integral(shifted, 20.0) == pytest.approx(1500.0)
