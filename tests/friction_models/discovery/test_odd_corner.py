"""Tests that lie far off together, in one corner of the loads, may show a law: nobody is told for sure that nothing is missing."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import qmc

from friction_models.discovery import diagnose
from friction_models.discovery.judge.doubts import LIKELY


def averages(seed: int, off: int, *, together: bool) -> pd.DataFrame:
    """Return 50 random tests, some of which lie 0.04 above the others: the fastest and hottest, or any."""
    rng = np.random.default_rng(seed)
    v, T, p = qmc.LatinHypercube(3, rng=rng).random(50).T
    deep = np.argsort(-np.minimum(v, T)) if together else rng.permutation(50)
    mu = 0.1 + 0.02 * T + rng.normal(0.0, 0.002, 50)
    mu[deep[:off]] += 0.04
    names = [f"t{k:02d}" for k in range(50)]
    return pd.DataFrame(
        {"test_id": names, "v_rel": 2.0 + 98.0 * v, "T": 20.0 + 180.0 * T, "sigma_n": 100.0 + 400.0 * p, "mu": mu}
    )  # fmt: skip


@pytest.mark.parametrize("seed", [1, pytest.param(4, marks=pytest.mark.nightly)])
def test_tests_that_were_left_out_of_one_corner_are_no_proof_that_nothing_is_missing(seed: int) -> None:
    """It was "nothing missing", 0.94 to 0.98 sure."""
    found = diagnose(averages(seed, 3, together=True))
    assert found.verdict != "nothing_missing" or found.confidence <= LIKELY, found.sentence
    assert any("lie to one side at high v_rel and high T" in w for w in found.warnings), found.warnings


def test_tests_that_lie_off_here_and_there_are_faults() -> None:
    found = [diagnose(averages(seed, 3, together=False)) for seed in range(3, 6)]
    assert sum(f.verdict == "nothing_missing" and f.confidence > 0.85 for f in found) >= 2
    assert all(any("were left out" in w for w in f.warnings) for f in found)
