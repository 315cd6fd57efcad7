"""An offset of the force stands beside physics only where it is small against what was measured."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.discovery_campaigns import campaign
from friction_models.discovery import Diagnosis, diagnose
from friction_models.discovery.judge.doubts import MOSTLY

CATALOGUE = ("thermal_softening", "pressure_saturation", "force_zero", "stribeck")
#: Lowest pressure of the tests, MPa.
LEAST = 150.0


def _tests(rng: np.random.Generator) -> pd.DataFrame:
    """Return loads of 40 tests of 20 mm, with pressures over a decade."""
    frames = []
    sd = np.linspace(0.1, 20.0, 24)
    for k in range(40):
        v = np.exp(rng.uniform(np.log(5.0), np.log(300.0)))
        sigma_n = LEAST * 10.0 ** rng.uniform(0.0, 1.0) * (1.0 + 0.003 * sd)
        T = rng.uniform(20.0, 250.0) + 2.0 * np.sqrt(sd)
        loads = {"t": sd / v, "v_rel": v, "T": T, "sigma_n": sigma_n, "sd": sd, "psi": 1.0}
        frames.append(pd.DataFrame({"test_id": f"t{k}", **loads}))
    return pd.concat(frames, ignore_index=True)


def _diagnosed(along_pressure: str) -> Diagnosis:
    """Diagnose friction that falls with the temperature, and depends on the pressure as well."""
    rng = np.random.default_rng(4)
    data = _tests(rng)
    level = dict(zip(data["test_id"].unique(), rng.normal(0.0, 0.002, 40), strict=True))
    mu = 0.09 + 0.09 / (1.0 + (data["T"] / 70.0) ** 2) + data["test_id"].map(level)
    if along_pressure == "arch":
        mu = mu - 0.08 * (np.log10(data["sigma_n"] / LEAST) - 0.6) ** 2
    else:
        mu = mu - 0.02 * LEAST / data["sigma_n"]
    return diagnose(data.assign(mu=mu + rng.normal(0.0, 0.001, len(data))), catalogue=CATALOGUE)


def test_an_arch_over_the_pressure_is_no_offset_of_a_cell() -> None:
    """Nor is it a saturation, which a steep line would have to bend down again."""
    found = _diagnosed("arch")
    assert found.effects == ["thermal_softening"] and found.verdict == "partly_explained", found.sentence
    assert found.where[0]["variables"] == ["sigma_n"]


def test_an_offset_beside_physics_is_to_be_read_first() -> None:
    found = _diagnosed("offset")
    assert found.effects == ["thermal_softening", "force_zero"] and found.confidence <= MOSTLY
    assert "only a reading without load" in found.sentence
    assert found.next_tests[0]["protocol"] == "zero reading"
    assert any(w.startswith("force_zero makes up to 0.02 of mu, and 2") for w in found.warnings)


def _two_lots(share: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return 32 averages of two lots, one measured after the other, whose friction differs by a share of it."""
    rng = np.random.default_rng(11)
    speeds = np.tile([75.0, 150.0, 225.0, 300.0], 8)
    pressures = np.tile(np.repeat([0.1, 0.3], 4), 4)
    lots = np.repeat(["first", "second"], 16)
    mu = 0.16 * np.where(lots == "first", 1.0, 1.0 - share) + 0.0002 * speeds - 0.1 * pressures
    names = [f"t{k:02d}" for k in range(32)]
    data = pd.DataFrame({"test_id": names, "v_rel": speeds, "sigma_n": pressures, "mu": mu})
    data["mu"] += rng.normal(0.0, 0.008, 32) - 0.0011 * np.arange(32)
    return data, pd.DataFrame({"test_id": names, "lot": lots, "order": np.arange(1, 33)})


def test_a_drift_too_large_for_a_sensor_does_not_lead_what_changed_in_the_order_of_the_tests() -> None:
    found = diagnose(*_two_lots(0.12))
    assert found.effects == ["factor:lot"] and "sensor_drift" in found.confusion_set, found.sentence
    assert found.verdict == "ambiguous" and found.confidence <= MOSTLY


@pytest.mark.nightly
def test_a_drift_too_large_for_a_sensor_takes_no_name_from_what_is_along_the_distance() -> None:
    """It was most of what could be predicted beyond running-in: "unknown" at 0.98, "along order; sd"."""
    data, tests, _ = campaign("running_in+sensor_drift", seed=11, strength=1.5, extra=0, thin=8)
    found = diagnose(data, tests)
    assert (found.verdict, found.effects) == ("partly_explained", ["running_in"]), found.sentence
    assert found.where[0]["variables"] == ["order"]


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.nightly)])
def test_a_cell_that_reads_too_little_is_named_though_a_breakdown_draws_the_same(seed: int) -> None:
    """Its rival, a breakdown by temperature and pressure, takes its place and is no answer: it was "no effect of the catalogue"."""
    rng = np.random.default_rng(seed)
    plan = rng.permutation(
        [(p, v, T) for p in (100.0, 245.0, 600.0) for v in (2.0, 13.0, 80.0) for T in (20.0, 100.0, 180.0)]
    )
    along, parts = np.linspace(0.0, 1.0, 25), []
    for k, (p, v, T) in enumerate(plan):
        pressure, warm = p * (1.0 + 0.05 * along), T + 30.0 * (p / 600.0) * (v / 80.0) * np.sqrt(along)
        mu = 0.1 + 1e-4 * warm - 4.0 / pressure + 0.002 * rng.normal() + 0.002 * rng.normal(size=25)
        parts.append(
            pd.DataFrame(
                {"test_id": f"t{k:02d}", "t": 30.0 * along / v, "sd": 30.0 * along, "v_rel": v, "T": warm, "sigma_n": pressure, "mu": mu}
            )
        )  # fmt: skip
    found = diagnose(pd.concat(parts, ignore_index=True))
    assert found.verdict == "data_problem" and found.effects == ["force_zero"], found.sentence
