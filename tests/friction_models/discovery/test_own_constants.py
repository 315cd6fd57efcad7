"""A power law without the offsets that ours has lacks nothing but these: what is named then is not sure, and it is said why."""

from __future__ import annotations

from copy import copy

import numpy as np
import pandas as pd
import pytest

from friction_models import PowerLawFriction, TriboLoads
from friction_models.discovery import Diagnosis, diagnose
from friction_models.models.tangent import MeasuredPoints


def powers(seed: int, worn: float = 0.0) -> pd.DataFrame:
    """Return 24 tests of powers of pressure and speed; their friction rises over the sliding distance by `worn`."""
    rng = np.random.default_rng(seed)
    sd = np.linspace(0.0, 48.0, 40)
    frames = []
    strata = [(rng.permutation(24) + rng.random(24)) / 24 for _ in range(3)]
    for k, (a, b, c) in enumerate(zip(*strata, strict=True)):
        pressure = 320.0 * 4.2**a * (1.0 + 0.02 * rng.standard_normal(40))
        speed = 3.0 * 25.0**b * (1.0 + 0.05 * np.sin(sd / 6.0 + k))
        mu = 0.09 * (pressure / 700.0) ** -0.22 * (speed / 20.0) ** -0.06 + worn * (sd / 48.0) ** 2
        mu += rng.normal(0.0, 0.0017) + rng.normal(0.0, 0.0005, 40)
        heat = 30.0 + 150.0 * c + 0.1 * sd
        frames.append(
            pd.DataFrame(
                {"test_id": f"t{k:02d}", "v_rel": speed, "T": heat, "sigma_n": pressure, "sd": sd, "mu": mu}
            )
        )
    return pd.concat(frames)


def other_constants(found: Diagnosis) -> bool:
    """Whether an answer says that other offsets do as well."""
    return any("v_offset, sigma_offset and sd_offset" in w for w in found.warnings)


def test_what_other_offsets_do_as_well_is_not_sure() -> None:
    found = diagnose(powers(6), model="power_law")
    assert found.effects and found.confidence <= 0.5 and other_constants(found)


def test_what_no_offset_does_keeps_its_name_and_its_confidence() -> None:
    found = diagnose(powers(0, worn=0.02), model="power_law")
    assert (found.effects, other_constants(found)) == (["wear_out"], False)
    assert found.confidence > 0.9


def test_a_model_without_such_constants_is_not_asked_for_them() -> None:
    assert not other_constants(diagnose(powers(6), model="linear"))


@pytest.mark.parametrize("name", ["v_offset", "sigma_offset", "sd_offset"])
def test_the_columns_are_those_of_small_changes_of_the_constants(name: str) -> None:
    """With exponents that are held, mu of another offset differs by the column times the exponent."""
    data = powers(1)
    loads = TriboLoads.from_frame(data)
    model = PowerLawFriction().fit(loads, data["mu"])
    points = MeasuredPoints(
        loads, model.predict(loads), [], np.zeros(len(data), dtype=np.intp), lambda *_: []
    )
    column = model.tangent(points).constants[name]
    exponent = float(model.coef_[{"v_offset": 1, "sigma_offset": 3, "sd_offset": 4}[name]])
    step = 1e-3
    changed = copy(model)
    if name == "sigma_offset":
        changed.sigma_offset_ = model.sigma_offset_ + step
    else:
        setattr(changed, name, getattr(model, name) + step)
    slope = (changed.predict(loads) - model.predict(loads)) / step
    np.testing.assert_allclose(slope, exponent * column, rtol=1e-3, atol=1e-12)
