"""Tests of one coating or batch that follow a law of their own: an offset of the level does not explain them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.causes.own_laws import own_law
from friction_models.estimation.campaign.binning import prepare

TESTS, POINTS = 40, 20


def campaign_of(seed: int, law: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return records of tests with four coatings. Of one of them friction rises halfway, or falls with temperature, or nothing differs."""
    rng = np.random.default_rng([seed, 77])
    table = pd.DataFrame(
        {
            "test_id": [f"c{k:02d}" for k in range(TESTS)],
            "coating": rng.permutation(np.resize(["none", "nitrided", "DLC", "TiN"], TESTS)),
            "T_tool": rng.choice([20.0, 80.0, 140.0, 200.0], TESTS),
            "v": rng.choice([5.0, 20.0, 80.0], TESTS),
        }
    )
    share = np.linspace(0.0, 1.0, POINTS)
    parts = []
    for row in table.itertuples():
        mu = 0.08 + 0.0001 * (row.T_tool - 110.0) + rng.normal(0.0, 0.004) + rng.normal(0.0, 0.002, POINTS)
        if row.coating == "DLC" and law == "late":
            mu = mu + 0.04 / (1.0 + np.exp((0.5 - share) / 0.07))
        if row.coating == "DLC" and law == "hot":
            mu = mu - 0.03 * (row.T_tool - 110.0) / 90.0
        loads = {
            "sd": 40.0 * share,
            "v_rel": row.v,
            "T": row.T_tool + 5.0 * share,
            "sigma_n": 500.0,
            "mu": mu,
        }
        parts.append(pd.DataFrame({"test_id": row.test_id, "t": 40.0 * share / row.v, **loads}))
    return pd.concat(parts, ignore_index=True), table.drop(columns="v")


@pytest.mark.parametrize(("law", "said"), [("late", "sd"), ("hot", "T")])
def test_something_is_left_along_the_coating(law: str, said: str) -> None:
    """A coating that fails late was "explained by an offset of the coating", 0.95 sure; one that fails hot was noise."""
    for seed in range(3):
        found = diagnose(*campaign_of(seed, law))
        assert found.verdict in ("unknown_structure", "partly_explained"), found.sentence
        assert any({"coating", said} == {*p["variables"]} for p in found.where), found.where


def test_chance_is_hardly_ever_told() -> None:
    told = 0
    for seed in range(60):
        campaign = prepare(*campaign_of(seed, "none"))
        told += own_law(campaign, campaign.average(campaign.mu - campaign.mu.mean())) is not None
    assert told <= 2


def test_one_wrong_test_is_no_law_of_its_level() -> None:
    points, table = campaign_of(1, "none")
    wrong = table["test_id"][table["coating"] == "DLC"].iloc[0]
    points.loc[points["test_id"] == wrong, "mu"] += np.linspace(0.0, 0.1, POINTS)
    campaign = prepare(points, table)
    assert own_law(campaign, campaign.average(campaign.mu - campaign.mu.mean())) is None


def test_the_reference_follows_a_level_with_few_tests() -> None:
    """Products of the distance with the two levels of most tests left out the coating that failed: "explained", 0.95 sure."""
    points, table = campaign_of(3, "late")
    others = table["coating"] != "DLC"
    few = pd.concat([table[others], table[~others].head(6)])
    found = diagnose(points[points["test_id"].isin(few["test_id"])], few)
    assert found.verdict in ("partly_explained", "unknown_structure"), found.sentence
    assert any("coating" in p["variables"] for p in found.where)
