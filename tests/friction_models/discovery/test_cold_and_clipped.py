"""What hides from those who only test warm steel: rubber that is cold, and amplifiers that read no further."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import Diagnosis, diagnose
from friction_models.effects import make_effect
from friction_models.families.stored_parameters import stored_shapes


def averages(seed: int, tests: int = 36) -> pd.DataFrame:
    """Return short tests at random loads of rubber: 0 to 60 degC, below 1 MPa."""
    rng = np.random.default_rng([seed, 60])
    names, sd = [f"t{k:02d}" for k in range(tests)], np.linspace(1.0, 100.0, 12)
    loads = {
        "v_rel": np.repeat(10.0 ** rng.uniform(-0.3, 1.7, tests), 12),
        "T": np.repeat(rng.uniform(0.0, 60.0, tests), 12),
        "sigma_n": np.repeat(10.0 ** rng.uniform(-1.3, -0.1, tests), 12),
        "sd": np.tile(sd, tests),
    }
    scatter = np.repeat(rng.normal(0.0, 0.02, tests), 12) + rng.normal(0.0, 0.004, 12 * tests)
    points = pd.DataFrame({"test_id": np.repeat(names, 12), **loads, "psi": 1.0, "mu": 0.8 + scatter})
    return points.assign(t=points["sd"] / points["v_rel"])


@pytest.mark.parametrize("seed", range(2))
def test_a_film_that_softens_far_above_room_temperature(seed: int) -> None:
    """A fall by half around 650 degC, between 350 and 950: "unknown" before, as the formula began at 20 degC."""
    rng = np.random.default_rng([seed, 61])
    names = [f"t{k:02d}" for k in range(60)]
    T, v = rng.uniform(350.0, 950.0, 60), np.exp(rng.uniform(0.0, 4.0, 60))
    mu = 0.2 - 0.1 * np.tanh((T - 650.0) / 130.0) + rng.normal(0.0, 0.015, 60)
    points = pd.DataFrame(
        {"test_id": names, "v_rel": v, "T": T, "sigma_n": rng.uniform(50.0, 400.0, 60), "mu": mu}
    )
    found = diagnose(points)
    assert found.effects == ["thermal_softening"], found.sentence
    assert found.parameters["thermal_softening"]["values"]["T_0"]["value"] == pytest.approx(T.min())


@pytest.mark.parametrize("warmer", [0.0, 30.0])
def test_a_film_softens_below_room_temperature_as_above(warmer: float) -> None:
    """A hyperbola, no formula of the catalogue; where the zero of the scale lies is a matter of who made it."""
    data = averages(3)
    data["mu"] += 0.35 / (1.0 + data["T"] / 10.0)
    found = diagnose(data.assign(T=data["T"] + warmer))
    assert found.effects == ["thermal_softening"], found.sentence
    from_which = found.parameters["thermal_softening"]["values"]["T_0"]["value"]
    assert from_which == pytest.approx(min(20.0, data["T"].min() + warmer))


def test_models_of_earlier_versions_soften_from_20_degrees_on() -> None:
    """Their files do not say from which temperature on."""
    effect = make_effect("thermal_softening")
    assert effect.at(T=[-30.0, 20.0]).ravel().tolist() == [1.0, 1.0]
    assert stored_shapes(effect, {"T_s": 50.0, "n": 1.0})["T_0"] == 20.0


def clipped(seed: int, at: float) -> Diagnosis:
    """Diagnose a fall with speed of which an amplifier shows no more than `at`."""
    data = averages(seed)
    fall = 0.12 * np.exp(-((data["v_rel"] / 3.0) ** 0.7))
    return diagnose(data.assign(mu=np.minimum(data["mu"] + fall, at)))


def test_nothing_is_sure_to_be_missing_where_most_readings_were_clipped() -> None:
    found = clipped(2, 0.8)
    assert found.verdict == "nothing_missing" and found.confidence <= 0.5, found.sentence
    assert any("clipped?" in w for w in found.warnings)


@pytest.mark.parametrize(("size", "most"), [(0.15, 0.5), (1.2, 1.0)])
def test_a_name_in_noise_that_is_more_than_half_of_mu_is_sure_only_if_it_is_larger(
    size: float, most: float
) -> None:
    data = averages(4)
    names, offsets = data["test_id"].unique(), np.random.default_rng(5).uniform(0.0, 0.5, 36)
    running_in = size * np.exp(-data["sd"] / 3.0)
    offset = data["test_id"].map(dict(zip(names, offsets, strict=True)))
    mu = 0.1 * data["mu"] + running_in + offset - 0.05
    found = diagnose(data.assign(mu=mu))
    assert found.effects == ["running_in"] and most - 0.4 < found.confidence <= most, found.sentence
    total = found.noise_floor["total"]
    told = any(f"noise floor ({total:.3g}) is more than half of mu" in w for w in found.warnings)
    assert told == (total > 0.5 * mu.mean()), found.warnings
