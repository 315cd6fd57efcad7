"""Noise in measured loads: smooth courses come back, sudden ones stay, and answers do not change with it."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose, refine
from friction_models.estimation.campaign.load_noise import without_noise
from friction_models.families.composed import ComposedFriction
from friction_models.loads import FloatArray, TriboLoads

POINTS = 60
PLACE = np.linspace(0.0, 1.0, POINTS)


def _cleaned(speed: FloatArray, pressure: FloatArray) -> TriboLoads:
    """Return loads of two tests, one of them at half of these loads, without noise."""
    v, p = (np.concatenate([x, 0.5 * x]) for x in (speed, pressure))
    n = len(v)
    loads = TriboLoads(v_rel=v, T=np.full(n, 50.0), sigma_n=p, sd=np.ones(n), psi=np.ones(n))
    return without_noise(loads, np.array([0, n // 2]))


@pytest.mark.parametrize(
    "course", [np.full(POINTS, 600.0), 400.0 + 300.0 * PLACE, 300.0 + 400.0 * np.sqrt(PLACE)]
)
def test_a_smooth_course_comes_back(course: FloatArray) -> None:
    rng = np.random.default_rng(3)
    read = course * (1.0 + 0.03 * rng.standard_normal(POINTS))
    found = _cleaned(np.full(POINTS, 10.0), read).sigma_n[:POINTS]
    assert np.std(found - course) < 0.4 * np.std(read - course)


@pytest.mark.parametrize(
    "speed",
    [
        np.where(PLACE < 0.4, 5.0, 200.0),
        100.0 * np.abs(np.sin(20.0 * PLACE)) + 1.0,
        10.0 + 90.0 * np.maximum(PLACE - 0.7, 0.0) ** 0.5,
    ],
    ids=["step", "strokes", "late ramp"],
)
def test_sudden_courses_and_exact_ones_stay(speed: FloatArray) -> None:
    pressure = 300.0 + 50.0 * PLACE**3
    found = _cleaned(speed, pressure)
    np.testing.assert_array_equal(found.v_rel[:POINTS], speed)
    np.testing.assert_array_equal(found.sigma_n[:POINTS], pressure)


def test_noise_of_a_step_leaves_the_step() -> None:
    rng = np.random.default_rng(4)
    step = np.where(PLACE < 0.5, 20.0, 200.0)
    found = _cleaned(step * (1.0 + 0.02 * rng.standard_normal(POINTS)), np.full(POINTS, 300.0))
    assert np.max(np.abs(found.v_rel[:POINTS] - step)) < 0.1 * 200.0


def test_what_may_be_a_load_is_not_taken_for_noise() -> None:
    """All that this pressure does lies within the tests: it may well have changed so fast."""
    read = 500.0 + 40.0 * np.random.default_rng(5).standard_normal(POINTS)
    loads = TriboLoads(
        v_rel=np.full(POINTS, 9.0),
        T=np.full(POINTS, 50.0),
        sigma_n=read,
        sd=np.ones(POINTS),
        psi=np.ones(POINTS),
    )
    np.testing.assert_array_equal(without_noise(loads, np.array([0])).sigma_n, read)


def records(seed: int, noise: float) -> pd.DataFrame:
    """Return records of a law that is linear in what the loads truly were; they are read with noise of a share of them."""
    rng = np.random.default_rng(seed)
    x, tests = np.linspace(0.02, 1.0, 40), []
    for i in range(50):
        speed, pressure, start = (
            np.exp(rng.uniform(1.0, 6.0)),
            rng.uniform(300.0, 1500.0),
            rng.uniform(20.0, 250.0),
        )
        v, p, T = speed * (1.0 - 0.3 * x), pressure * (1.0 + 0.4 * x), start + 60.0 * np.sqrt(x)
        mu = 0.12 - 2e-5 * p - 1e-4 * T + 0.003 * rng.standard_normal() + 0.0015 * rng.standard_normal(40)
        v, p, T = (load * (1.0 + noise * rng.standard_normal(40)) for load in (v, p, T))
        loads = {"v_rel": v, "T": T, "sigma_n": p, "sd": 30.0 * x, "psi": 1.0 + x}
        tests.append(pd.DataFrame({"test_id": f"t{i:02d}", "t": 30.0 * x / speed, **loads, "mu": mu}))
    return pd.concat(tests, ignore_index=True)


@pytest.mark.parametrize("seed", [0, 1])
def test_noise_of_the_loads_is_no_missing_effect(seed: int) -> None:
    """Slopes along the tests come out flat where loads are noisy, and levels of tests contradict them: it was `unknown_structure`."""
    found = diagnose(records(seed, 0.04))
    assert found.verdict == "nothing_missing", found.sentence


def test_a_refit_fills_metadata_beside_noisy_loads_too() -> None:
    """One test of 50 has no oil: the usual one stands for it, in a refit that adds nothing as in one that does."""
    data = records(0, 0.02)
    tests = pd.DataFrame({"test_id": data["test_id"].unique()})
    tests["oil"] = [None if i == 7 else "AB"[i % 2] for i in range(len(tests))]
    model = refine(data, tests, add="factor:oil", force=True)
    assert isinstance(refine(data, tests, model), ComposedFriction)
