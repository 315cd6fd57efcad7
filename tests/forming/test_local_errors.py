"""Stated errors of the local loads: against a finer mesh, and where both runs differ by what the test says."""

from __future__ import annotations

import numpy as np
import pytest

from forming import ForwardRodExtrusion, RingCompression
from forming.processes import base
from forming.results.files import load_result
from forming.results.local_errors import FACTORS, local_errors, summary

#: Marker, v_rel, T, sigma_n, sd, psi of ForwardRodExtrusion(mesh_size=0.15, n_points=40).run(0.08, 4.0) at its end: elements
#: a quarter as large as in the run below.
FINE = np.array(
    [
        (5, 6.208, 74.464, 1081.64, 3.072, 0.788),
        (6, 5.225, 69.226, 1243.233, 2.871, 1.059),
        (7, 4.863, 63.414, 1274.274, 2.083, 0.966),
        (8, 4.853, 56.95, 1242.579, 2.114, 0.971),
        (9, 4.92, 48.71, 593.304, 1.917, 0.982),
        (10, 4.84, 42.038, 575.029, 1.819, 0.977),
        (12, 4.912, 32.217, 587.522, 1.698, 0.979),
        (14, 4.93, 27.413, 514.988, 1.622, 0.984),
        (16, 4.943, 25.584, 449.584, 1.632, 0.988),
        (18, 4.955, 24.968, 412.363, 1.712, 0.99),
        (20, 4.966, 24.934, 403.494, 1.803, 0.991),
        (22, 4.973, 25.229, 428.432, 1.856, 0.992),
        (24, 4.977, 25.565, 459.669, 1.919, 0.992),
        (26, 4.98, 25.808, 481.532, 1.929, 0.992),
        (28, 4.982, 25.978, 497.14, 1.899, 0.992),
        (30, 4.984, 26.081, 507.984, 1.865, 0.991),
        (32, 4.987, 26.126, 515.842, 1.842, 0.991),
        (34, 4.991, 25.931, 510.662, 1.807, 0.99),
        (36, 4.996, 24.789, 408.078, 1.694, 0.985),
    ]
)


@pytest.fixture(scope="module")
def rod():
    return ForwardRodExtrusion(mesh_size=0.6, n_points=40).run(0.08, 4.0, with_errors=True)


def test_stated_errors_cover_those_against_a_mesh_four_times_finer(rod):
    """Nine of ten loads, and stated at most some times too large."""
    marker, fine = FINE[:, 0].astype(int), FINE[:, 1:]
    contact = rod.contact
    assert contact.active[-1, marker].all()
    error = np.abs(contact.loads[-1, marker] - fine)
    stated = contact.errors[-1, marker]
    assert (error <= stated).mean() > 0.85
    assert np.median(stated / np.maximum(error, 1e-9)) < 6.0
    # Not because they are large.
    assert (np.median(stated, axis=0) < [0.2, 2.0, 40.0, 0.2, 0.02]).all()


def test_they_are_kept_and_shown(rod, tmp_path):
    again, _ = load_result(rod.save(tmp_path / "rod"))
    assert again.contact.errors == pytest.approx(rod.contact.errors)
    assert "sigma_n_error" in rod.contact.to_frame()
    assert "stated error" in rod.report(tmp_path / "rod.html").read_text()
    names = [name for name, *_ in summary(rod.contact.loads, rod.contact.active, rod.contact.errors)]
    assert names == ["v_rel", "T", "sigma_n", "sd", "psi"]


def test_the_mean_difference_around_a_marker_counts():
    """A single step and marker at which the runs agree by chance is no better than those beside it."""
    loads, on = np.zeros((50, 20, 5)), np.ones((50, 20), dtype=bool)
    other = loads + 3.0
    other[25, 10] = 0.0
    errors = local_errors(loads, on, {1.5: (other, on)})
    assert (errors[25, 10] > 0.85 * 6.0 * np.array(FACTORS)).all() and (errors[25, 10] < errors[2, 2]).all()
    assert errors[2, 2] == pytest.approx(6.0 * np.array(FACTORS))


def test_errors_of_first_order_are_stated_alike_by_every_coarser_run():
    """Loads that are 4 h too high: elements of 1.5 h and 2 h say the same, together as alone; without order the mean counts."""
    h, on = 0.4, np.ones((30, 12), dtype=bool)

    def with_elements(c):
        return np.full((30, 12, 5), 100.0 + 4.0 * c * h), on

    exact = 4.0 * h * np.array(FACTORS)
    for coarse in ((1.5,), (2.0,), (1.5, 2.0)):
        errors = local_errors(*with_elements(1.0), {c: with_elements(c) for c in coarse})
        assert errors == pytest.approx(np.broadcast_to(exact, errors.shape))
    mixed = local_errors(*with_elements(1.0), {1.5: with_elements(1.5), 2.0: with_elements(1.0)})
    assert mixed == pytest.approx(0.5 * np.broadcast_to(exact, mixed.shape))


def test_out_of_contact_the_mean_of_the_run_stands_in():
    loads, on = np.zeros((30, 12, 5)), np.zeros((30, 12), dtype=bool)
    on[:, 8:] = True
    errors = local_errors(loads, on, {2.0: (loads[:20] + 2.0, on[:20])})
    assert errors == pytest.approx(np.broadcast_to(np.array(FACTORS) * 2.0, errors.shape))
    nothing = local_errors(loads, ~on & False, {2.0: (loads, on)})
    assert (nothing == 0.0).all() and summary(loads, ~on & False, nothing) == []


def test_a_run_states_none_unless_it_is_asked(monkeypatch):
    """And where the further runs stop, it says so."""
    process = RingCompression(mesh_size=0.4, n_points=30)
    monkeypatch.setattr(
        "forming.fe.simulation.Simulation.advance_to",
        stopping_where(lambda simulation: len(simulation.state.body.x) < 26),
    )
    assert process.run(0.1, 0.5).contact.errors is None
    assert (process.run(0.1, 0.5, with_errors=True).contact.errors[-1].max(axis=0) > 0.0).all()
    for coarser, reason in (((1e3,), "a reason of the test"), ((-1.0,), "cannot be meshed")):
        monkeypatch.setattr(base, "COARSER", coarser)
        result = process.run(0.1, 0.5, with_errors=True)
        assert result.status == "ok" and result.contact.errors is None
        assert "errors of the loads are not known" in result.warnings[-1] and reason in result.warnings[-1]


def stopping_where(is_coarse):
    """Return `Simulation.advance_to`, except that a run on a coarse mesh stops at once."""
    from forming.fe.simulation import Simulation

    honest = Simulation.advance_to

    def advance_to(self, *args):
        if is_coarse(self):
            self._stop("a reason of the test")
            return False
        return honest(self, *args)

    return advance_to
