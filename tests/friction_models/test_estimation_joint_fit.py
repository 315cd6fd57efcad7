"""The joint fit of base and effects: by which weights is decided by tests left out one by one."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import lsq_linear

from friction_models import LinearFriction
from friction_models.effects import make_effect
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.campaign.factors import as_fitted
from friction_models.estimation.fit.beside_base import BesideBase
from friction_models.estimation.fit.joint_problem import JointProblem, solve_jointly
from friction_models.estimation.search.base_law import base_law
from friction_models.estimation.search.candidates import evaluate

from .estimation_cases import measured


def problem_of(names: dict[str, str] | None = None) -> JointProblem:
    """Return the fit of a falling speed law to tests that hide a hump in speed; `names` are other names of the tests."""
    data = measured(np.random.default_rng(3), tests=30, points=8)
    data["mu"] += 0.02 / np.cosh((data["v_rel"] - 60.0) / 50.0)
    if names:
        data["test_id"] = data["test_id"].map(names)
    campaign = prepare(data)
    return solve_jointly(campaign, base_law(LinearFriction(), campaign), [make_effect("stribeck")])


def test_the_error_of_tests_left_out_is_that_of_fits_without_them() -> None:
    problem = problem_of()
    matrix = np.column_stack([problem.base, *problem.columns(problem.shapes)])
    white, target = problem.whiten(matrix), problem.whiten(problem.y)
    error = np.empty(len(problem.y))
    for k in range(30):
        held = problem.campaign.test == k
        x = np.linalg.lstsq(white[~held], target[~held], rcond=1e-9)[0]
        error[held] = problem.y[held] - matrix[held] @ x
    expected = np.average(error**2, weights=problem.campaign.count)
    assert problem._left_out() == pytest.approx(expected, rel=1e-5)


def test_the_error_of_tests_left_out_does_not_hang_on_their_names() -> None:
    names = [f"t{k:03d}" for k in range(30)]
    other = dict(zip(names, np.random.default_rng(0).permutation(names), strict=True))
    assert problem_of(other)._left_out() == pytest.approx(problem_of()._left_out(), rel=1e-4)


def levels_problem(names: dict[str, str] | None = None, beside: str = "") -> JointProblem:
    """Return the fit of offsets of four coatings, drawn towards zero, and of another effect; `names` are other names of the tests."""
    data = measured(np.random.default_rng(4), tests=24, points=8)
    table = pd.DataFrame({"test_id": sorted(data["test_id"].unique())})
    table["coating"] = [("none", "soap", "oxalate", "polymer")[k % 4] for k in range(len(table))]
    data["mu"] += (
        data["test_id"].map(dict(zip(table["test_id"], table["coating"] == "soap", strict=True))) * 0.01
    )
    if names:
        data["test_id"], table["test_id"] = data["test_id"].map(names), table["test_id"].map(names)
    campaign = prepare(data, table)
    added = [make_effect(name) for name in (beside, "factor:coating") if name]
    effects = as_fitted(campaign, added)
    return solve_jointly(campaign, base_law(LinearFriction(), campaign), effects)


def test_the_error_of_tests_left_out_is_known_beside_offsets_of_levels() -> None:
    """Offsets and the level of the base are any together: the error was 0.002 or 300, as rounding had it, and so were the weights."""
    problem = levels_problem()
    blocks = problem.columns(problem.shapes)
    matrix = np.column_stack([problem.base, *blocks])
    white, target = problem.whiten(matrix), problem.whiten(problem.y)
    columns = problem._solved(problem.shapes, blocks)[0]
    drawn = np.column_stack([np.zeros((4, problem.base.shape[1])), np.diag(columns.pull * columns.scale)])
    assert columns.pull.min() > 0.0
    error = np.empty(len(problem.y))
    for k in range(24):
        held = problem.campaign.test == k
        rows, values = np.vstack([white[~held], drawn]), np.r_[target[~held], np.zeros(4)]
        error[held] = problem.y[held] - matrix[held] @ np.linalg.lstsq(rows, values, rcond=1e-12)[0]
    expected = np.average(error**2, weights=problem.campaign.count)
    assert problem._left_out() == pytest.approx(expected, rel=1e-4)
    names = [f"t{k:03d}" for k in range(24)]
    other = dict(zip(names, np.random.default_rng(0).permutation(names), strict=True))
    assert levels_problem(other)._left_out() == pytest.approx(problem._left_out(), rel=1e-4)


def test_the_squares_beside_offsets_of_levels_change_as_little_as_a_shape_does() -> None:
    """Rounding moved them by 2e-5 of themselves: the way to the best shape ended where it began."""
    problem = levels_problem(beside="work_exhaustion")
    squares = []
    for step in (0.0, 1e-10, 1e-9, 1e-8):
        shapes = [dict(s) for s in problem.shapes]
        shapes[0]["W_c"] *= 1.0 + step
        squares.append(float(np.sum(problem._rest(shapes) ** 2)))
    assert np.ptp(squares) < 1e-7 * squares[0]


def test_no_effect_changes_mu_by_more_than_was_measured() -> None:
    """A valley along the pressure is the difference of a steep line and a law that saturates, both as large as one likes."""
    data = measured(np.random.default_rng(5), tests=40, points=4)
    data["mu"] += 0.03 * ((data["sigma_n"] - data["sigma_n"].mean()) / np.ptp(data["sigma_n"])) ** 2
    campaign = prepare(data)
    problem = solve_jointly(
        campaign, base_law(LinearFriction(), campaign), [make_effect("pressure_saturation")]
    )
    share = problem.columns(problem.shapes)[0] @ problem.solve(problem.shapes)[1][0]
    assert np.ptp(share) <= data["mu"].max()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("pulled", [False, True])
def test_coefficients_within_bounds_are_those_of_another_solver(seed: int, pulled: bool) -> None:
    """The whole problem by the trust region of scipy, with the base unbounded; two columns of the base are the same."""
    rng = np.random.default_rng(seed)
    matrix, target = rng.normal(size=(60, 7)), rng.normal(size=60)
    matrix[:, 2] = matrix[:, 1]
    matrix[:, 5] += matrix[:, 0]
    matrix[:, 3:] /= np.linalg.norm(matrix[:, 3:], axis=0)
    low, high = np.array([0.0, -0.05, -1.0, -0.2]), np.array([0.3, 0.0, 1.0, 0.2])
    columns = BesideBase(matrix[:, :3], target).columns(matrix[:, 3:])
    whole, wanted = matrix, target
    if pulled:
        pull = rng.uniform(0.1, 2.0, size=4)
        columns.draw(pull)
        whole = np.vstack([matrix, np.column_stack([np.zeros((4, 3)), np.diag(pull)])])
        wanted = np.r_[target, np.zeros(4)]
    found = columns.amplitudes(low, high)
    every = np.r_[columns.base(found), found]
    assert np.all((found >= low) & (found <= high))
    with np.errstate(invalid="ignore"):
        bounds = np.r_[np.full(3, -np.inf), low], np.r_[np.full(3, np.inf), high]
        other = lsq_linear(whole, wanted, bounds, tol=1e-14)
    assert np.sum((whole @ every - wanted) ** 2) == pytest.approx(2.0 * other.cost, rel=1e-9)
    assert columns.rest(found) == pytest.approx(target - matrix @ every)
    assert np.any((found == low) | (found == high))


def test_a_column_that_the_base_describes_gets_no_amplitude() -> None:
    rng = np.random.default_rng(0)
    base = np.column_stack([np.ones(50), rng.normal(size=50)])
    seen, unseen = rng.normal(size=50), base[:, 1] + 1e-4 * rng.normal(size=50)
    columns = BesideBase(base, seen + 0.1 * rng.normal(size=50)).columns(np.column_stack([seen, unseen]))
    first, second = columns.amplitudes() / columns.scale
    assert first == pytest.approx(1.0, abs=0.1)
    assert second == 0.0


def test_two_effects_start_from_the_best_pair_of_scan_values() -> None:
    """One after the other they may end where each mends the other; all pairs are compared here by another solver."""
    rng = np.random.default_rng(8)
    data = measured(rng, tests=12, points=20)
    data["mu"] += (
        0.03 / (1.0 + data["sd"] / data["sd"].max()) ** 6 + 0.02 * (data["sd"] / data["sd"].max()) ** 5
    )
    campaign = prepare(data)
    effects = [make_effect("running_in"), make_effect("wear_out")]
    problem = JointProblem(campaign, base_law(LinearFriction(), campaign), effects)
    problem.weigh()
    base, target = problem.whiten(problem.base), problem.whiten(problem.y)
    blocks = [
        (problem.whiten(c.columns[:, :, 0]), c)
        for c in (evaluate(e, campaign, problem.mu, g) for e, g in zip(effects, problem.grids, strict=True))
    ]
    (first, one), (second, other) = blocks
    free = np.full(base.shape[1], np.inf)
    squares = np.full((first.shape[1], second.shape[1]), np.inf)
    for i in range(first.shape[1]):
        for j in range(second.shape[1]):
            matrix = np.column_stack([base, first[:, i], second[:, j]])
            fit = lsq_linear(
                matrix / np.linalg.norm(matrix, axis=0), target, bounds=(np.r_[-free, 0.0, 0.0], np.inf)
            )
            squares[i, j] = fit.cost
    problem.scan()
    chosen = [
        int(np.argmax([c.shape_at(k) == s for k in range(c.columns.shape[1])]))
        for c, s in zip((one, other), problem.shapes, strict=True)
    ]
    assert squares[chosen[0], chosen[1]] <= squares.min() * (1.0 + 1e-6)
