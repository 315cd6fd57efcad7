"""Structure that no effect explains: planted interactions and curves, and the rate where there is none."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import kstest

from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.structure import find_structure, places_of

from .estimation_cases import measured, searched


def planted(
    seed: int, kind: str = "", size: float = 0.006, tests: int = 60, points: int = 12
) -> tuple[pd.DataFrame, float]:
    """Return measurements with a planted dependence, and the rms of what a linear base cannot follow of it."""
    data = measured(np.random.default_rng([seed, 9]), tests=tests, points=points, between=0.002)
    z = {n: (data[n] - data[n].mean()) / data[n].std() for n in ("v_rel", "sigma_n", "T")}
    values = {"": 0.0 * z["T"], "product": z["v_rel"] * z["sigma_n"], "bent": z["T"] ** 2}[kind].to_numpy()
    loads = np.column_stack([np.ones(len(data)), *z.values()])
    beyond = values - loads @ np.linalg.lstsq(loads, values, rcond=None)[0]
    return data.assign(mu=data["mu"] + size * values), size * float(np.std(beyond))


def test_a_planted_interaction_is_found_where_it_is() -> None:
    for seed in range(3):
        data, rms = planted(seed, "product")
        campaign, found = searched(data)
        structure = find_structure(campaign, found, np.empty((len(found.y), 0)), seed)
        first = structure.where[0]
        assert structure.p_value < 0.01 and structure.excess > 100.0
        assert first["variables"] == ["v_rel", "sigma_n"] and first["shape"] == "interaction"
        assert structure.rms == pytest.approx(rms, rel=0.15)
        assert first["share"] == pytest.approx(structure.excess / float(found.residual @ found.residual))


def test_a_planted_curve_is_found_along_its_load() -> None:
    data, rms = planted(4, "bent")
    campaign, found = searched(data)
    structure = find_structure(campaign, found, np.empty((len(found.y), 0)), 0)
    assert [w["variables"] for w in structure.where] == [["T"]], "surfaces over T hold the same curve"
    assert structure.where[0]["shape"] == "bent"
    assert structure.rms == pytest.approx(rms, rel=0.15)


def test_an_effect_that_explains_it_leaves_nothing() -> None:
    data, _ = planted(5, "bent")
    campaign, found = searched(data)
    T = campaign.average(campaign.loads.T)
    structure = find_structure(campaign, found, found.whiten((T - T.mean())[:, None] ** 2), 0)
    assert structure.p_value > 0.05 and structure.where == []


def test_p_values_are_uniform_where_nothing_is_left() -> None:
    values = []
    for seed in range(30):
        campaign, found = searched(planted(100 + seed, tests=29, points=4)[0], seed)
        values.append(find_structure(campaign, found, np.empty((len(found.y), 0)), seed).p_value)
    assert kstest(values, "uniform").pvalue > 0.01


def test_a_distance_that_no_average_tells_is_named_nowhere() -> None:
    data, _ = planted(4, "bent", size=0.02)
    averages = data.groupby("test_id", as_index=False).mean(numeric_only=True)
    averages["sd"] = np.linspace(5.0, 40.0, len(averages))
    campaign, found = searched(averages)
    structure = find_structure(campaign, found, np.empty((len(found.y), 0)), 0)
    assert campaign.varies("sd") and structure.where
    assert not any("sd" in place["variables"] for place in structure.where)


@pytest.mark.parametrize("crossed", [False, True])
def test_a_surface_is_named_only_where_there_is_one(crossed: bool) -> None:
    """Of 40 tests, the columns of a surface follow much of what differs from test to test by chance."""
    named = []
    for seed in range(20):
        rng = np.random.default_rng([seed, 3])
        data = measured(rng, tests=40, points=8, between=0.0)
        campaign = prepare(data)
        T, p = (campaign.average(getattr(campaign.loads, n)) for n in ("T", "sigma_n"))
        T, p = (x / np.max(x) - 0.5 for x in (T, p))
        law = 4.0 * T * p if crossed else 3.0 * T**2
        others = 0.8 * np.std(law) * rng.standard_normal(40)[campaign.test]
        named.append(places_of(campaign, law + others, [])[0]["variables"])
    right = ["T", "sigma_n"] if crossed else ["T"]
    assert sum(n == right for n in named) >= 16


def test_a_curve_is_not_told_again_along_a_load_that_goes_with_it() -> None:
    """What a wave along T leaves beside its curve is small, but surfaces over loads tied to T follow much of the wave itself."""
    rng = np.random.default_rng(7)
    data = measured(rng, tests=40, points=8, between=0.0)
    campaign = prepare(data)
    T = campaign.average(campaign.loads.T)
    wave = np.sin(2.0 * np.pi * (T - T.min()) / np.ptp(T))
    tied = [w["variables"] for w in places_of(campaign, wave, [])]
    assert tied == [["T"]]
    several = places_of(campaign, wave + campaign.average(campaign.loads.sigma_n) / 1000.0, [])
    assert sorted(w["variables"] for w in several) == [["T"], ["sigma_n"]]
    assert sum(w["share"] for w in several) <= 1.0


def test_a_difference_along_one_load_is_said_of_it_where_there_are_few_tests() -> None:
    """Curves in the order of 40 tests, with products, follow nearly anything."""
    rng = np.random.default_rng(6)
    names = [f"t{k:02d}" for k in range(40)]
    loads = {
        "v_rel": np.exp(rng.uniform(1.0, 6.0, 40)),
        "T": rng.uniform(20.0, 250.0, 40),
        "sigma_n": rng.uniform(300.0, 2200.0, 40),
    }
    tests = pd.DataFrame(
        {"test_id": names, "order": rng.permutation(40) + 1.0, "days": rng.gamma(2.0, 3.0, 40)}
    )
    campaign = prepare(pd.DataFrame({"test_id": names, **loads, "mu": 0.1}), tests)
    # what a reference makes of a valley along the pressure: the valley, and a little of all else
    valley = 0.01 * np.abs((loads["sigma_n"] - 1150.0) / 600.0) ** 1.7 + rng.normal(0.0, 0.003, 40)
    assert places_of(campaign, valley, ["order", "days"])[0]["variables"] == ["sigma_n"]
    wave = 0.01 * np.sin(2.0 * np.pi * tests["order"].to_numpy() / 15.0) + rng.normal(0.0, 0.002, 40)
    assert places_of(campaign, wave, ["order", "days"])[0]["variables"] == ["order"]
