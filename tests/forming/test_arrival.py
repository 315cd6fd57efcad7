"""Increments end where a node arrives at the end of a rounding."""

from __future__ import annotations

import numpy as np
import pytest

from forming.fe.arrival import ARRIVED, cut_at_arrival
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


def test_nodes_off_the_rounding_do_not_count():
    x, velocity = np.array([[2.9, 0.05], [3.0, -0.05]]), np.array([[0.0, -10.0], [0.0, -10.0]])
    assert cut_at_arrival(x, velocity, np.arange(2), [TOOL], LAST, 0.02) == 0.02
