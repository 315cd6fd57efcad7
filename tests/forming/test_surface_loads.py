"""Tractions from nodal forces: against pressures that are integrated here, and against rigid sliding."""

from __future__ import annotations

import numpy as np
import pytest

from forming import ForwardRodExtrusion
from forming.fe import surface_loads as module
from forming.fe.contact import NORMAL_R, NORMAL_Z, PRESSURE
from forming.fe.surface_loads import LEAST_SHARE, facing_of_edges, recovered
from forming.processes import forward_rod_extrusion

GAUSS, SHARE = np.polynomial.legendre.leggauss(12)


def contact(x, pressure, normal):
    """Return a contact table and nodal areas: int N_i p r dl of a given pressure, edge by edge."""
    force, areas = np.zeros((2, len(x)))
    for e in range(len(x) - 1):
        u = 0.5 * (1.0 + GAUSS)
        r, z = ((1.0 - u)[:, None] * x[e] + u[:, None] * x[e + 1]).T
        dA = 0.5 * SHARE * np.hypot(*(x[e + 1] - x[e])) * r
        for node, shape in ((e, 1.0 - u), (e + 1, u)):
            force[node] += (shape * pressure(r, z) * dA).sum()
            areas[node] += (shape * dA).sum()
    table = np.zeros((len(x), 7))
    table[:, PRESSURE] = force / areas
    table[:, [NORMAL_R, NORMAL_Z]] = normal
    return table, areas


def wall(spacing):
    """A cylinder of 5 mm radius, its surface upwards."""
    z = np.concatenate([[0.0], np.cumsum(spacing)])
    return np.column_stack([np.full(len(z), 5.0), z])


def test_a_wave_of_the_pressure_keeps_its_height_and_its_force():
    """Six elements a wave: hats smear its amplitude by sinc^2(1/6); the mass (1 4 1)/6 passes (2 + cos 60 deg)/3 of it.

    The straight lines between the nodes are closest to the wave, in the mean square, after many corrections.
    """
    x = wall(np.full(30, 0.3))

    def wave(r, z):
        return 1000.0 - 600.0 * np.cos(2.0 * np.pi * z / 1.8)

    table, areas = contact(x, wave, (-1.0, 0.0))
    fine = np.linspace(1.8, 7.2, 2001)
    lumped, passed = np.sinc(1.0 / 6.0) ** 2, 2.5 / 3.0
    errors = []
    for sweeps, amplitude in ((0, lumped), (1, lumped * (2.0 - passed)), (60, lumped / passed)):
        found, _ = recovered(x, table, areas, sweeps)
        assert found[6:25] == pytest.approx(1000.0 - amplitude * (1000.0 - wave(*x[6:25].T)), rel=1e-3)
        carried = 5.0 * np.sum(np.diff(x[:, 1]) * 0.5 * (found[1:] + found[:-1]))
        assert carried == pytest.approx(table[:, PRESSURE] @ areas, rel=1e-9)
        errors.append(np.sqrt(np.mean((np.interp(fine, x[:, 1], found) - wave(5.0, fine)) ** 2)))
    assert errors[1] < 0.4 * errors[0] and errors[1] < 1.5 * errors[2]


def test_an_even_pressure_stays_even_on_any_spacing():
    """Also at a corner, of which only one side touches, and on a closed surface that starts there."""
    x = np.array([[0.0, 0.0], [1.0, 0.0], [1.5, 0.0], [2.5, 0.0], [4.0, 0.0], [4.0, 0.6], [4.0, 2.0]])
    table, areas = contact(x, lambda r, z: np.where(z > 0.0, 0.0, 700.0), (0.0, 1.0))
    found, on = recovered(x, table, areas, 3)
    assert found[:5] == pytest.approx(700.0) and (found[5:] == 0.0).all()
    assert on[4] == pytest.approx(1.5 * (2.0 * 4.0 + 2.5) / 6.0) and on[:4] == pytest.approx(areas[:4])
    assert facing_of_edges(x, table) == pytest.approx([1.0, 1.0, 1.0, 1.0, 0.0, 0.0])
    ring = np.array([[2.0, 0.0], [3.0, 0.0], [4.0, 0.0], [4.0, 1.0], [2.0, 1.0], [2.0, 0.0]])
    table, areas = contact(ring, lambda r, z: np.where(z > 0.0, 0.0, 700.0), (0.0, 1.0))
    # The first node is the last, too: its force counts over both of its edges.
    both = (table[[0, -1], PRESSURE] @ areas[[0, -1]]) / areas[[0, -1]].sum()
    table[[0, -1], PRESSURE] = both
    assert recovered(ring, table, areas, 3)[0][[0, 1, 2, 5]] == pytest.approx(700.0)
    assert both < 700.0 * (1.0 - LEAST_SHARE)


