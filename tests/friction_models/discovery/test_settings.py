"""Tests at one setting are one piece of evidence: they are left out together, and none of them is odd among its like."""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.discovery import diagnose
from friction_models.discovery.effect_search import EffectSearch
from friction_models.discovery.judge.unseen_tests import UnseenTests
from friction_models.effects import make_effect
from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.odd_tests import odd_tests
from friction_models.estimation.search.base_law import base_law
from friction_models.estimation.search.candidates import evaluate_all, spans_of

READINGS = 6


def readings(seed: int, of_a_setting: float = 0.003, noise: float = 0.0005) -> pd.DataFrame:
    """Return 24 settings of six readings each, one after the other while the contact warms up; mu falls with pressure."""
    rng = np.random.default_rng([seed, 3])
    rows = []
    for k, (v, sigma) in enumerate(product((50.0, 260.0, 700.0, 1250.0), np.linspace(0.3, 1.8, 6))):
        T = 15.0 + 0.02 * v * sigma + np.cumsum(rng.uniform(0.0, 1.5, READINGS))
        mu = 0.11 - 0.01 * sigma + rng.normal(0.0, of_a_setting) + rng.normal(0.0, noise, READINGS)
        for n in range(READINGS):
            rows.append(
                {"test_id": f"r{k:02d}{n}", "v_rel": v, "T": T[n], "sigma_n": sigma, "mu": float(mu[n])}
            )
    return pd.DataFrame(rows)


def blocks(campaign: BinnedTests, of_each_test: np.ndarray) -> np.ndarray:
    return of_each_test[np.argsort(campaign.tests)].reshape(-1, READINGS)


def test_a_setting_is_left_out_as_a_whole_though_it_warms_up() -> None:
    campaign = prepare(readings(0))
    assert (
        len(np.unique(campaign.setting)) == 24
        and np.ptp(blocks(campaign, campaign.setting), axis=1).max() == 0
    )
    fold = UnseenTests(campaign, base_law(LinearFriction(), campaign)).fold_of_test
    assert np.ptp(blocks(campaign, fold), axis=1).max() == 0
    assert np.bincount(fold).tolist() == [36, 36, 36, 36]


def test_a_temperature_that_was_set_makes_settings_of_its_own() -> None:
    data = readings(0)
    names = data["test_id"]
    tools = pd.DataFrame({"test_id": names, "T_tool": 20.0 + 10.0 * names.str[-1].astype(int)})
    assert len(np.unique(prepare(data, tools).setting)) == len(names)


def test_few_settings_leave_every_test_to_itself() -> None:
    data = readings(0).drop(columns="T")
    campaign = prepare(data[data["v_rel"] < 500.0])
    assert len(np.unique(campaign.setting)) == len(campaign.tests)


def test_folds_stay_when_readings_are_missing() -> None:
    data, rng = readings(1), np.random.default_rng(1)
    whole = prepare(data)
    part = prepare(data[rng.random(len(data)) > 0.1])
    law = [UnseenTests(c, base_law(LinearFriction(), c)).fold_of_test for c in (whole, part)]
    of = dict(zip(whole.tests, law[0], strict=True))
    assert [of[name] for name in part.tests] == law[1].tolist()


@pytest.mark.nightly
def test_what_the_readings_of_a_setting_share_is_no_law() -> None:
    """Each setting has an offset of its own, as tests of another day have: no effect, and no structure for certain."""
    found = [diagnose(readings(seed)) for seed in range(3)]
    assert sum(bool(f.effects) for f in found) <= 1
    assert all(f.confidence <= 0.5 for f in found if not f.effects)


def test_readings_that_drift_at_their_setting_are_not_odd_and_one_that_jumps_is() -> None:
    data = readings(2, of_a_setting=0.0005)
    drift = data["test_id"].str.startswith("r05")
    data.loc[drift, "mu"] += np.linspace(0.012, -0.012, READINGS)
    jump = data["test_id"] == "r113"
    data.loc[jump, "mu"] += 0.012
    campaign = prepare(data)
    columns = campaign.average(base_law(LinearFriction(), campaign).columns)
    assert odd_tests(campaign, columns, None).few == ["r113"]


def test_what_the_readings_of_a_setting_share_does_not_bend_a_law() -> None:
    """Friction rises exactly as the effect says; 24 settings, and not 144 witnesses, would have to speak against its form."""
    values = []
    for seed in range(12):
        data = readings(seed, of_a_setting=0.002)
        campaign = prepare(data)
        law = base_law(LinearFriction(), campaign)
        mu = np.full(len(campaign.mu), campaign.mu.mean())
        (candidate,), _ = evaluate_all(
            [make_effect("thermal_breakdown")], campaign, mu, spans_of(campaign, mu)
        )
        form = candidate.columns[:, candidate.columns.shape[1] // 2, 0]
        campaign.mu = campaign.mu + 0.04 * form / np.ptp(form)
        evidence, _ = EffectSearch(campaign, law, [candidate], 0, None).weigh(0.0)
        assert not evidence.bent
        if evidence.present:
            values.append(evidence.misfit.p_value)
    assert len(values) > 6 and np.median(values) > 0.1 and np.mean(np.array(values) < 0.01) < 0.2
