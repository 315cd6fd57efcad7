"""What comes and goes in the order of the tests, and nobody recorded: a hall that warms up each day, a bath that is topped up."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.judge.doubts import LIKELY

TESTS = 60
SCATTER = 0.003


def bath(seed: int, change: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Friction rises while the lubricant ages, and falls when it is replaced after each 20 tests; random loads, one mean a test."""
    rng = np.random.default_rng(seed)
    names = [f"t{k:02d}" for k in rng.permutation(TESTS)]
    order = np.arange(TESTS)
    data = pd.DataFrame(
        {
            "test_id": names,
            "v_rel": rng.uniform(5.0, 60.0, TESTS),
            "T": rng.uniform(30.0, 250.0, TESTS),
            "sigma_n": rng.uniform(100.0, 900.0, TESTS),
        }
    )
    aged = order % 20 / 19.0 - 0.5
    mu = 0.1 + 1e-5 * data["sigma_n"] + change * aged
    return data.assign(mu=mu + rng.normal(0.0, SCATTER, TESTS)), pd.DataFrame(
        {"test_id": names, "order": order + 1}
    )


@pytest.mark.parametrize("seed", range(3))
def test_what_returns_several_times_is_seen_along_the_order(seed: int) -> None:
    found = diagnose(*bath(seed, 0.03))
    assert found.verdict == "unknown_structure" and not found.effects, found.sentence
    assert found.where[0]["variables"] == ["order"]
    assert found.error_budget["missing"] > found.error_budget["floor"]


def test_an_order_that_says_nothing_changes_nothing() -> None:
    data, tests = bath(5, 0.0)
    found = diagnose(data, tests)
    assert found.verdict == "nothing_missing"
    assert found.confidence == pytest.approx(diagnose(data).confidence, abs=0.02)


@pytest.mark.nightly
def test_what_comes_and_goes_within_a_few_tests_is_told() -> None:
    """No curve follows four days of ten tests each, as rooms warm up; neighbours are alike all the same."""
    told = 0
    for seed in range(4):
        data, tests = bath(seed, 0.0)
        day = tests["order"].to_numpy() % 10 / 10.0
        found = diagnose(data.assign(mu=data["mu"] + 0.012 * np.sin(2.0 * np.pi * day)), tests)
        said = any("alike in the tests run before and after" in w for w in found.warnings)
        assert said or "order" in found.where[0]["variables"], found.sentence
        assert found.verdict == "unknown_structure" or found.confidence <= LIKELY
        told += said
        plain = diagnose(data, tests)
        assert not any("alike in the tests run before and after" in w for w in plain.warnings)
    assert told
