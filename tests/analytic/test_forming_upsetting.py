"""Upsetting and heat against closed forms and an independent finite element code."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erfc

from forming.fe.body import Body
from forming.fe.contact import surface_weights
from forming.fe.heat_exchange import HeatExchange, exchange_heat
from forming.fe.increment import Settings
from forming.fe.mesher import grid_mesh
from forming.fe.simulation import Simulation
from forming.fe.state import StepControl
from forming.fe.thermal import heat_step
from forming.material import steel_16MnCr5
from forming.tooling import block_field, flat_punch, plate
from forming.upsetting import PunchGeometry, upset


def compress(material, mu, radius=7.5, height=15.0, bore=0.0, share=0.5, n_r=12, n_z=12, step=0.15):
    """Upset a cylinder or a ring between flat tools, isothermal; return the simulation."""
    mesh = grid_mesh(np.linspace(bore, radius, n_r + 1), np.linspace(0.0, height, n_z + 1))
    loop = mesh.loop
    chain = np.append(loop, loop[0]) if bore else loop[: 2 * n_r + n_z + 1]
    body = Body.at_rest(mesh.x, mesh.quads, np.ascontiguousarray(chain), 20.0)
    body.velocity = np.column_stack([0.5 * (body.x[:, 0] - bore), -body.x[:, 1]]) * 5.0 / height
    simulation = Simulation(
        body,
        [plate(), flat_punch(height, 5.0)],
        material,
        np.linspace(0.0, 10.0, 5),
        mu,
        settings=Settings(penalty=2e5),
        control=StepControl(largest=step, slip=5.0),
        isothermal=True,
    )
    assert simulation.advance_to(share * height), simulation.state.message
    return simulation


def rate_independent():
    """16MnCr5 frozen at 0.5/s: the independent code was run with one flow curve."""
    steel = steel_16MnCr5()
    return replace(steel, A=steel.A * 0.5**steel.m3, m3=0.0)


def test_frictionless_upsetting_is_homogeneous_and_meets_the_closed_form():
    steel = steel_16MnCr5()
    simulation = compress(steel, 0.0, step=0.1)
    # kf(ln 2, 5 mm/s over 7.5 mm) times the doubled area: 224.6 kN.
    expected = float(steel.flow_stress(np.log(2.0), 20.0, 5.0 / 7.5)) * np.pi * 7.5**2 * 2.0
    assert expected == pytest.approx(224.56e3, rel=5e-4)
    assert simulation.force == pytest.approx(expected, rel=5e-3)
    strain = simulation.state.body.strain
    assert strain == pytest.approx(np.log(2.0), rel=0.01)
    assert np.ptp(strain) < 2e-3
    assert abs(simulation.state.history[-1].volume_change) < 1e-4
    assert abs(simulation.state.energy.imbalance) < 5e-3


def test_upsetting_with_friction_meets_calculix():
    """CalculiX 2.20, CAX8R elements, 15 x 15 mm, 50 %, mu 0.1: 234.4 kN."""
    assert compress(rate_independent(), 0.1, n_r=16, n_z=16).force == pytest.approx(234.4e3, rel=0.01)


def test_ring_compression_meets_calculix():
    """CalculiX CAX8R, ring 6:3:2 (r 6 and 3 mm, height 4 mm), 50 %, mu 0.1: 129.85 kN, bore radius 2.774 mm."""
    ring = compress(rate_independent(), 0.1, radius=6.0, height=4.0, bore=3.0, n_r=16, n_z=16, step=0.05)
    assert ring.force == pytest.approx(129.85e3, rel=0.01)
    x = ring.state.body.x
    middle = x[np.abs(x[:, 1] - x[:, 1].max() / 2) < 0.05]
    assert middle[:, 0].min() == pytest.approx(2.774, rel=0.01)


@pytest.mark.parametrize(("mu", "change"), [(0.02, -31.13), (0.055, -12.43), (0.15, 16.89)])
def test_ring_calibration(mu, change):
    """Closed equilibrium solution after Hawkyard and Johnson, ring 6:3:2, 50 %: change of the bore in %."""
    ring = compress(rate_independent(), mu, radius=6.0, height=4.0, bore=3.0, n_r=12, n_z=16, step=0.05)
    loop = ring.state.body.chain[:-1]
    bore = ring.state.body.x[np.append(loop[-15:], [loop[0], loop[-16]]), 0]
    assert 100.0 * (1.0 - bore.mean() / 3.0) == pytest.approx(change, abs=3.0)


def test_free_upsetting_to_500_MPa_expands_the_face_by_7_percent():
    """Frictionless, 10 mm/s: kf(phi) = 500 MPa at phi = 0.0674, so psi = e^phi = 1.0697."""
    result = upset(PunchGeometry(), 150e3, mu=0.0, mesh_size=1.2, speed=10.0)
    psi = np.interp(500.0, result.sigma_n_mean, result.psi_mean)
    ratio = np.interp(500.0, result.sigma_n_mean, result.area_ratio)
    assert psi == pytest.approx(1.0697, abs=0.006)
    assert ratio == pytest.approx(1.0697, abs=0.006)
    assert result.psi[-1, :-1] == pytest.approx(1.452, rel=0.01)


def test_surface_under_a_film_meets_the_closed_form():
    """Half space at 120 degC, heat transfer to 20 degC: Carslaw and Jaeger, Conduction of Heat in Solids, 2.7."""
    conductivity, capacity, h, dt = 42.0, 3.69, 35.0, 0.002
    z = np.concatenate([[0.0], np.cumsum(0.03 * 1.12 ** np.arange(40))])
    mesh = grid_mesh(np.linspace(0.0, 1.0, 3), z[z < 14.0])
    T = np.full(len(mesh.x), 120.0)
    bottom = np.flatnonzero(mesh.x[:, 1] == 0.0)
    # A disc of radius 1: each bottom node's share of r dr, consistent over the two rows of elements.
    r = mesh.x[bottom, 0]
    order = bottom[np.argsort(r)]
    share = np.array(
        [0.5 * 0.5 / 6, 0.5 * (2 * 0.5 + 0) / 6 + 0.5 * (2 * 0.5 + 1.0) / 6, 0.5 * (2 + 0.5) / 6]
    )
    zero = np.zeros((len(mesh.quads), 4))
    outside = np.full(3, 20.0)
    for _ in range(100):
        T = heat_step(mesh.x, mesh.quads, T, zero, capacity, conductivity, dt, (order, h * share, outside))
    alpha, t = conductivity / capacity, 0.2
    x = h / conductivity * np.sqrt(alpha * t)
    expected = 20.0 + 100.0 * np.exp(x * x) * erfc(x)
    assert T[order] == pytest.approx(expected, abs=1.0)
    assert T.max() == pytest.approx(120.0, abs=0.1)


def test_heat_released_stays_in_an_insulated_body():
    mesh = grid_mesh(np.linspace(0.0, 5.0, 6), np.linspace(0.0, 4.0, 5))
    source = np.zeros((len(mesh.quads), 4))
    source[3] = 36.9
    T = np.full(len(mesh.x), 20.0)
    for k in range(400):
        T = heat_step(mesh.x, mesh.quads, T, source * (k == 0), 3.69, 42.0, 0.05)
    volume = np.pi * (4.0**2 - 3.0**2) * 1.0
    assert pytest.approx(20.0 + 10.0 * volume / (np.pi * 25.0 * 4.0), abs=1e-3) == T


def test_workpiece_and_tool_exchange_heat_like_two_half_spaces():
    """120 and 20 degC, 35 000 W/m2K, 1.2379 below 16MnCr5 (k 42): surfaces at 0.1 s and 1 s in closed form."""
    steel = replace(steel_16MnCr5(), conductivity=42.0, cp=470.0)
    z = np.concatenate([[0.0], np.cumsum(0.05 * 1.1 ** np.arange(40))])
    mesh = grid_mesh(np.linspace(0.0, 3.0, 4), z[z < 20.0])
    body = Body.at_rest(mesh.x, mesh.quads, np.ascontiguousarray(mesh.loop[:8]), 120.0)
    tool = plate(0.0, 20.0)
    tool.heat_field = block_field(3.0, 0.0, -20.0, lambda p: np.full(len(p), 0.1), 20.0)
    weights = np.zeros(8)
    surface_weights(body.x, body.chain, weights)
    weights[4:] = 0.0
    table = np.zeros((8, 6))
    table[:4, 0] = 1000.0
    weights[3] -= weights[:4].sum() - 4.5
    source = np.zeros((len(body.quads), 4))
    expected = {0.1: (89.15, 65.63), 1.0: (82.89, 74.88)}
    for k in range(1, 501):
        dt = 0.002
        body.T = exchange_heat(body, [tool], [table], weights, source, steel, HeatExchange(), dt)
        for t, (workpiece, cold) in expected.items():
            if k == round(t / dt):
                at = body.surface[:4]
                assert body.T[body.chain[:4]] == pytest.approx(workpiece, abs=1.0)
                assert tool.surface_temperature(at) == pytest.approx(cold, abs=1.0)
