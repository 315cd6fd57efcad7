"""Increments end where a node arrives at the end of a rounding; a marker slides from when it arrives at a tool."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from forming import ForwardRodExtrusion
from forming.fe import simulation
from forming.fe.arrival import ARRIVED, cut_at_arrival, touching_shares
from forming.fe.tooling import Tool, arc, line

#: A rounding of 2 mm about (5, 0) that ends at (3, 0), and the straight land below it.
TOOL = Tool("die", np.array([line((3.0, -4.0), (3.0, 0.0)), arc((3.0, 0.0), (5.0, 2.0), (5.0, 0.0), 2.0)]))
LAST = 0.1


def cut(*ways: float, speed: float = 10.0, dt: float = 0.02) -> float:
    """Return the increment for nodes that slide on the rounding these ways [mm] before its end."""
    angle = np.array(ways) / 2.0
    x = np.column_stack([5.0 - 2.0 * np.cos(angle), 2.0 * np.sin(angle)])
    velocity = -speed * np.column_stack([np.sin(angle), np.cos(angle)])
    return cut_at_arrival(x, velocity, np.arange(len(x)), [TOOL], LAST, dt)


def test_an_increment_ends_where_a_node_arrives_and_the_one_before_shortly_ahead():
    assert cut(0.3) == 0.02
    assert cut(0.12) == pytest.approx(0.012)
    assert cut(0.18) == pytest.approx(0.008)
    # The soonest counts; what has arrived does not.
    assert cut(0.5, 0.12, 0.3) == pytest.approx(0.012)
    assert cut(0.5 * ARRIVED * LAST) == 0.02


def test_no_increment_is_left_over_that_is_as_short_as_it_happens_to_be():
    assert cut(0.12, dt=0.0121) == 0.0121
    assert cut(0.12, dt=0.0121 + ARRIVED * LAST / 10.0) == pytest.approx(0.012)


def test_a_rod_in_which_a_node_arrives_just_before_the_end_of_a_communication_step():
    """It left 15 nm to go on a new mesh, and no increment after that converged; truth: no point leaves faster than the rod."""
    process = ForwardRodExtrusion(
        exit_diameter=18.036075553377813,
        half_angle=26.309728638526583,
        entry_radius=3.989884908395895,
        edge_radius=1.0524087364421733,
        land=3.902500910477476,
        relief=0.9353642568055138,
        T_billet=115.50863134909808,
        T_tool=101.45832440811378,
        speed=5.815342846424628,
    )
    process.start(0.06522412825204353)
    leaves = process.speed * (20.0 / 18.036) ** 2
    ends, fastest = [0.0], []

    def look(running):
        markers = running.state.markers
        ends.append(running.state.stroke)
        fastest.append(markers.v_rel[markers.active].max(initial=0.0))
        return False

    while process.stroke < 5.1 and process.advance(0.1, look):
        pass
    assert process.message == "" and process.simulation.state.failures == 0
    assert np.diff(ends).min() > 5e-3
    assert max(fastest) < 1.1 * leaves


def test_nodes_off_the_rounding_do_not_count():
    x, velocity = np.array([[2.9, 0.05], [3.0, -0.05]]), np.array([[0.0, -10.0], [0.0, -10.0]])
    assert cut_at_arrival(x, velocity, np.arange(2), [TOOL], LAST, 0.02) == 0.02


def test_what_comes_to_a_tool_touches_it_for_the_rest_of_the_increment():
    """0.2 mm on the way in an increment; beside the land, at it, out of reach, and beside it without coming closer."""
    x = np.array([[2.9, -1.0], [2.98, -1.0], [3.0, -1.0], [2.7, -1.0], [2.9, -1.0]])
    velocity = np.array([[10.0, 3.0], [10.0, 0.0], [10.0, 0.0], [10.0, 0.0], [0.0, 5.0]])
    shares = touching_shares(x, velocity, np.zeros(5, dtype=bool), TOOL.segments, TOOL.offset, 0.02)
    assert shares == pytest.approx([0.5, 0.9, 1.0, 0.0, 0.5])


def container_distances(largest: float):
    """Sliding distances along the container after 3 mm [mm], increments of at most `largest` mm, and where they are known."""
    process = ForwardRodExtrusion(mesh_size=0.6, n_points=80)
    process.start(0.08)
    process.simulation.control = replace(process.simulation.control, largest=largest)
    assert process.advance(3.0)
    r, z = process.marker_position.T
    return process.loads()[:, 3], process.active & (np.abs(r - 10.0) < 0.1) & (z > 10.0)


def test_the_sliding_distance_hardly_depends_on_the_increments(monkeypatch):
    """Planted: the increment in which the container is reached counts as a whole, on average half of its 0.2 mm too much."""
    fine, on = container_distances(0.02)

    def too_long():
        usual, touches = container_distances(0.2)
        both = on & touches
        assert both.sum() > 30
        return (usual - fine)[both].mean()

    assert abs(too_long()) < 0.03
    monkeypatch.setattr(simulation, "touching_shares", lambda points, *_: np.ones(len(points)))
    assert too_long() > 0.04
