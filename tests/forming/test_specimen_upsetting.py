"""The upsetting of the sliding compression test: cup, tip, force history, bad input."""

from __future__ import annotations

import numpy as np
import pytest

from forming.processes.specimen_upsetting import upset
from forming.tools.punch_geometry import PunchGeometry
from friction_models.common import InputError


@pytest.fixture(scope="module")
def cup():
    return upset(PunchGeometry(bore_diameter=15.5), 519e3)


def test_a_cup_of_15_5_mm_gives_the_plan_pressures(cup):
    """94 / 330 / 519 kN stand for 500 / 1750 / 2750 MPa at psi = 1.069."""
    levels = cup.at_force([94e3, 330e3, 519e3])
    assert cup.status == "ok"
    assert levels.sigma_n_mean == pytest.approx([500.0, 1750.0, 2750.0], rel=0.03)
    assert levels.area_ratio == pytest.approx(1.069, abs=0.03)
    assert levels.psi_mean == pytest.approx(1.06, abs=0.025)


def test_the_profiles_carry_the_force(cup):
    r = cup.r[-1]
    carried = np.trapezoid(cup.sigma_n[-1] * 2.0 * np.pi * r, r)
    assert carried == pytest.approx(519e3, rel=0.02)
    assert cup.force[-1] == 519e3
    assert (np.diff(cup.force) > 0).all() and (np.diff(cup.height) <= 0).all()


def test_the_contact_stays_when_the_force_falls(cup):
    history = cup.at_force([94e3, 519e3, 200e3], [0.0, 1.0, 2.0])
    assert history.time.tolist() == [0.0, 1.0, 2.0]
    assert history.psi[2] == pytest.approx(history.psi[1])
    assert history.sigma_n_mean[2] == pytest.approx(history.sigma_n_mean[1] * 200.0 / 519.0)


def test_a_small_first_contact_multiplies_the_area_not_the_local_expansion():
    result = upset(PunchGeometry(bore_diameter=15.5, tip_diameter=6.93), ([0.0, 1.0], [0.0, 400e3]))
    assert result.status == "ok"
    assert result.time.tolist() == [0.0, 1.0]
    assert result.area_ratio[0] == 1.0 and result.psi_mean[0] == 1.0
    assert result.area_ratio[1] > 4.0
    assert 1.0 < result.psi_mean[1] < 2.0


def test_friction_may_depend_on_the_loads():
    def law(loads, t):
        assert loads.shape[1] == 5 and t >= 0.0
        return 0.05 + 1e-4 * loads[:, 2]

    low, high = upset(None, 150e3, mu=0.0, mesh_size=1.5), upset(None, 150e3, mu=law, mesh_size=1.5)
    assert high.area_ratio[-1] < low.area_ratio[-1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"force": -5.0}, ["= -5 N", "1e3"]),
        ({"force": ([0.0, 1.0], [1e5])}, ["2 instants", "1 forces"]),
        ({"speed": 0.0}, ["speed = 0.0"]),
        ({"mesh_size": 9.0}, ["mesh_size = 9.0"]),
        ({"mu": float("nan")}, ["mu = nan", "marker 0"]),
        ({"mu": lambda loads, t: np.full(len(loads), -0.1)}, ["mu = -0.1"]),
        ({"mu": lambda loads, t: np.zeros(3)}, ["shape (3,)"]),
    ],
)
def test_bad_input_is_one_sentence(arguments, words):
    with pytest.raises(InputError) as caught:
        upset(PunchGeometry(), **{"force": 1e5, **arguments})
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize(
    "wrong",
    [{"bore_diameter": 14.0}, {"tip_diameter": 15.0}, {"specimen_diameter": -1.0}, {"tip_height": 9.0}],
)
def test_impossible_geometry_is_refused(wrong):
    with pytest.raises(InputError, match=f"{next(iter(wrong))} = "):
        PunchGeometry(**wrong)


def test_the_default_height_of_a_tip_counts_only_with_a_tip():
    assert PunchGeometry(specimen_height=5.0).outline()[:, 1].max() == 5.0
    with pytest.raises(InputError, match=r"tip_height = 2\.5 mm; allowed: below half"):
        PunchGeometry(specimen_height=5.0, tip_diameter=6.0)


def test_what_was_computed_is_kept_when_the_force_cannot_be_reached():
    result = upset(PunchGeometry(specimen_diameter=10.0, specimen_height=6.0), 9e6, mu=0.1, mesh_size=1.2)
    assert result.status == "stopped" and "stopped" in result.message
    assert len(result.force) > 10 and result.force[-1] > 1e5
