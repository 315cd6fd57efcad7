"""Backward cup extrusion: force, energy, surface expansion, bad input."""

from __future__ import annotations

import numpy as np
import pytest

from forming import BackwardCupExtrusion
from forming.fe.contact import gap_and_normal
from forming.tools.cup_punch import CupPunch
from friction_models.common import InputError


@pytest.fixture(scope="module")
def cup():
    return BackwardCupExtrusion(tool_heating=False).run(0.08, 4.0)


def test_force_of_the_reference_case(cup):
    """Punch 14.14 mm, edge 1.5 mm, billet D 20 x 20, 5 mm/s: 268 / 295 / 311 kN at 1 / 2 / 4 mm (own earlier study)."""
    force = np.interp([1.0, 2.0, 3.9], cup.stroke, cup.smooth_force)
    assert cup.status == "ok", cup.message
    assert force == pytest.approx([268.0, 295.0, 311.0], rel=0.015)


def test_force_lies_in_the_band_of_dipper(cup):
    """Dipper's formula for D 20, punch 14, h0 20, h1 10, mu 0.08: 325 kN; a sanity band."""
    assert cup.max_force == pytest.approx(325.0, rel=0.2)


def test_energy_volume_and_markers(cup):
    assert abs(cup.energy_balance) < 5e-3
    assert abs(cup.volume_change) < 1e-3
    assert cup.remeshes > 4
    loads = cup.contact.loads
    assert (np.diff(loads[:, :, 3], axis=0) >= 0.0).all()
    # Material that flows round the punch edge gives the inner wall: its surface grows manyfold.
    assert loads[-1, 40:, 4].max() > 4.0
    assert cup.contact.position[-1, :, 1].max() > 23.0
    assert 0.2 < cup.max_tau_over_k < 1.0


def test_warm_tools_run_and_stepping_works():
    process = BackwardCupExtrusion(mesh_size=0.6, n_points=40, T_tool=100.0)
    process.start(0.05)
    for _ in range(5):
        assert process.advance(0.1)
        process.set_mu(0.05)
    assert process.stroke == pytest.approx(0.5)
    assert process.loads().shape == (40, 5) and process.active.any()
    assert process.loads()[process.active, 1].max() > 55.0


@pytest.mark.parametrize(
    "wrong",
    [
        {"punch_diameter": 25.0},
        {"edge_radius": 0.0},
        {"billet_length": -3.0},
        {"nose_angle": 45.0},
        {"tip_radius": -1.0},
        {"relief": 9.0},
    ],
)
def test_impossible_processes_are_refused(wrong):
    name, value = next(iter(wrong.items()))
    with pytest.raises(InputError, match=f"backward cup extrusion: {name} = {value}"):
        BackwardCupExtrusion(**wrong)


def test_a_blunt_tip_must_fit_the_nose():
    with pytest.raises(InputError, match=r"tip_radius = 15 mm; allowed: at most 13\.9 mm"):
        BackwardCupExtrusion(nose_angle=25.0, tip_radius=15.0)


@pytest.mark.parametrize("nose_angle", [0.0, 10.0, 30.0])
def test_punch_outline_is_closed_and_smooth(nose_angle):
    punch = CupPunch(7.07, 1.5, 2.0, nose_angle, 2.0, 0.3)
    segments = punch.segments(30.0)
    assert segments[1:, 1:3] == pytest.approx(segments[:-1, 3:5], abs=1e-9)
    for s in segments[segments[:, 0] == 1.0]:
        for end in (s[1:3], s[3:5]):
            assert np.hypot(*(end - s[5:7])) == pytest.approx(abs(s[7]), abs=1e-9)
    # The lowest point stands on the axis at z = 0, and the shaft behind the land is thinner.
    gap, _, nz = gap_and_normal(0.0, -1.0, segments, 0.0, 0.0)
    assert (gap, nz) == pytest.approx((1.0, -1.0))
    assert segments[0, 1] == pytest.approx(7.07 - 0.3)
    direction = [(s[3:5] - s[1:3]) / np.hypot(*(s[3:5] - s[1:3])) for s in segments if s[0] == 0.0]
    assert direction[-1] @ [
        -np.cos(np.radians(nose_angle)),
        -np.sin(np.radians(nose_angle)),
    ] == pytest.approx(1.0)


def test_conical_nose_and_thin_wall_run_from_first_touch():
    flat, cone = (
        BackwardCupExtrusion(mesh_size=0.6, n_points=40, tool_heating=False, nose_angle=a).run(0.08, 2.0)
        for a in (0.0, 20.0)
    )
    assert flat.status == "ok" and cone.status == "ok", cone.message
    # A cone meets the billet at its tip: less force at the start.
    assert cone.force[3] < 0.5 * flat.force[3]
    thin = BackwardCupExtrusion(punch_diameter=18.0, n_points=40).run(0.15, 0.3)
    assert thin.status == "ok" and thin.force[-1] > 300.0, thin.message


def test_a_base_must_stay():
    with pytest.raises(InputError, match=r"stroke = 19\.5 mm; allowed"):
        BackwardCupExtrusion().run(0.08, 19.5)
