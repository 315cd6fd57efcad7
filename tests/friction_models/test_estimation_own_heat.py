"""Temperatures without the heat of a test's own friction."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.campaign.own_heat import without_own_heat

LAW = 0.08


def heated(
    seed: int, own: float = 1.0, tests: int = 60, points: int = 12
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return a constant law whose tests scatter, each heated by its own friction (`own` = 1) or by that of the law (0)."""
    rng = np.random.default_rng([seed, 4])
    parts, rows = [], []
    for k in range(tests):
        v, sigma, tool = (
            rng.choice([5.0, 200.0, 500.0]),
            rng.choice([500.0, 1750.0, 2750.0]),
            rng.choice([20.0, 150.0]),
        )
        offset = rng.normal(0.0, 0.006)
        heating = (LAW + own * offset) * sigma * np.sqrt(v) * 0.06 * (1.0 + 0.02 * rng.normal())
        sd = np.linspace(0.5, 50.0, points)
        T = tool + heating * (0.4 + 0.6 * np.sqrt(sd / 50.0))
        loads = {"v_rel": v, "T": T, "sigma_n": sigma, "sd": sd, "psi": 1.2}
        mu = LAW + offset + rng.normal(0.0, 0.001, points)
        parts.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu}))
        rows.append({"test_id": f"t{k:02d}", "T_tool": tool})
    return pd.concat(parts, ignore_index=True), pd.DataFrame(rows)


def link(campaign: BinnedTests) -> float:
    """Return how mean temperature and level of the tests are tied beside the set points (partial correlation)."""
    weight = np.bincount(campaign.test, campaign.count)

    def level(values: np.ndarray) -> np.ndarray:
        return np.bincount(campaign.test, campaign.count * campaign.average(values)) / weight

    loads = campaign.loads
    cells = pd.MultiIndex.from_arrays(
        [
            level(loads.v_rel).round(),
            level(loads.sigma_n).round(),
            level(campaign.system["T_tool"][:, 0]).round(),
        ]
    )
    heating = np.log(level(loads.T) - level(campaign.system["T_tool"][:, 0]))
    table = pd.DataFrame({"T": heating, "mu": level(campaign.mu)}, index=cells)
    rest = table - table.groupby(level=[0, 1, 2]).transform("mean")
    return float(np.corrcoef(rest["T"], rest["mu"])[0, 1])


def test_the_tie_of_temperature_and_offset_goes() -> None:
    data, tests = heated(0)
    campaign = prepare(data, tests)
    assert link(campaign) > 0.8
    assert abs(link(without_own_heat(campaign))) < 0.35


@pytest.mark.nightly
def test_scatter_that_heats_its_own_test_is_no_effect() -> None:
    answers = [diagnose(*heated(seed)) for seed in range(6)]
    assert sum(a.verdict != "nothing_missing" for a in answers) <= 1


@pytest.mark.nightly
def test_an_effect_of_temperature_is_still_found() -> None:
    found = 0
    for seed in range(3):
        data, tests = heated(20 + seed)
        step = 0.02 / (1.0 + ((data["T"] - 20.0) / 230.0) ** -6.0)
        answer = diagnose(data.assign(mu=data["mu"] + step), tests)
        found += "thermal_breakdown" in answer.confusion_set
    assert found >= 2


def test_temperatures_that_were_set_stay() -> None:
    rng = np.random.default_rng(3)
    data, tests = heated(1)
    set_by_hand = dict(zip(tests["test_id"], rng.uniform(20.0, 400.0, len(tests)), strict=True))
    data = data.assign(T=data["test_id"].map(set_by_hand) + 0.1 * data["sd"])
    campaign = prepare(data)
    assert pytest.approx(campaign.loads.T, abs=1.0) == without_own_heat(campaign).loads.T
    few = prepare(data[data["test_id"] < "t05"])
    assert without_own_heat(few) is few


def test_no_step_appears_along_a_test() -> None:
    data, tests = heated(2, points=200)
    campaign = prepare(data, tests)
    moved = without_own_heat(campaign).loads.T - campaign.loads.T
    assert np.abs(moved).max() > 1.0
    same = campaign.point_test[1:] == campaign.point_test[:-1]
    assert np.abs(np.diff(moved))[same].max() < 0.2 * np.abs(moved).max()
