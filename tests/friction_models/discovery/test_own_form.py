"""What a model could do itself, though no fit of it does (other offsets, a bend where trees have steps), is no sure effect, and it is said why."""

from __future__ import annotations

from copy import copy

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction, PowerLawFriction, TriboLoads
from friction_models.discovery import Diagnosis, diagnose
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.base_law import base_law
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


def other_offsets(found: Diagnosis) -> bool:
    """Whether an answer says that other offsets do as well."""
    return any("another v_offset, another sigma_offset and another sd_offset" in w for w in found.warnings)


def test_what_other_offsets_do_as_well_is_not_sure() -> None:
    found = diagnose(powers(6), model="power_law")
    assert found.effects and found.confidence <= 0.5 and other_offsets(found)


def test_what_no_offset_does_keeps_its_name_and_its_confidence() -> None:
    found = diagnose(powers(0, worn=0.02), model="power_law")
    assert (found.effects, other_offsets(found)) == (["wear_out"], False)
    assert found.confidence > 0.9


def test_a_model_without_such_constants_is_not_asked_for_them() -> None:
    campaign = prepare(powers(6))
    assert not base_law(LinearFriction(), campaign).beside and base_law(PowerLawFriction(), campaign).beside


def limited(seed: int) -> pd.DataFrame:
    """Return 30 tests of powers of pressure and speed whose shear stress tends to 9 MPa, so that mu falls faster than any power of ours."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 1.0, 40)
    frames = []
    for k in range(30):
        speed = 10.0 ** rng.uniform(0.7, 2.7)
        pressure = rng.choice([20.0, 50.0, 100.0, 200.0, 350.0]) * (1.0 + 0.04 * np.sin(4.0 * x + k))
        heat, sd = rng.choice([20.0, 50.0, 90.0, 130.0]) + 8.0 * x, rng.uniform(40.0, 200.0) * x
        mu = 0.09 * ((pressure + 36.0) / 120.0) ** -0.18 * ((speed + 21.0) / 70.0) ** -0.08
        stress = 9.0 * (1.0 - np.exp(-mu * pressure / 9.0))
        mu = stress / pressure * np.exp(rng.normal(0.0, 0.02)) * (1.0 + rng.normal(0.0, 0.01, 40))
        loads = {"v_rel": speed, "T": heat, "sigma_n": pressure, "sd": sd}
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu}))
    return pd.concat(frames)


def test_something_missing_that_other_offsets_explain_is_not_sure() -> None:
    """It was 0.88 sure that no effect of the catalogue fits; pressure saturation does, beside the offsets of the truth."""
    found = diagnose(limited(4), model="power_law")
    assert found.verdict == "unknown_structure" and found.confidence <= 0.5, found.sentence
    assert any("another sigma_offset" in w and "no fit of the model does" in w for w in found.warnings)


def test_something_missing_that_no_offset_explains_stays_sure() -> None:
    data = powers(0)
    data["mu"] += 0.02 * np.exp(-(((data["T"] - 105.0) / 22.0) ** 2))
    found = diagnose(data, model="power_law")
    assert found.verdict == "unknown_structure" and found.confidence > 0.75, found.sentence
    assert not any("no fit of the model does" in w for w in found.warnings)


@pytest.mark.parametrize("name", ["v_offset", "sigma_offset", "sd_offset"])
def test_the_columns_are_those_of_small_changes_of_the_constants(name: str) -> None:
    """With exponents that are held, mu of another offset differs by the column times the exponent."""
    data = powers(1)
    loads = TriboLoads.from_frame(data)
    model = PowerLawFriction().fit(loads, data["mu"])
    points = MeasuredPoints(
        loads, model.predict(loads), [], np.zeros(len(data), dtype=np.intp), lambda *_: []
    )
    column = next(b.column for b in model.tangent(points).beside if b.name == f"another {name}")
    exponent = float(model.coef_[{"v_offset": 1, "sigma_offset": 3, "sd_offset": 4}[name]])
    step = 1e-3
    changed = copy(model)
    if name == "sigma_offset":
        changed.sigma_offset_ = model.sigma_offset_ + step
    else:
        setattr(changed, name, getattr(model, name) + step)
    slope = (changed.predict(loads) - model.predict(loads)) / step
    np.testing.assert_allclose(slope, exponent * column, rtol=1e-3, atol=1e-12)


def warm(seed: int) -> pd.DataFrame:
    """Return 40 tests whose friction grows by e over 250 degC, and depends on nothing else; trees follow it in steps."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 1.0, 60)
    frames = []
    for k in range(40):
        speed, tool = (
            rng.choice([5.0, 10.0, 20.0, 50.0, 100.0, 200.0]),
            rng.choice([20.0, 80.0, 150.0, 220.0]),
        )
        pressure, heat = rng.choice([400.0, 700.0, 1000.0, 1400.0]), tool + 20.0 * x
        mu = 0.1 * np.exp(0.004 * (heat - 120.0)) * np.exp(rng.normal(0.0, 0.03))
        loads = {
            "t": 20.0 * x / speed,
            "v_rel": speed,
            "T": heat,
            "sigma_n": pressure,
            "sd": 20.0 * x,
            "psi": 1.0 + x,
        }
        frames.append(
            pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu * (1.0 + rng.normal(0.0, 0.015, 60))})
        )
    return pd.concat(frames)


@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.nightly) for k in (0, 2, 3))])
def test_an_effect_that_a_bend_in_the_place_of_steps_is_worth_is_not_sure(seed: int) -> None:
    found = diagnose(warm(seed), model="gradient_boosting")
    assert found.verdict == "nothing_missing" or found.confidence <= 0.5, found.sentence
    assert not found.effects or any("a bend along T" in w for w in found.warnings), found.warnings