def slow_on_the_container():
    """Share of the markers on the container that do not slide with the punch, well above the cone."""
    process = ForwardRodExtrusion(mesh_size=0.6, n_points=80)
    process.start(0.08)
    assert process.advance(4.0)
    r, z = process.marker_position.T
    on = process.active & (np.abs(r - 10.0) < 0.1) & (z > 12.0)
    assert on.sum() > 30
    return np.mean(np.abs(process.loads()[on, 0] - 5.0) > 0.3)


def test_a_marker_beside_a_corner_slides_along_its_own_side(monkeypatch):
    """Billet in the container: it slides as fast as the punch up to its corner, where the punch presses harder."""
    # Elements as large as elsewhere, in which the fault shows.
    monkeypatch.setattr(forward_rod_extrusion, "IN_CORNER", 10.0)
    assert slow_on_the_container() == 0.0
    honest = module.surface_loads

    def mixed(*args):
        loads = honest(*args)
        loads.pressures[:], loads.slips[:] = loads.pressure, loads.slip
        loads.faced[:] = 0
        return loads

    monkeypatch.setattr("forming.fe.simulation.surface_loads", mixed)
    assert slow_on_the_container() > 0.0


def test_the_land_is_free_where_the_fine_mesh_has_no_contact(monkeypatch):
    """Elements of 0.1 mm: no contact on the land 0.5 mm behind the rounding at 6 to 10 mm of stroke (mean 0.00 MPa)."""
    assert land_pressure() < 1.0
    monkeypatch.setattr(forward_rod_extrusion, "ARRIVAL", 0.0)
    monkeypatch.setattr(forward_rod_extrusion, "ROUNDED", 1.4)
    assert land_pressure() > 1.0


def test_a_remeshing_does_not_push_a_rod_against_the_land(monkeypatch):
    """Elements of 0.5 mm, 5 to 8 mm of stroke; planted: all free nodes share what keeps the volume, also those beside a tool."""
    assert land_pressure(0.5, 8.0) < 8.0
    monkeypatch.setattr("forming.fe.remesh._leave_gap", lambda *_: None)
    assert land_pressure(0.5, 8.0) > 15.0


def land_pressure(mesh_size=0.4, stroke=6.5):
    process = ForwardRodExtrusion(mesh_size=mesh_size, n_points=20)
    process.start(0.08)
    means = []

    def look(simulation):
        state = simulation.state
        if state.stroke > 5.0:
            r, z = state.body.surface.T
            on = (z > 0.0) & (z < 1.5) & (r > 5.0)
            pressure = np.maximum(state.tables[0][:, PRESSURE], 0.0)
            means.append(pressure[on] @ state.weights[on] / state.weights[on].sum())
        return False

    assert process.advance(stroke, look)
    return np.mean(means)


def test_the_pressure_beside_the_corner_of_punch_and_container(monkeypatch):
    """Markers 70 to 74 of 80, the last one on the punch, against ForwardRodExtrusion(mesh_size=0.1) at 3 mm."""
    fine = np.array([382.4, 373.0, 352.8, 321.6, 761.7])

    def largest_error():
        process = ForwardRodExtrusion(mesh_size=0.4)
        process.start(0.08)
        assert process.advance(3.0)
        return np.abs(process.loads()[70:75, 2] / fine - 1.0).max()

    assert largest_error() < 0.075
    monkeypatch.setattr(forward_rod_extrusion, "IN_CORNER", 10.0)
    assert largest_error() > 0.2
