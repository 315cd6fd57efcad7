"""Backward cup extrusion: force, energy, surface expansion, bad input."""

from __future__ import annotations

import numpy as np
import pytest

from forming import BackwardCupExtrusion
from friction_models.loads import InputError


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
    assert abs(cup.energy_balance) < 6e-3
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


@pytest.mark.parametrize("wrong", [{"punch_diameter": 25.0}, {"edge_radius": 0.0}, {"billet_length": -3.0}])
def test_impossible_processes_are_refused(wrong):
    name, value = next(iter(wrong.items()))
    with pytest.raises(InputError, match=f"backward cup extrusion: {name} = {value}"):
        BackwardCupExtrusion(**wrong)


def test_a_base_must_stay():
    with pytest.raises(InputError, match=r"stroke = 19\.5 mm; allowed"):
        BackwardCupExtrusion().run(0.08, 19.5)
