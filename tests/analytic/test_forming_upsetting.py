"""Upsetting and heat against closed forms and an independent finite element code."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import erfc

from forming.fe.heat.conduction import heat_step
from forming.fe.mesh.mesher import grid_mesh
from forming.processes.specimen_upsetting import upset
from forming.processes.upsetting import Upsetting
from forming.tools.punch_geometry import PunchGeometry
from forming.verification import CASES, ring
from forming.verification.table import text_table


@pytest.mark.parametrize(
    "name", [pytest.param("upset-frictionless", marks=pytest.mark.nightly), "upset-calculix"]
)
def test_upsetting_meets_closed_form_and_calculix(name):
    """15 x 15 mm, 50 %: 224.6 kN without friction, 234.4 kN in CalculiX at mu 0.1."""
    result = next(case for case in CASES if case.name == name).run()
    assert not result.failed, text_table([result])


def test_frictionless_upsetting_is_homogeneous():
    process = Upsetting(mesh_size=1.25, isothermal=True)
    process.run(0.0, 7.5)
    strain = process.simulation.state.body.strain
    assert strain == pytest.approx(np.log(2.0), rel=0.01)
    assert np.ptp(strain) < 2e-3


@pytest.mark.parametrize("mu", [0.02, 0.055, 0.15])
def test_ring_calibration(mu):
    """Closed equilibrium solution after Hawkyard and Johnson, ring 6:3:2, at 10 to 50 %: change of the bore in %."""
    assert ring.readings(ring.ring(), mu) == pytest.approx(ring.BY_MU[mu], abs=ring.POINTS)


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
    result = next(case for case in CASES if case.name == "heat-workpiece-tool").run()
    assert len(result.rows) == 4 and not result.failed, text_table([result])
