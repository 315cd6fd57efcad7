"""Mean residuals in a range of a load: every test is one witness, however long it stays there."""

from __future__ import annotations

import numpy as np

from friction_models.discovery.answer.summaries import clustered_mean


def test_a_long_ramp_is_one_test_of_many() -> None:
    """One ramp of 480 points beside 18 tests that pass: the interval of nothing but chance holds zero in 95 of 100 draws."""
    rng = np.random.default_rng(2)
    held = 0
    for _ in range(400):
        size = np.r_[480, rng.integers(1, 3, 18)]
        test = np.repeat(np.arange(19), size)
        residual = rng.normal(0.0, 0.004, 19)[test] + rng.normal(0.0, 0.001, len(test))
        mean, half, tests = clustered_mean(residual, np.ones(len(test)), test, np.ones(len(test), dtype=bool))
        held += abs(mean) < half
        assert tests == 19
    assert 0.92 < held / 400 < 0.98, held
