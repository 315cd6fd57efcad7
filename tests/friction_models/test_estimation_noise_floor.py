"""The noise floor against variances that are known, and against other formulas for the same numbers."""

from __future__ import annotations

import numpy as np
import pytest

from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.layout import Layout
from friction_models.estimation.noise.noise_floor import NoiseFloor, Whitener, estimate

from .estimation_cases import measured

FLOOR = NoiseFloor(0.001, 0.004, 0.002, 3.0, (0.0, 0.0), 0.001)


def test_the_parts_of_the_noise_are_found() -> None:
    found = []
    for seed in range(20):
        campaign = prepare(measured(np.random.default_rng([seed, 1]), tests=40, between=0.004, drift=0.002))
        loads = campaign.loads.as_array()[campaign.starts][:, :3]
        mean = np.column_stack([np.ones(len(loads)), loads / loads.std(axis=0)])
        floor = estimate(campaign, Layout.of(campaign), campaign.average(campaign.mu), mean)
        found.append([floor.test, floor.drift, floor.sensor, floor.total, *floor.interval])
    test, drift, sensor, total, low, high = np.array(found).T
    assert np.sqrt(np.mean(test**2)) == pytest.approx(0.004, rel=0.08)
    assert np.sqrt(np.mean(drift**2)) == pytest.approx(0.002, rel=0.15)
    assert np.median(sensor) == pytest.approx(0.001, rel=0.1)
    truth = np.sqrt(0.004**2 + 0.002**2 + 0.001**2)
    assert np.sqrt(np.mean(total**2)) == pytest.approx(truth, rel=0.06)
    assert np.mean((low < truth) & (truth < high)) >= 0.85  # intervals of 95 %, 20 campaigns


def test_balanced_tests_without_drift_give_the_analysis_of_variance() -> None:
    for seed in range(5):
        points = 12
        data = measured(np.random.default_rng([seed, 2]), tests=30, points=points, between=0.004)
        campaign = prepare(data)
        y = campaign.average(campaign.mu)
        floor = estimate(campaign, Layout.of(campaign), y, np.ones((len(y), 1)))
        levels = y.reshape(30, points).mean(axis=1)
        within = np.sum((y.reshape(30, points) - levels[:, None]) ** 2) / (30 * (points - 1))
        between = points * np.var(levels, ddof=1)
        assert floor.test**2 + floor.drift**2 == pytest.approx((between - within) / points, rel=0.02)
        assert floor.bin_sensor == pytest.approx(np.sqrt(within), rel=0.05)


def test_columns_of_the_mean_cost_degrees_of_freedom() -> None:
    """Restricted likelihood: scatter between tests is divided by the tests less the columns of the mean."""
    for seed in range(3):
        rng = np.random.default_rng([seed, 6])
        campaign = prepare(measured(rng, tests=30, points=12, between=0.004))
        y = campaign.average(campaign.mu).reshape(30, 12)
        columns = np.column_stack([np.ones(30), rng.normal(size=(30, 14))])
        floor = estimate(campaign, Layout.of(campaign), y.ravel(), np.repeat(columns, 12, axis=0))
        levels = y.mean(axis=1)
        left = levels - columns @ np.linalg.lstsq(columns, levels, rcond=None)[0]
        within = np.sum((y - levels[:, None]) ** 2) / (30 * 11)
        assert floor.test**2 + floor.drift**2 == pytest.approx(
            left @ left / (30 - 15) - within / 12, rel=0.03
        )


def test_noise_of_the_sensor_is_seen_beside_a_drift() -> None:
    campaign = prepare(measured(np.random.default_rng(7), tests=6, points=400, drift=0.003, length=20.0))
    y = campaign.average(campaign.mu)
    floor = estimate(campaign, Layout.of(campaign), y, np.ones((len(y), 1)))
    assert campaign.count.max() > 1 and floor.sensor == pytest.approx(0.001, rel=0.1)


def test_whitening_inverts_the_covariance_of_the_bins() -> None:
    data = measured(np.random.default_rng(3), tests=3, points=200)
    campaign = prepare(data)
    distance, m = campaign.average(campaign.distance), len(campaign.starts)
    S = np.zeros((m, m))
    for i in range(m):
        for j in range(m):
            if campaign.test[i] == campaign.test[j]:
                S[i, j] = 0.004**2 + 0.002**2 * np.exp(-abs(distance[i] - distance[j]) / 3.0)
        S[i, i] += 0.001**2 / campaign.count[i]
    assert campaign.count.max() > 1  # bins hold several points, whose noise averages out
    whiten = Whitener(Layout.of(campaign), FLOOR, 1e-9)
    white = whiten(np.linalg.cholesky(S))
    np.testing.assert_allclose(white @ white.T, np.eye(m), atol=1e-6)
    # of a Gaussian vector, what one bin lies off its expectation given all others
    residual = np.random.default_rng(4).normal(size=m)
    others = np.arange(m) != 5
    towards = np.linalg.solve(S[np.ix_(others, others)], S[others, 5])
    spread = np.sqrt(S[5, 5] - S[5, others] @ towards)
    assert whiten.isolation(residual)[5] == pytest.approx(
        (residual[5] - towards @ residual[others]) / spread, rel=1e-5
    )


def test_two_tests_cannot_show_the_scatter_between_them() -> None:
    campaign = prepare(measured(np.random.default_rng(5), tests=2))
    y = campaign.average(campaign.mu)
    floor = estimate(campaign, Layout.of(campaign), y, np.ones((len(y), 1)))
    assert not floor.known and floor.test == 0.0
