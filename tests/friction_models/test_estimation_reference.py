"""The flexible reference: it predicts what is there to be predicted, and nothing where there is nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise import reference_variances as module
from friction_models.estimation.noise.newton import Likelihood
from friction_models.estimation.noise.noise_floor import NoiseFloor
from friction_models.estimation.noise.reference import Reference
from friction_models.estimation.search.base_law import base_law
from friction_models.loads import FloatArray

from .estimation_cases import measured

SCATTER = 0.002


def campaign_of(seed: int, size: float) -> tuple[BinnedTests, np.ndarray]:
    """Return tests with a product of speed and pressure hidden in mu, and that part in the bins."""
    data = measured(np.random.default_rng(seed), tests=60, points=12, between=SCATTER)
    z = {n: (data[n] - data[n].mean()) / data[n].std() for n in ("v_rel", "sigma_n")}
    hidden = size * (z["v_rel"] * z["sigma_n"]).to_numpy()
    campaign = prepare(data.assign(mu=data["mu"] + hidden))
    return campaign, campaign.average(hidden)


def reference_of(campaign: BinnedTests) -> tuple[Reference, np.ndarray, np.ndarray]:
    """Return reference, base columns and folds."""
    y = campaign.average(campaign.mu)
    floor = NoiseFloor(0.001, SCATTER, 1e-5, 3.0, (0.0, 0.0), 0.001)
    base = campaign.average(base_law(LinearFriction(), campaign).columns)
    return Reference(campaign, floor, y), base, np.arange(len(campaign.tests)) % 4


def plain(campaign: BinnedTests, columns: np.ndarray, folds: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return out-of-fold predictions of ordinary least squares."""
    fold, predicted = folds[campaign.test], np.empty(len(y))
    for k in np.unique(fold):
        seen = fold != k
        predicted[~seen] = columns[~seen] @ np.linalg.lstsq(columns[seen], y[seen], rcond=None)[0]
    return predicted


def test_a_hidden_product_is_predicted_on_unseen_tests() -> None:
    removed = []
    for seed in range(4):
        campaign, _ = campaign_of(seed, 0.006)
        reference, base, folds = reference_of(campaign)
        law = reference.y - plain(campaign, base, folds, reference.y)
        error = reference.y - reference.out_of_fold(base, folds)[0]
        # a perfect model would leave scatter and noise: what it could remove is the variance of the hidden part
        removed.append(1.0 - (np.var(error) - SCATTER**2) / (np.var(law) - SCATTER**2))
    assert np.median(removed) > 0.8


def test_where_nothing_is_hidden_it_is_no_better_than_the_line() -> None:
    worse = 0
    for seed in range(8):
        campaign, _ = campaign_of(100 + seed, 0.0)
        reference, base, folds = reference_of(campaign)
        law = reference.y - plain(campaign, base, folds, reference.y)
        error = reference.y - reference.out_of_fold(base, folds)[0]
        assert np.mean(error**2) > 0.9 * np.mean(law**2)
        assert np.mean(error**2) < 1.15 * np.mean(law**2)
        worse += np.mean(error**2) > np.mean(law**2)
    assert worse >= 3


def test_metadata_in_words_is_followed() -> None:
    data = measured(np.random.default_rng(5), tests=48, points=12, between=SCATTER)
    ids = data["test_id"].unique()
    tests = pd.DataFrame({"test_id": ids, "operator": [f"O{k % 3}" for k in range(len(ids))]})
    shift = dict(zip(ids, [0.02 * (k % 3 == 1) for k in range(len(ids))], strict=True))
    campaign = prepare(data.assign(mu=data["mu"] + data["test_id"].map(shift)), tests)
    reference, base, folds = reference_of(campaign)
    assert "operator" in reference.names
    error = reference.y - reference.out_of_fold(base, folds)[0]
    law = reference.y - plain(campaign, base, folds, reference.y)
    assert np.var(error) < 0.15 * np.var(law)


def with_names(seed: int, shifted: float) -> tuple[np.ndarray, np.ndarray]:
    """Return predictions of a hidden product without and with a column of three names, to one of which mu owes a shift."""
    data = measured(np.random.default_rng(seed), tests=48, points=6, between=SCATTER)
    z = {n: (data[n] - data[n].mean()) / data[n].std() for n in ("v_rel", "sigma_n")}
    ids = data["test_id"].unique()
    drawn = np.random.default_rng(1000 + seed).choice(["A", "B", "C"], len(ids))
    shift = shifted * data["test_id"].map(dict(zip(ids, drawn == "B", strict=True)))
    data = data.assign(mu=data["mu"] + 0.006 * z["v_rel"] * z["sigma_n"] + shift)
    known = pd.DataFrame({"test_id": ids, "material": np.resize(["X", "Y"], len(ids))})
    found = []
    for tests in (known, known.assign(lot=drawn)):
        reference, base, folds = reference_of(prepare(data, tests))
        found.append(reference.out_of_fold(base, folds)[0])
    return found[0], found[1]


