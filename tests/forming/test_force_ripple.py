"""What keeps the force smooth: small elements on roundings, and no node that a tool pulls at."""

from __future__ import annotations

import numpy as np
import pytest

from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.fe.contact import DEEP, FACING, add_contact
from forming.fe.increment import MOST_TENSION
from forming.fe.mesh.polyline import distance_to_arc
from forming.processes import forward_rod_extrusion

PENALTY = 1e5


def test_distance_to_an_arc():
    """Beside the arc the distance from the circle, beyond its ends that from the nearer one."""
    centre, radius = (3.0, -1.0), 2.0
    angles = np.radians([-100.0, -30.0, 10.0, 60.0, 170.0])
    points = np.array(centre) + 2.5 * np.column_stack([np.cos(angles), np.sin(angles)])
    ends = np.array(centre) + radius * np.array([[np.cos(t), np.sin(t)] for t in np.radians([-45.0, 60.0])])
    to_ends = np.hypot(*(points[:, None] - ends[None]).transpose(2, 0, 1)).min(axis=1)
    found = distance_to_arc(points, centre, radius, -45.0, 60.0)
    assert found == pytest.approx([to_ends[0], 0.5, 0.5, 0.5, to_ends[4]])


def sizes(process, points):
    process.start(0.08)
    size = process.simulation.size
    assert size is not None
    return size(process.simulation.state)(np.array(points))


@pytest.mark.parametrize("mesh_size", [0.4, 0.2])
def test_elements_on_the_roundings_of_the_die(mesh_size, monkeypatch):
    """A seventh of the radius or 7/40 of the bite, in proportion to `mesh_size`; far away nothing changes."""
    # The billet's edge stands on the entry at first.
    large = forward_rod_extrusion.FOLDING._replace(share=10.0)
    monkeypatch.setattr(forward_rod_extrusion, "FOLDING", large)
    process = ForwardRodExtrusion(half_angle=30.0, entry_radius=1.0, edge_radius=1.4, mesh_size=mesh_size)
    die, top = process.die, process.die.segments(1.0)[1]
    angle = np.radians(15.0)
    edge = die.exit_radius + die.edge_radius * (1 - np.cos(angle)), die.land + die.edge_radius * np.sin(angle)
    entry = 10.0 - die.entry_radius * (1.0 - np.cos(angle)), top - die.entry_radius * np.sin(angle)
    found = sizes(process, [edge, entry, (2.0, top + 12.0)])
    assert found == pytest.approx([0.49 * mesh_size, 0.35 * mesh_size, 2.25 * mesh_size])
    shallow = ForwardRodExtrusion(exit_diameter=18.0, mesh_size=mesh_size)
    point = 9.0 + 1.5 * (1.0 - np.cos(angle)), 2.0 + 1.5 * np.sin(angle)
    assert sizes(shallow, [point]) == pytest.approx(0.7 / 1.6 * mesh_size)


def test_elements_on_the_rounding_of_the_punch():
    """Less than a tenth of the radius, and less where the wall is thin."""
    for diameter, expected in ((14.14, 0.7 * 1.5 / 8.0), (17.0, 0.7 * 0.35 * 1.5 / 3.0)):
        process = BackwardCupExtrusion(punch_diameter=diameter)
        angle, rp = np.radians(45.0), 0.5 * diameter
        point = rp - 1.5 * (1.0 - np.cos(angle)), 20.0 + 1.5 * (1.0 - np.sin(angle))
        assert sizes(process, [point]) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("gap", "on", "left", "expected"),
    [
        (1e-3, 1, 5, 0),  # under tension: let go, however often it has been before
        (-1e-3, 0, 1, 1),  # overlaps: joins
        (-1e-3, 0, 2, 0),  # has left twice: stays free
        (-2.0 * DEEP, 0, 2, 1),  # but not deep inside
    ],
)
def test_a_node_that_cannot_settle_stays_free(gap, on, left, expected):
    """One node over a flat plate: what the active set makes of it."""
    plate = np.array([[0.0, -1.0, 0.0, 90.0, 0.0, 0.0, 0.0, 0.0]])
    x = np.array([[1.0, gap], [2.0, 5.0]])
    chain, active, releases = np.array([0, 1]), np.array([on, 0]), np.array([left, 0])
    table, nothing = np.zeros((2, FACING + 1)), np.zeros(2)
    still, force = np.zeros((2, 2)), np.zeros(4)
    add_contact(
        x, still, chain, np.ones(2), plate, nothing, nothing, 1.0, nothing, np.full(2, 300.0), PENALTY,
        0.1, 0.01, 0.0, np.zeros((2, 4)), force, np.zeros(2), table, active, releases, True, np.full(2, -1.0),
    )  # fmt: skip
    assert active[0] == expected
    assert table[0, 0] == pytest.approx(-PENALTY * gap if expected else 0.0)
    assert -force[1] == pytest.approx(table[0, 0])


def test_no_increment_ends_with_a_node_under_tension(monkeypatch):
    """None passes the bound; with one that every increment passes (below zero: pressure asked of all nodes) none ends."""
    process = BackwardCupExtrusion(mesh_size=0.7, n_points=40)
    process.start(0.12)
    lowest = []

    def look(simulation):
        lowest.append(min(float(table[:, 0].min()) for table in simulation.state.tables))
        return False

    assert process.advance(0.5, look)
    assert -MOST_TENSION <= min(lowest) <= 0.0
    monkeypatch.setattr("forming.fe.increment.MOST_TENSION", -1.0)
    failures = process.simulation.state.failures
    assert not process.advance(0.1) or process.simulation.state.failures > failures
