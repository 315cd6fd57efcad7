"""A name that one test makes up is told from one that many tests show."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.discovery.causes.one_test import resting_on_one
from friction_models.effects import make_effect
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.base_law import base_law
from friction_models.estimation.search.candidates import evaluate, spans_of
from friction_models.estimation.search.search_round import search

from ..estimation_cases import measured


def breakdown_rests_on(data: pd.DataFrame) -> dict[str, str]:
    """Return what is said of a breakdown with temperature that is named beside a line."""
    campaign, effect = prepare(data), make_effect("thermal_breakdown")
    known = evaluate(effect, campaign, campaign.mu, effect.grids(spans_of(campaign, campaign.mu)))
    found = search(campaign, base_law(LinearFriction(), campaign), None, [known], 0)
    assert resting_on_one(campaign, found, []) == {}
    return resting_on_one(campaign, found, found.ranking[:1])


@pytest.mark.parametrize("seed", range(4))
def test_a_name_that_one_test_makes_up_rests_on_it(seed: int) -> None:
    data = measured(np.random.default_rng([seed, 5]), tests=24, points=10, between=0.003)
    hottest = data.groupby("test_id")["T"].mean().idxmax()
    data.loc[data["test_id"] == hottest, "mu"] += 0.05
    assert breakdown_rests_on(data) == {"thermal_breakdown": hottest}


@pytest.mark.parametrize("seed", range(4))
def test_a_name_that_many_tests_show_rests_on_none(seed: int) -> None:
    """A step that the six or so hottest of 24 tests have gone up: the hottest of them holds no more than its part."""
    data = measured(np.random.default_rng([seed, 5]), tests=24, points=10, between=0.003)
    data["mu"] += 0.015 * (1.0 + np.tanh((data["T"] - 220.0) / 12.0))
    assert breakdown_rests_on(data) == {}


@pytest.mark.parametrize("seed", range(4))
def test_a_test_that_shows_a_name_along_its_path_is_no_wrong_level(seed: int) -> None:
    """It is heated through the breakdown, which hardly another test reaches: what was asked for to settle the name made it doubtful."""
    data = measured(np.random.default_rng([seed, 5]), tests=24, points=10, between=0.003)
    T = data.groupby("test_id")["T"].transform("mean")
    data["T"] *= 180.0 / T.max()
    heated = data["test_id"] == data["test_id"].iloc[0]
    data.loc[heated, "T"] = np.linspace(120.0, 330.0, heated.sum())
    data["mu"] += 0.03 * (1.0 + np.tanh((data["T"] - 240.0) / 20.0))
    assert breakdown_rests_on(data) == {}
