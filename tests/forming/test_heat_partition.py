"""Share of the friction heat that a workpiece takes up, and what tools take up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from forming import RingCompression, Upsetting
from forming.fe.mesh.shape import nodal_volumes
from forming.fe.tooling import block_field
from forming.materials.base import Material
from friction_models.common import InputError


@pytest.mark.parametrize("share", [0.0, 0.5, 0.8])
def test_the_workpiece_takes_its_share_of_the_friction_work(share: float) -> None:
    process = Upsetting(mesh_size=1.8, n_points=12, friction_heat_share=share)
    process.start()
    process.set_mu(0.15)
    process.advance(2.0)
    energy, material = process.simulation.state.energy, process.simulation.material
    assert energy.friction > 0.02 * energy.plastic
    released = energy.heat_generated - material.taylor_quinney * energy.plastic
    assert released == pytest.approx(share * energy.friction, rel=0.02, abs=2e-3 * energy.friction)


def held(field) -> float:
    """Return the heat in a tool of constant capacity that was at 20 degC [N mm]."""
    return (
        2.0 * math.pi * field.steel.capacity * float(nodal_volumes(field.x, field.quads) @ (field.T - 20.0))
    )


@pytest.mark.parametrize("radius", [5.0, 5.1, 5.1 + 1e-9, 5.4, 5.6, 5.9, 6.0 - 1e-9])
def test_a_tool_is_heated_exactly_as_far_as_the_contact_reaches(radius: float) -> None:
    """Elements of 1 mm, of which the contact covers a part. Counted in pieces, heat jumped as the contact grew by next to nothing."""
    field = block_field(10.0, 0.0, -5.0, lambda points: np.full(len(points), 1.0), 20.0)
    body = np.array([[0.0, 0.0], [0.5 * radius, 0.0], [radius, 0.0], [radius + 3.0, 3.0]])
    touching, power = np.array([True, True, True, False]), np.full(4, 500.0)
    for _ in range(5):
        field.step(
            1e-3, body, touching, np.array([1.0, 1.0, 0.0]), field.surface_temperature(body), power, 1e-6
        )
    expected = 5e-3 * 500.0 * math.pi * radius**2
    assert held(field) == pytest.approx(expected, rel=1e-8)


def test_half_of_an_edge_that_leaves_the_tool_counts_with_what_its_end_in_contact_has() -> None:
    """As much as the last node of the workpiece holds; the edge is 3 mm long and turned by 45 degrees, the tool coarser."""
    field = block_field(10.0, 0.0, -5.0, lambda points: np.full(len(points), 1.4), 20.0)
    side = 3.0 * math.sqrt(0.5)
    body = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [4.0 + side, side]])
    touching, power = np.array([True, True, True, False]), np.array([500.0, 500.0, 500.0, 0.0])
    facing = np.array([1.0, 1.0, math.sqrt(0.5)])
    field.step(1e-3, body, touching, facing, np.full(4, 20.0), power, 1e-9)
    expected = 1e-3 * 500.0 * math.pi * (4.0 + 0.5 * side) ** 2
    assert held(field) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize(
    ("process", "stroke"),
    [
        (Upsetting(40.0, 30.0, speed=100.0, tool_material=Material(cp=460.0, conductivity=20.0)), 12.0),
        (
            RingCompression(
                24.0, 8.0, 12.0, speed=100.0, tool_material=Material(cp=460.0, conductivity=20.0)
            ),
            3.2,
        ),
    ],
)
def test_tools_take_up_what_friction_and_the_workpiece_give_them(process: Upsetting, stroke: float) -> None:
    """At the rim a node holds a part of the free side, which neither rubs nor touches. Strokes are too short for the back of the tools."""
    assert process.run(0.08, stroke).status == "ok"
    state = process.simulation.state
    given = 0.5 * state.energy.friction + state.energy.heat_to_tools
    taken = sum(held(tool.heat_field) for tool in state.tools)
    assert taken == pytest.approx(given, abs=0.07 * 0.5 * state.energy.friction)


def test_a_share_lies_between_nothing_and_all() -> None:
    with pytest.raises(InputError, match=r"friction_heat_share = 1\.2 *; allowed: 0 to 1"):
        Upsetting(friction_heat_share=1.2)
