"""Remeshing keeps the heat; a surface that folds onto itself ends the run."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from forming import ForwardRodExtrusion
from forming.fe.body import Body
from forming.fe.heat.properties import integral
from forming.fe.heat_exchange import keep_heat
from forming.fe.mesh.mesher import grid_mesh
from forming.fe.mesh.polyline import first_crossing
from forming.fe.mesh.shape import N_GAUSS, gauss_volumes
from forming.fe.mesh.transfer import shape_weights, transfer
from forming.fe.remesh import mesh_inside
from forming.materials.materials import steel_16MnCr5
from forming.processes.upsetting import RingCompression, Upsetting


def heat(body: Body, material) -> float:
    """Heat in a body above 0 degC [N mm]."""
    density = integral(material.heat_capacity, body.T) - integral(material.heat_capacity, 0.0)
    return float((gauss_volumes(body.x, body.quads) * (density[body.quads] @ N_GAUSS.T)).sum())


def chilled(h: float, T: float) -> tuple[Body, Body]:
    """A hot cylinder with a cold skin, thinner than an element, and its temperatures on another mesh."""
    n = max(4, round(12.0 / h / 2) * 2)
    mesh = grid_mesh(np.linspace(0.0, 8.0, n + 1), np.linspace(0.0, 12.0, n + 1))
    old = Body.at_rest(mesh.x, mesh.quads, mesh.loop, T)
    depth = np.minimum(8.0 - old.x[:, 0], np.minimum(old.x[:, 1], 12.0 - old.x[:, 1]))
    old.T = T - 0.6 * (T - 20.0) * np.exp(-depth / (0.5 * h))
    surface = np.concatenate([mesh.x[mesh.loop[: 3 * n + 1]]])
    fine = mesh_inside(surface, lambda points: np.full(len(points), 0.7 * h))
    new = Body.at_rest(fine.x, fine.quads, fine.loop, T)
    _, nodal = transfer(old.x, old.quads, np.zeros((len(old.quads), 4, 1)), old.T[:, None], new.x, new.quads)
    new.T = nodal[:, 0]
    return old, new


@settings(max_examples=8, deadline=None, derandomize=True)
@given(h=st.floats(0.6, 2.0), T=st.floats(100.0, 900.0))
def test_a_coarse_hot_mesh_keeps_its_heat(h, T):
    material = steel_16MnCr5()
    old, new = chilled(h, T)
    wanted, interpolated = heat(old, material), heat(new, material)
    lost = abs(interpolated / wanted - 1.0)
    before = new.T.copy()
    new.T = keep_heat(old, new, material)
    assert heat(new, material) == pytest.approx(wanted, rel=1e-9)
    assert lost > 1e-7
    # What is corrected is small, and the hot core stays.
    assert np.abs(new.T - before).max() < 0.1 * (T - 20.0)


def test_a_body_of_one_temperature_stays_as_it_is():
    material = steel_16MnCr5()
    old, new = chilled(1.5, 300.0)
    old.T, new.T = np.full(len(old.x), 300.0), np.full(len(new.x), 300.0)
    assert keep_heat(old, new, material) == pytest.approx(300.0, abs=1e-9)


def test_remeshings_of_a_run_keep_the_heat():
    process = ForwardRodExtrusion(mesh_size=0.6, n_points=40, T_billet=250.0)
    process.start(0.1)
    process.advance(1.0)
    simulation = process.simulation
    old, material = simulation.state.body, simulation.material
    assert simulation.remesh()
    new = simulation.state.body
    above = np.array([heat(b, material) for b in (old, new)])
    # The volumes differ by some 1e-6; their share at the mean temperature goes with them.
    grown = (new.volume() / old.volume() - 1.0) * above[0]
    assert abs(grown) < 1e-4 * above[0]
    assert above[1] - above[0] == pytest.approx(grown, abs=2e-6 * above[0])
    # One right after another, too: the contact before the first still tells what a tool holds.
    assert simulation.remesh()
    assert simulation.state.body.volume() == pytest.approx(new.volume(), rel=1e-6)


@pytest.mark.parametrize(("scale", "mu"), [(1.0, 0.3), (0.1, 0.05)])
def test_a_coarse_ring_keeps_its_volume(scale, mu):
    """Elements of a fourth of the wall cut off its corners: what is lost there stands elsewhere, whatever the size of the ring."""
    process = RingCompression(
        diameter=12.0 * scale, bore_diameter=6.0 * scale, height=4.0 * scale, mesh_size=0.75 * scale, n_points=40, isothermal=True,
        remeshing=True,
    )  # fmt: skip
    process.start(mu)
    for share in (0.5, 0.6):
        assert process.advance(share * process.height - process.stroke)
        before = process.simulation.state.body.volume()
        assert process.simulation.remesh()
        assert process.simulation.state.body.volume() == pytest.approx(before, rel=1e-7)


SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])


def test_crossing_edges_are_found_and_touching_neighbours_are_not():
    assert first_crossing(SQUARE) == -1
    # A lap: the side comes down over itself and ends inside.
    lap = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [5.0, 1.0], [3.0, 1.0], [3.0, 4.0], [0.0, 4.0]])
    assert first_crossing(lap) == 1
    ring = np.array([[2.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 3.0], [2.0, 0.0]])
    assert first_crossing(ring) == -1
    ring[2] = [1.0, 1.0]
    assert first_crossing(ring) >= 0


def test_a_surface_that_folds_onto_itself_ends_the_run_and_says_where():
    """A cylinder with a groove all round, which upsetting closes."""
    process = Upsetting(diameter=12.0, height=12.0, mesh_size=1.0, n_points=40, isothermal=True)
    process.start(0.1)
    body = process.simulation.state.body
    groove, lips = (np.abs(np.abs(body.x[:, 1] - 6.0) - away) < 0.1 for away in (0.0, 1.0))
    share = np.clip(0.5 * (body.x[:, 0] - 4.0), 0.0, 1.0)
    body.x[groove, 0] -= 0.6 * share[groove]
    body.x[lips, 0] += 0.35 * share[lips]
    body.x[lips, 1] -= 0.75 * (share * np.sign(body.x[:, 1] - 6.0))[lips]
    assert first_crossing(body.surface) == -1
    going = True
    while going and process.stroke < 6.0:
        going = process.advance(0.2)
    assert not going and process.status == "stopped"
    assert "folded onto itself at r = " in process.message, process.message
    assert 0.0 < process.stroke < 6.0 and process.force > 0.0


def test_a_point_just_outside_belongs_to_the_element_whose_side_it_is_at():
    """In the crooked neighbour Newton's method ends elsewhere, with coordinates that look as if the point were inside."""
    x = np.array(
        [
            [9.3984, 30.2208],
            [9.5246, 30.4359],
            [9.2871, 30.4808],
            [9.1168, 30.3631],
            [9.5612, 30.6431],
            [9.2171, 30.6432],
        ]
    )
    quads = np.array([[0, 1, 2, 3], [1, 4, 5, 2]])
    corner, outward = x[5], np.array([0.0, 1.0])
    points = corner + np.array([-1e-7, 1e-9, 1e-7, 1e-5])[:, None] * outward
    nodes, shares = shape_weights(points, x, quads)
    found = (shares[:, :, None] * x[nodes]).sum(axis=1)
    np.testing.assert_allclose(found, points, atol=2e-5)


@pytest.mark.parametrize(("mu", "speed", "stroke"), [(0.08, 5.0, 3.0), (0.06, 50.0, 6.0)])
def test_loads_hardly_change_with_a_friction_that_hardly_changes(mu, speed, stroke):
    """Else remeshing makes them jump, and the repetitions of a communication step find no end."""
    loads = []
    for friction in (mu, mu * (1.0 + 1e-8)):
        process = ForwardRodExtrusion(speed=speed)
        process.run(friction, stroke=stroke)
        assert process.simulation.state.remeshes > 5
        loads.append(process.loads())
    assert (np.abs(loads[1] - loads[0]).max(axis=0) < 1e-6 * np.abs(loads[0]).max(axis=0)).all()
