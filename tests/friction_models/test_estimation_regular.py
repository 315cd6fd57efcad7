"""Equations stay solvable where columns of data say the same: loads of two levels, nested columns, copies; made-up data."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.discovery import diagnose
from friction_models.discovery.further_tests.hypotheses import SEEN, _variance
from friction_models.discovery.further_tests.information import Outcomes
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.noise_floor import NoiseFloor
from friction_models.estimation.noise.reference import Reference
from friction_models.estimation.noise.regular import regular_root
from friction_models.estimation.search.base_law import base_law

from .estimation_cases import measured


def nested(seed: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return averages at two speeds and two pressures, with one oil that differs and runs counted anew for each oil."""
    rng = np.random.default_rng(seed)
    names = [f"t{k:02d}" for k in range(48)]
    oil = np.repeat(["a", "b", "c", "d"], 12)
    run = np.concatenate([np.arange(1, 13) + k % 2 for k in range(4)])
    v, p = np.tile([20.0, 100.0], 24), np.tile([10.0, 10.0, 20.0, 20.0], 12)
    mu = 0.12 + 0.025 * (oil == "a") - 1e-4 * v + 4e-4 * run + rng.normal(0.0, 0.008, 48)
    points = pd.DataFrame({"test_id": names, "v_rel": v, "sigma_n": p, "mu": mu})
    return points, pd.DataFrame({"test_id": names, "oil": oil, "run": run})


@pytest.mark.parametrize("seed", [0, 3])
def test_loads_of_two_levels_and_two_factors_are_diagnosed(seed: int) -> None:
    # A straight line takes up every curve along such loads: of what is beyond it only rounding is left.
    answer = diagnose(*nested(seed))
    assert answer.effects[0] == "factor:oil" and {r["effect"] for r in answer.ranking} >= {"factor:run"}


def test_curves_that_nothing_shows_are_not_large_for_that() -> None:
    white = np.random.default_rng(0).normal(size=(40, 6))
    shown = _variance(2.0, white, 0.5 * white)
    assert shown * np.sum((0.5 * white) ** 2) == pytest.approx(2.0)
    assert _variance(2.0, white, 1e-14 * white) * SEEN * np.sum(white**2) == pytest.approx(2.0)
    assert np.isfinite(_variance(2.0, white[:, :0], white[:, :0]))


def test_a_root_is_found_where_rounding_took_it_and_others_stay_as_they_are() -> None:
    rng = np.random.default_rng(1)
    columns = rng.normal(size=(10, 3))
    sizes = np.logspace(0, 6, 10)
    singular = (columns @ columns.T) * sizes * sizes[:, None]
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(singular)
    root = regular_root(singular)
    np.testing.assert_allclose((root @ root.T) / sizes / sizes[:, None], columns @ columns.T, atol=1e-7)
    regular = singular + np.diag(np.diag(singular))
    np.testing.assert_array_equal(regular_root(regular), np.linalg.cholesky(regular))
    with pytest.raises(np.linalg.LinAlgError, match="no covariance"):
        regular_root(-np.eye(2))


def test_outcomes_that_follow_from_one_another_are_weighed() -> None:
    spread = 10.0 + np.random.default_rng(0).normal(size=(10, 3))
    covariance = np.array([spread @ spread.T] * 2)
    apart = np.array([np.zeros(10), 100.0 * spread[:, 0]])
    for mean, bits in ((apart, 1.0), (np.zeros((2, 10)), 0.0)):
        outcomes = Outcomes(np.full(2, 0.5), np.arange(2), np.ones(2), mean, covariance)
        assert outcomes.reduction == pytest.approx(bits, abs=1e-6)


@pytest.mark.parametrize("sensor", [1e-3, 1e-5, 1e-7])
def test_terms_that_say_the_same_change_no_prediction(sensor: float) -> None:
    data = measured(np.random.default_rng(0), tests=60, points=12, between=0.002)
    campaign = prepare(data)
    y = campaign.average(campaign.mu)
    base = campaign.average(base_law(LinearFriction(), campaign).columns)
    reference = Reference(campaign, NoiseFloor(sensor, 0.002, 1e-5, 3.0, (0.0, 0.0), sensor), y)
    twice = np.column_stack([base, base, base @ np.arange(1.0, base.shape[1] + 1.0)])
    folds = np.arange(len(campaign.tests)) % 4
    alone, both = reference.out_of_fold(base, folds)[0], reference.out_of_fold(twice, folds)[0]
    np.testing.assert_allclose(both, alone, atol=0.01 * np.std(y))
    np.testing.assert_allclose(reference.surprise(twice), reference.surprise(base), atol=0.01)
