"""Upsetting and ring compression as processes: bore, friction, remeshing of a ring, snapshots, bad input."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from forming.fe.mesh.mesh_kernels import qualities
from forming.fe.mesh.polyline import enclosed_volume
from forming.fe.remesh import mesh_inside, resample_surface, surface_chain
from forming.fe.tooling import plate
from forming.processes.friction_input import CONSTANT_SHEAR
from forming.processes.upsetting import RingCompression, Upsetting, bore_profile
from friction_models.common import InputError

COARSE = {"mesh_size": 0.5, "n_points": 40, "tool_heating": False}


def square_ring(h: float) -> np.ndarray:
    """Closed outline of a ring, r 3 to 6 mm, z 0 to 4 mm."""
    corners = np.array([[3.0, 0.0], [6.0, 0.0], [6.0, 4.0], [3.0, 4.0], [3.0, 0.0]])
    sides = [np.linspace(a, b, round(np.hypot(*(b - a)) / h), endpoint=False) for a, b in pairwise(corners)]
    return np.concatenate([*sides, corners[:1]])


def test_the_bore_grows_without_friction_and_shrinks_with_it():
    change = {}
    for mu in (0.0, 0.05, 0.2):
        ring = RingCompression(**COARSE)
        result = ring.run(mu, 1.6)
        assert result.status == "ok", result.message
        assert abs(result.volume_change) < 1e-3 and abs(result.energy_balance) < 1e-2
        change[mu] = ring.bore_change
    # Homogeneous upsetting by 40 %: every radius grows by 1 / sqrt(0.6).
    assert change[0.0] == pytest.approx(0.6**-0.5 - 1.0, abs=4e-3)
    assert change[0.0] > change[0.05] > 0.0 > change[0.2]


def test_shear_factor_caps_the_friction():
    capped = RingCompression(**COARSE, shear_factor=0.2)
    result = capped.run(CONSTANT_SHEAR, 1.0)
    assert result.max_tau_over_k == pytest.approx(0.2, abs=0.005)
    free = RingCompression(**COARSE, shear_factor=0.0)
    free.run(CONSTANT_SHEAR, 1.0)
    assert free.bore_change == pytest.approx(0.75**-0.5 - 1.0, abs=2e-3)


def test_markers_run_around_the_ring():
    ring = RingCompression(**COARSE)
    ring.start(0.1)
    start = ring.marker_position
    assert start[0] == pytest.approx(start[-1], abs=1e-9)
    ring.advance(1.0)
    loads, at = ring.loads(), ring.marker_position
    assert ring.active.sum() > 10 and not ring.active.all()
    pressed = np.isclose(at[:, 1], 0.0, atol=0.02) | np.isclose(at[:, 1], 3.0, atol=0.02)
    assert ring.active[pressed].mean() > 0.9
    assert loads[ring.active, 2].min() > 100.0 and loads[:, 3].max() > 0.1


def test_a_ring_is_remeshed_with_its_bore():
    outline = square_ring(0.4)
    size = lambda points: np.full(len(points), 0.3)  # noqa: E731
    table = np.zeros((len(outline), 6))
    surface = resample_surface(outline, size, [plate(-5.0, widest=10.0)], [table])
    assert surface.points[0] == pytest.approx(surface.points[-1], abs=0.0)
    assert enclosed_volume(surface.points) == pytest.approx(np.pi * 27.0 * 4.0, rel=1e-6)
    mesh = mesh_inside(surface.points, size)
    assert qualities(mesh.x, mesh.quads).min() > 0.3
    assert mesh.x[:, 0].min() == pytest.approx(3.0, abs=1e-6)
    chain = surface_chain(mesh, surface.points)
    assert chain[0] == chain[-1] and mesh.x[chain] == pytest.approx(surface.points)


def test_a_ring_goes_on_after_remeshing():
    ring, other = RingCompression(**COARSE, remeshing=True), RingCompression(**COARSE)
    for process in (ring, other):
        process.start(0.08)
        assert process.advance(0.8)
    before = ring.simulation.state.body.unloaded_volume(ring.material.bulk_modulus)
    assert ring.simulation.remesh()
    after = ring.simulation.state.body.unloaded_volume(ring.material.bulk_modulus)
    assert after == pytest.approx(before, rel=2e-4)
    for process in (ring, other):
        assert process.advance(0.6), process.message
    assert ring.simulation.state.remeshes >= 1 and other.simulation.state.remeshes == 0
    assert ring.force == pytest.approx(other.force, rel=0.015)
    assert ring.bore_radius == pytest.approx(other.bore_radius, rel=0.01)
    assert ring.loads()[:, 3] == pytest.approx(other.loads()[:, 3], abs=0.06)


def test_restored_snapshot_continues_bit_by_bit():
    ring = RingCompression(**COARSE)
    ring.start(0.1)
    ring.advance(0.4)
    kept = ring.snapshot()
    ends = []
    for _ in range(2):
        ring.restore(kept)
        ring.advance(0.4)
        ends.append((ring.force, ring.work, ring.bore_radius, ring.loads()))
    assert ends[0][:3] == ends[1][:3] and np.array_equal(ends[0][3], ends[1][3])


def test_heat_softens_and_isothermal_stays_cold():
    warm, cold = Upsetting(mesh_size=1.25), Upsetting(mesh_size=1.25, isothermal=True)
    forces = [process.run(0.05, 5.0).force[-1] for process in (warm, cold)]
    assert forces[0] < 0.99 * forces[1]
    assert np.ptp(cold.simulation.state.body.T) < 1e-9
    assert warm.simulation.state.body.T.max() > 60.0


def test_bore_profile_takes_the_innermost_surface():
    outline = np.array([[3.0, 0.0], [6.0, 0.0], [6.0, 4.0], [3.0, 4.0], [2.0, 2.0], [3.0, 0.0]])
    profile = bore_profile(outline, 100)
    assert profile.min() == pytest.approx(2.0, abs=0.02) and profile.max() == pytest.approx(3.0, abs=0.02)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"bore_diameter": 20.0}, "bore_diameter = 20.0"),
        ({"bore_diameter": 0.0}, "bore_diameter = 0.0"),
        ({"height": -1.0}, "height = -1.0"),
        ({"shear_factor": 1.5}, "shear_factor = 1.5"),
        ({"mesh_size": 3.0}, "mesh_size = 3.0"),
        ({"speed": float("nan")}, "speed = nan"),
        ({"htc": -1.0}, "htc = -1.0"),
        ({"n_points": 12.5}, "n_points = 12.5"),
    ],
)
def test_impossible_rings_are_refused(wrong, words):
    with pytest.raises(InputError, match=f"ring compression: {words}.*allowed"):
        RingCompression(**wrong)


def test_a_solid_cylinder_has_no_narrow_bore():
    with pytest.raises(InputError, match=r"bore_diameter = 0\.1 mm; allowed: 0 \(solid\)"):
        Upsetting(bore_diameter=0.1)
    with pytest.raises(InputError, match="stroke"):
        Upsetting().run(0.1, 14.0)


@pytest.mark.parametrize("remeshing", [False, True])
@pytest.mark.parametrize("size", [(20.0, 8.0, 3.0), (12.0, 4.0, 2.0)])
def test_a_bore_that_closes_ends_the_run(size, remeshing):
    ring = RingCompression(*size, mesh_size=size[1] / 8.0, remeshing=remeshing)
    with np.errstate(all="raise", under="ignore"):
        result = ring.run(0.2, stroke=0.78 * size[1])
    assert result.status == "stopped" and "the bore of the workpiece closes at z = " in result.message
    assert 0.5 * size[1] < result.stroke[-1] < 0.78 * size[1]
    assert 0.0 < ring.simulation.state.body.surface[:, 0].min() < 0.03 * size[2]
    assert (result.contact.loads[:, :, 4] > 0.0).all()


def test_flat_tools_reach_beyond_wide_bodies():
    """Without friction the radius grows to 178 / 2 / sqrt(0.5) = 125.9 mm."""
    disc = Upsetting(178.0, 44.5, mesh_size=11.0, n_points=20, isothermal=True)
    result = disc.run(0.0, stroke=22.25)
    assert result.status == "ok", result.message
    assert disc.marker_position[:, 0].max() == pytest.approx(89.0 / 0.5**0.5, rel=5e-3)
