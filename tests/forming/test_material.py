"""Flow curve of Hensel and Spittel: published spot values, both readings, bad input."""

from __future__ import annotations

import numpy as np
import pytest

from forming.fe.element import flow_stress
from forming.materials.materials import HenselSpittel, steel_16MnCr5
from friction_models.common import InputError


@pytest.mark.parametrize(
    ("strain", "T", "rate", "expected"),
    [
        (0.0667, 20.0, 1.0, 504.6),
        (0.1, 20.0, 1.0, 525.9),
        (0.5, 20.0, 1.0, 620.8),
        (1.0, 20.0, 1.0, 666.9),
        (2.0, 20.0, 1.0, 716.4),
        (1.0, 20.0, 10.0, 707.0),
        (1.0, 20.0, 0.01, 593.3),
        (1.0, 200.0, 1.0, 578.6),
        (1.0, 300.0, 1.0, 534.7),
    ],
)
def test_spot_values(strain, T, rate, expected):
    steel = steel_16MnCr5()
    # The smooth floors of strain and rate change the sparsest points by 0.01 %.
    assert steel.flow_stress(strain, T, rate) == pytest.approx(expected, rel=3e-4)
    assert flow_stress(strain, rate, T, steel.vector())[0] == pytest.approx(
        float(steel.flow_stress(strain, T, rate)), rel=1e-12
    )


def test_the_two_readings_differ_as_documented():
    a, b = steel_16MnCr5(), steel_16MnCr5("rate_temperature")
    assert b.flow_stress(1.0, 20.0, 10.0) / a.flow_stress(1.0, 20.0, 10.0) == pytest.approx(1.004, abs=2e-3)
    assert b.flow_stress(1.0, 200.0, 100.0) / a.flow_stress(1.0, 200.0, 100.0) == pytest.approx(
        1.08, abs=5e-3
    )


@pytest.mark.parametrize("form", ["inverse_strain", "rate_temperature"])
def test_slopes_of_the_kernel_are_the_derivatives(form):
    m = steel_16MnCr5(form).vector()
    for strain, rate, T in [(1e-3, 1e-4, 20.0), (0.02, 0.3, 150.0), (1.2, 40.0, 350.0)]:
        y, by_strain, by_rate = flow_stress(strain, rate, T, m)
        h = 1e-6
        up, down = flow_stress(strain * (1 + h), rate, T, m)[0], flow_stress(strain * (1 - h), rate, T, m)[0]
        assert by_strain == pytest.approx((up - down) / (2 * h * strain), rel=1e-4)
        up, down = flow_stress(strain, rate * (1 + h), T, m)[0], flow_stress(strain, rate * (1 - h), T, m)[0]
        assert by_rate == pytest.approx((up - down) / (2 * h * rate), rel=1e-4, abs=1e-6 * y)


def test_flow_stress_is_regular_at_zero():
    values = steel_16MnCr5().flow_stress(np.array([0.0, 1e-9]), 20.0, np.array([0.0, 1e-9]))
    assert np.isfinite(values).all() and (values > 100.0).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"form": "invers_strain"}, ["'invers_strain'", "'inverse_strain'"]),
        ({"A": -1.0}, ["A = -1.0", "> 0"]),
        ({"E": float("nan")}, ["E = nan"]),
        ({"nu": 0.5}, ["nu = 0.5"]),
        ({"taylor_quinney": 1.5}, ["taylor_quinney = 1.5"]),
    ],
)
def test_impossible_materials_are_refused(change, words):
    settings = {"A": 677.0, "m1": -8e-4, "m2": 0.1, "m3": 0.025, "m4": 8e-5}
    with pytest.raises(InputError) as caught:
        HenselSpittel(**{**settings, **change})
    assert all(word in str(caught.value) for word in words), str(caught.value)
