"""How likely the prior variances of the reference are, against the density of a normal distribution and its differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import approx_fprime, minimize

from friction_models.estimation.noise.reference_curves import Curves
from friction_models.estimation.noise.reference_variances import NOTHING, VariancesOfCurves, _Solved

SCALE = 1.3
POINTS = [
    np.array([-1.0, 0.3, -0.5, -0.7, 0.2]),
    np.array([-4.0, 1.0, 2.0, -3.0, -0.5]),
    np.array([-40.0, 0.0, 0.5, 0.0, 0.0]),
]


def problem() -> tuple[VariancesOfCurves, np.ndarray, np.ndarray, np.ndarray, list[Curves], np.ndarray]:
    rng = np.random.default_rng(4)
    test = np.repeat(np.arange(20), 10)
    curves = [Curves(of, rng.normal(size=(200, n))) for of, n in (((0,), 5), ((1,), 4), ((0, 1), 6))]
    free, one, y = rng.normal(size=(200, 3)), rng.uniform(0.5, 1.0, 200), rng.normal(size=200)
    rows = np.column_stack([free, *(c.columns for c in curves)])
    return VariancesOfCurves(rows, one, y, test, curves, SCALE), free, one, y, curves, test


def solved(variances: VariancesOfCurves, theta: np.ndarray) -> _Solved:
    at = variances._at(theta)
    assert at is not None
    return at


def covariances(
    theta: np.ndarray, one: np.ndarray, curves: list[Curves], test: np.ndarray
) -> list[np.ndarray]:
    """What curves, offsets of tests and noise are in the covariance of mu, written out."""
    sizes = np.exp([theta[0], theta[1], theta[:3].sum()]) * SCALE**2
    parts = [s * c.columns @ c.columns.T for s, c in zip(sizes, curves, strict=True)]
    same = test[:, None] == test[None, :]
    return [
        *parts,
        np.exp(theta[-2]) * SCALE**2 * same * np.outer(one, one),
        np.exp(theta[-1]) * np.eye(len(one)),
    ]


@pytest.mark.parametrize("theta", POINTS)
def test_slopes_are_those_of_the_values(theta: np.ndarray) -> None:
    variances = problem()[0]
    slope = variances._slope(solved(variances, theta))
    differences = approx_fprime(theta, lambda t: solved(variances, t).value, 1e-6)
    assert slope == pytest.approx(differences, rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("theta", POINTS[:2])
def test_curvature_is_the_average_information(theta: np.ndarray) -> None:
    """The definition, with all matrices written out: y' P V_j P V_k P y."""
    variances, free, one, y, curves, test = problem()
    parts = covariances(theta, one, curves, test)
    inverse = np.linalg.inv(sum(parts))
    projected = inverse - inverse @ free @ np.linalg.solve(free.T @ inverse @ free, free.T @ inverse)
    by_theta = [parts[0] + parts[2], parts[1] + parts[2], *parts[2:]]
    made = np.column_stack([v @ projected @ y for v in by_theta])
    assert variances._information(solved(variances, theta)) == pytest.approx(
        made.T @ projected @ made, rel=1e-4, abs=1e-6
    )


def test_the_most_likely_variances_are_those_of_another_search() -> None:
    variances = problem()[0]

    def density(theta: np.ndarray) -> float:
        return solved(variances, theta).value + float(
            np.sum(((theta - variances._mean) / variances._spread) ** 2)
        )

    best = minimize(density, variances._mean, method="Powell", options={"xtol": 1e-6, "ftol": 1e-10})
    assert density(variances.most_likely()) == pytest.approx(best.fun, abs=0.02)


@pytest.mark.parametrize("quantity", [0, 1])
def test_a_quantity_is_worth_what_the_likelihood_loses_without_it(quantity: int) -> None:
    variances, theta = problem()[0], POINTS[0]
    at = solved(variances, theta)
    without = theta.copy()
    without[quantity] = NOTHING
    worth = variances._worth(at, np.linalg.inv(at.root), [quantity, 2])
    loss = solved(variances, without).value - at.value
    assert abs(loss) > 1.0
    assert worth == pytest.approx(loss, abs=1e-6)


def test_values_are_those_of_the_normal_distribution() -> None:
    """The covariance written out; free terms have a prior so wide that it only adds a constant."""
    variances, free, one, y, curves, test = problem()

    def dense(theta: np.ndarray) -> float:
        cov = sum(covariances(theta, one, curves, test)) + 1e8 * SCALE**2 * free @ free.T
        return float(np.linalg.slogdet(cov)[1] + y @ np.linalg.solve(cov, y))

    ours = [solved(variances, theta).value for theta in POINTS[:2]]
    assert ours[0] - ours[1] == pytest.approx(dense(POINTS[0]) - dense(POINTS[1]), abs=1e-2)
