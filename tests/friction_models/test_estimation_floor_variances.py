"""The likelihood of the parts of the noise against a density that is written out, and its largest value against another search."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.optimize import approx_fprime, minimize
from scipy.stats import multivariate_normal

from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.floor_variances import LENGTH_PRIOR, USUAL, VariancesOfFloor
from friction_models.estimation.noise.layout import Layout
from friction_models.loads import FloatArray

from .estimation_cases import measured


class Case:
    """Tests of unequal length, with a mean of three columns."""

    def __init__(self, seed: int, tests: int = 6, between: float = 0.004, drift: float = 0.002) -> None:
        rng = np.random.default_rng([seed, 41])
        data = measured(rng, tests=tests, points=14, between=between, drift=drift)
        # every second test is shorter, so that the padding matters
        place = data.groupby("test_id").cumcount()
        odd = data["test_id"].isin(data["test_id"].unique()[::2])
        self.campaign: BinnedTests = prepare(data[~odd | (place < 9)].reset_index(drop=True))
        self.y = self.campaign.average(self.campaign.mu)
        self.mean = np.column_stack([np.ones(len(self.y)), rng.normal(size=(len(self.y), 2))])
        self.contrasts = null_space(self.mean.T)
        self.scale = float(np.std(self.y))
        self.variances = VariancesOfFloor(Layout.of(self.campaign), self.y, self.mean, self.scale)
        self.length = self.variances._length

    def covariance(self, test: float, drift: float, length: float, sensor: float) -> FloatArray:
        """The covariance of all bins, of logarithms of sizes over `scale` and the length of a test."""
        s_b, s_d, s_w = np.exp([test, drift, sensor]) * self.scale
        distance, of = self.campaign.average(self.campaign.distance), self.campaign.test
        slow = s_d**2 * np.exp(-np.abs(distance[:, None] - distance) / (np.exp(length) * self.length))
        same = of[:, None] == of
        return np.where(same, s_b**2 + slow, 0.0) + np.diag(s_w**2 / self.campaign.count)

    def value(self, logs: FloatArray) -> float:
        """Minus the log-density of what is left of mu where no column of the mean reaches, and that of the length."""
        S = self.contrasts.T @ self.covariance(*logs) @ self.contrasts
        density = multivariate_normal.logpdf(self.contrasts.T @ self.y, cov=S)
        return float(-density + 0.5 * LENGTH_PRIOR * (logs[2] - np.log(USUAL[2])) ** 2)

    def logs(self, theta: FloatArray) -> FloatArray:
        return np.log(
            np.array(self.variances._sizes(theta)) / [self.scale, self.scale, self.length, self.scale]
        )


@pytest.mark.parametrize("seed", range(3))
def test_likelihood_slope_and_curvature_are_those_of_a_density_written_out(seed: int) -> None:
    case, rng = Case(seed), np.random.default_rng(seed)
    places = rng.normal(0.3, 0.7, (3, 4))
    values = np.array([case.variances._at(theta).value - case.value(case.logs(theta)) for theta in places])
    assert np.ptp(values) < 1e-6  # up to a constant
    for theta in places:
        found = case.variances._at(theta)
        slope, curvature = found.slope.copy(), found.curvature().copy()
        numbers = approx_fprime(theta, lambda t: case.value(case.logs(t)), 1e-6)
        np.testing.assert_allclose(slope, numbers, rtol=1e-3, atol=2e-3)
        # half of y' P V_i P V_j y, of changes of the covariance by differences
        step = 1e-5 * np.eye(4)
        V = [
            (case.covariance(*case.logs(theta + e)) - case.covariance(*case.logs(theta - e))) / 2e-5
            for e in step
        ]
        inverse = np.linalg.inv(case.covariance(*case.logs(theta)))
        towards = inverse @ case.mean
        P = inverse - towards @ np.linalg.solve(case.mean.T @ towards, towards.T)
        expected = 0.5 * np.array([[case.y @ P @ a @ P @ b @ P @ case.y for b in V] for a in V])
        moves = (case.logs(theta + step[2])[2] - case.logs(theta - step[2])[2]) / 2e-5
        expected[2, 2] += LENGTH_PRIOR * moves**2
        np.testing.assert_allclose(curvature, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize(("between", "drift"), [(0.004, 0.002), (0.0, 0.003)])
def test_the_most_likely_parts_are_those_of_another_search(between: float, drift: float) -> None:
    case = Case(1, between=between, drift=drift)
    found = case.variances.most_likely(0.001)
    logs = np.log(np.array(found) / [case.scale, case.scale, case.length, case.scale])
    limits = [(-9, 3), (-9, 3), (-4, 2), (-7, 4)]
    starts = ([-0.2, -1.2, -1.9, -1.0], [-3.0, 0.0, -1.0, -2.0])
    best = min(minimize(case.value, s, method="Nelder-Mead", bounds=limits).fun for s in starts)
    assert case.value(logs) < best + 0.05


def test_an_earlier_estimate_changes_nothing_but_where_the_search_starts() -> None:
    case = Case(2)
    first = case.variances.most_likely(0.001)
    again = case.variances.most_likely(0.001, first._replace(test=0.0, drift=5.0 * first.drift))
    np.testing.assert_allclose(again, first, rtol=0.01, atol=3e-5)