def test_metadata_that_say_nothing_change_nothing() -> None:
    same = [np.array_equal(*with_names(seed, shifted=0.0)) for seed in range(8)]
    assert sum(same) >= 7  # by chance, one column of three names in some twenty looks like something


def test_metadata_that_say_something_stay() -> None:
    for seed in range(5):
        without, with_lot = with_names(seed, shifted=0.01)
        assert np.std(with_lot - without) > 0.003


@pytest.mark.parametrize("anew", [True, False])
def test_tests_that_are_predicted_anew_have_no_part_in_their_prediction(anew: bool) -> None:
    """Exchanging what was measured in the tests of one fold must not change what the others say of them."""
    campaign, _ = campaign_of(3, 0.006)
    reference, base, folds = reference_of(campaign)
    before = reference.out_of_fold(base, folds, anew=anew)[0]
    held = folds[campaign.test] == 1
    mu = campaign.mu.copy()
    mu[np.repeat(held, campaign.count.astype(int))] = mu[np.repeat(held, campaign.count.astype(int))][::-1]
    exchanged, base, folds = reference_of(replace(campaign, mu=mu))
    after = exchanged.out_of_fold(base, folds, anew=anew)[0]
    assert (before[held] == pytest.approx(after[held], rel=1e-9)) is anew


def half_a_factorial(seed: int) -> BinnedTests:
    """Return 40 of the 81 settings of four loads at three levels; only one of three materials feels the temperature."""
    rng = np.random.default_rng(seed)
    grid = list(product((5.0, 50.0, 500.0), (20.0, 100.0, 300.0), (500.0, 1500.0, 2700.0), (1.05, 5.0, 20.0)))
    parts, materials = [], []
    for k, i in enumerate(rng.permutation(81)[:40]):
        v, T, sigma, psi = grid[i]
        materials.append(str(rng.choice(["16MnCr5", "42CrMo4", "C15"])))
        hidden = 0.04 * (T - 150.0) / 150.0 * (materials[-1] == "C15")
        noise = SCATTER * rng.normal() + 0.003 * rng.normal(size=12)
        loads = {"v_rel": v, "T": T, "sigma_n": sigma, "sd": np.linspace(0.5, 20.0, 12), "psi": psi}
        parts.append(
            pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": 0.15 - 1e-5 * sigma + hidden + noise})
        )
    ids = [f"t{k:02d}" for k in range(40)]
    tests = pd.DataFrame({"test_id": ids, "material": materials, "operator": rng.choice(["A", "B"], 40)})
    return prepare(pd.concat(parts, ignore_index=True), tests)


def test_one_material_that_alone_feels_a_load_is_followed() -> None:
    """Neither the load nor the material says much alone: what belongs to both must not be taken for scatter of the tests."""
    for seed in range(5, 11):
        campaign = half_a_factorial(seed)
        reference, base, folds = reference_of(campaign)
        law = reference.y - plain(campaign, base, folds, reference.y)
        error = reference.y - reference.out_of_fold(base, folds)[0]
        assert np.std(law) > 0.012
        assert np.std(error) < 0.0052  # scatter and noise of the averages alone: 0.0036


def test_the_gradient_of_the_criterion_is_that_of_its_values(monkeypatch: pytest.MonkeyPatch) -> None:
    campaign, _ = campaign_of(9, 0.004)
    seen = []

    def look(at: Callable[[FloatArray], Likelihood], start: FloatArray, *_: object) -> FloatArray:
        theta = start + np.random.default_rng(0).normal(0.0, 0.7, len(start))
        step = 1e-5 * np.eye(len(theta))
        numbers = [(at(theta + e).value - at(theta - e).value) / 2e-5 for e in step]
        seen.append((at(theta).slope, np.array(numbers)))
        return start

    monkeypatch.setattr(module, "most_likely", look)
    reference, base, folds = reference_of(campaign)
    reference.out_of_fold(base, folds)
    assert seen[0][0] == pytest.approx(seen[0][1], rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("name", ["v_rel", "T", "sigma_n", "distance"])
def test_metadata_may_be_called_like_a_load(name: str) -> None:
    data = measured(np.random.default_rng(3), tests=14, points=12, between=SCATTER)
    ids = data["test_id"].unique()
    random = np.random.default_rng(4).uniform(50.0, 400.0, len(ids))
    found = []
    for column in ("other", name):
        campaign = prepare(data, pd.DataFrame({"test_id": ids, column: random}))
        reference, base, folds = reference_of(campaign)
        assert reference.metadata == (column,)
        found.append(reference.out_of_fold(base, folds)[0])
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e300])
def test_a_number_beyond_all_measurements_is_no_metadata(value: float) -> None:
    data = measured(np.random.default_rng(3), tests=14, points=12, between=SCATTER)
    ids = data["test_id"].unique()
    campaign = prepare(
        data, pd.DataFrame({"test_id": ids, "gap": [value] + [1.0] * 6 + [2.0] * (len(ids) - 7)})
    )
    assert "gap" not in campaign.system
