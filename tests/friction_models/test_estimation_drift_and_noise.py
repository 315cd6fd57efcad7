"""Drift and noise of all tests at once, against the matrices of each test."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag

from friction_models.estimation.noise.drift_and_noise import DriftAndNoise
from friction_models.loads import FloatArray

#: Bins of three tests: two of them at one place, one alone.
PLACES = [[0.0, 0.1, 0.1, 0.5, 2.0], [0.0], [0.0, 1e-4, 0.7, 30.0]]


def correlation(length: float) -> FloatArray:
    tests = [np.exp(-np.abs(np.subtract.outer(s, s)) / length) for s in PLACES]
    return np.asarray(block_diag(*tests))


@pytest.mark.parametrize("drift", [0.0, 0.02, 1.0, 20.0])
@pytest.mark.parametrize("length", [0.05, 1.0, 50.0])
def test_it_is_the_covariance_of_each_test(drift: float, length: float) -> None:
    rng = np.random.default_rng(4)
    steps = np.concatenate([np.r_[np.diff(s), np.inf] for s in PLACES])[:-1] / length
    white, values = rng.uniform(0.1, 1.0, len(steps) + 1), rng.normal(size=(len(steps) + 1, 3))
    found = DriftAndNoise(steps, drift, white)
    P = correlation(length)
    S = np.diag(white) + drift**2 * P
    by_length = (correlation(length * np.exp(1e-5)) - correlation(length * np.exp(-1e-5))) / 2e-5
    # two bins at one place are taken as a little apart
    close = {"rtol": 1e-3, "atol": 1e-4}
    np.testing.assert_allclose(found.solve(values), np.linalg.solve(S, values), **close)
    np.testing.assert_allclose(found.inverse_diagonal, np.diag(np.linalg.inv(S)), **close)
    np.testing.assert_allclose(found.log_det, np.linalg.slogdet(S)[1], **close)
    np.testing.assert_allclose(found.correlated(values), P @ values, **close)
    changed = found.correlated(found.changed(found.correlated(values)))
    np.testing.assert_allclose(changed, by_length @ values, **close)
    trace = np.trace(np.linalg.solve(S, drift**2 * by_length))
    np.testing.assert_allclose(found.trace_of_change(), trace, **close)


def test_one_bin_has_no_neighbour() -> None:
    found = DriftAndNoise(np.zeros(0), 1.0, np.full(1, 3.0))
    assert found.solve(np.full((1, 1), 8.0)).item() == pytest.approx(2.0)
    assert found.trace_of_change() == 0.0 and found.log_det == pytest.approx(np.log(4.0))
