"""What the reference knows of the past of a contact."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.histories import histories

from .test_estimation_reference import SCATTER, plain, reference_of

TESTS, POINTS = 32, 40


def ramps(seed: int, hidden: str) -> pd.DataFrame:
    """Return tests in which pressure rises and falls, with a hidden part of mu in a column of its own."""
    rng = np.random.default_rng(seed)
    parts, ways = [], np.linspace(0.0, 1.0, POINTS)
    for k in range(TESTS):
        v, T, top = np.exp(rng.uniform(1.5, 6.0)), rng.uniform(20, 300), rng.uniform(600, 2500)
        turn = rng.uniform(0.3, 0.8)
        sigma = top * np.where(ways < turn, ways / turn, (1.0 - 0.8 * ways) / (1.0 - 0.8 * turn)) + 200.0
        sd = 30.0 * ways
        highest = np.maximum.accumulate(sigma)
        part = {
            "highest sigma_n": 2e-5 * (highest - sigma),
            "time": 0.02 * -np.expm1(-((sd / v / 0.4) ** 2)),
            "nothing": np.zeros(POINTS),
        }[hidden]
        noise = SCATTER * rng.normal() + 0.001 * rng.normal(size=POINTS)
        frame = {"test_id": f"t{k:02d}", "v_rel": v, "T": T, "sigma_n": sigma, "sd": sd, "psi": 1.2}
        parts.append(pd.DataFrame({**frame, "hidden": part, "mu": 0.1 + part + noise}))
    return pd.concat(parts, ignore_index=True)


def campaign_of(data: pd.DataFrame) -> BinnedTests:
    return prepare(data.drop(columns="hidden"))


def test_each_history_orders_the_averages_as_what_it_is_called() -> None:
    campaign = campaign_of(ramps(0, "nothing"))
    found = histories(campaign)
    assert set(found) == {"time", "load path", "highest sigma_n"}
    loads = campaign.loads
    time = campaign.average(np.tile(30.0 * np.linspace(0.0, 1.0, POINTS), TESTS) / loads.v_rel)
    assert spearmanr(found["time"], time).statistic > 0.999
    highest = pd.Series(loads.sigma_n).groupby(np.repeat(np.arange(TESTS), POINTS)).cummax().to_numpy()
    assert spearmanr(found["highest sigma_n"], campaign.average(highest)).statistic > 0.999


def test_what_a_load_says_already_is_no_history() -> None:
    """At one speed time is distance; at one pressure the load path is; a load that never falls has no past of its own."""
    ids = np.repeat([f"t{k}" for k in range(8)], 20)
    sd = np.tile(np.linspace(0.0, 30.0, 20), 8)
    T = np.repeat(np.linspace(20.0, 300.0, 8), 20) + sd
    data = pd.DataFrame(
        {"test_id": ids, "v_rel": 50.0, "T": T, "sigma_n": 900.0, "sd": sd, "psi": 1.2, "mu": 0.1}
    )
    assert histories(prepare(data.assign(mu=0.1 + 1e-4 * sd))) == {}


@pytest.mark.parametrize("hidden", ["time", "highest sigma_n"])
def test_a_law_of_the_past_is_predicted_on_unseen_tests(hidden: str) -> None:
    removed = []
    for seed in range(3):
        data = ramps(seed, hidden)
        campaign = campaign_of(data)
        reference, base, folds = reference_of(campaign)
        law = plain(campaign, base, folds, reference.y)
        truth = campaign.average(data["hidden"].to_numpy())
        error = reference.y - reference.out_of_fold(base, folds)[0]
        noise = np.var(reference.y - truth)
        removed.append(1.0 - (np.var(error) - noise) / (np.var(reference.y - law) - noise))
    assert np.median(removed) > 0.9
