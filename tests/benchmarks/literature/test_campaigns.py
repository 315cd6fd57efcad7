"""The generator: same seed, same data; plausible loads; metadata; truth."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.literature import Case, cases, make, quick
from benchmarks.literature.collection import check_catalogue
from benchmarks.literature.noise import RECIPES, TEN
from benchmarks.literature.registry import REGISTER, catalogue_laws, outside_laws

#: What they look at changes with the benchmark alone.
pytestmark = pytest.mark.nightly

COLUMNS = ["test_id", "t", "v_rel", "T", "sigma_n", "sd", "psi", "mu"]


def _case(
    kind: str = "single",
    laws: tuple[str, ...] = ("stribeck_rational",),
    recipe: str = "plain",
    seed: int = 3,
    **more: object,
) -> Case:
    return Case(f"t-{kind}-{recipe}-{seed}", kind, laws, recipe, seed, points=60, n_heldout=6, **more)  # type: ignore


def test_same_seed_same_campaign_other_seed_other_campaign() -> None:
    a, b, c = make(_case()), make(_case()), make(_case(seed=4))
    pd.testing.assert_frame_equal(a.data, b.data)
    pd.testing.assert_frame_equal(a.heldout_data, b.heldout_data)
    assert a.record == b.record
    assert len(a.data) != len(c.data) or not np.allclose(a.data["mu"], c.data["mu"])


def test_counts_and_unique_names() -> None:
    everything, some = cases(), quick()
    assert 230 <= len(everything) <= 290
    assert 35 <= len(some) <= 45
    assert len({c.id for c in everything}) == len(everything)
    assert len({c.seed for c in everything}) == len(everything)
    assert {c.id for c in some} <= {c.id for c in everything}
    assert len({c.id for c in some}) == len(some)
    assert cases() == everything


def test_contents_asked_for() -> None:
    found = check_catalogue()
    assert found["catalogue"] >= 15 and found["outside"] >= 5
    assert len(TEN) == 10
    assert {c.recipe for c in cases() if c.kind == "null"} == set(RECIPES)
    used = {key for c in cases() if c.kind in ("single", "outside") for key in c.laws}
    assert used == set(REGISTER)


@pytest.mark.parametrize("recipe", list(RECIPES))
def test_every_recipe_gives_plausible_tables(recipe: str) -> None:
    campaign = make(_case("null", (), recipe))
    data, tests = campaign.data, campaign.tests
    assert list(data.columns) == COLUMNS
    assert np.isfinite(data[COLUMNS[1:]].to_numpy()).all()
    assert tests is not None and set(data["test_id"]) == set(tests["test_id"])
    assert data["mu"].between(-0.05, 0.4).all()
    assert campaign.mu_true.min() > 0.01 and campaign.mu_true.max() < 0.3
    assert data["T"].between(10.0, 1250.0).all()
    assert data["sigma_n"].between(400.0, 3100.0).all()
    assert data["v_rel"].between(0.0, 515.0).all()
    assert data["psi"].between(1.0, 22.0).all()
    if RECIPES[recipe].averaged:
        assert (data.groupby("test_id").size() == 1).all()
    else:
        assert (data.groupby("test_id").size() == 60).all()
        assert (data.groupby("test_id")["t"].diff().dropna() > 0.0).all()


def test_loads_look_like_a_sliding_compression_test() -> None:
    campaign = make(Case("t", "null", (), "plain", 20_001, points=550))
    assert campaign.tests is not None
    fast = campaign.tests.query("v_set > 300 and sigma_set > 1500")["test_id"]
    one = campaign.data[campaign.data["test_id"] == fast.iloc[0]]
    v, sigma, T = (one[c].to_numpy() for c in ("v_rel", "sigma_n", "T"))
    assert v[0] < 0.5 * v[-1]
    assert 0.9 < sigma[-20:].mean() / sigma[:20].mean() < 1.0
    assert T[-1] > T[0] + 30.0
    assert np.allclose(np.diff(one["sd"]), 0.1, atol=1e-6)


def test_metadata_is_independent_of_loads_and_headed_as_asked() -> None:
    tests = make(_case("null", ())).tests
    assert tests is not None
    for column in (
        "order",
        "batch",
        "tool_id",
        "Ra",
        "t_wait",
        "T_tool",
        "v_set",
        "sigma_set",
        "psi_set",
    ):
        assert column in tests.columns
    for system in ("order", "Ra", "t_wait", "film_weight", "humidity"):
        assert abs(np.corrcoef(tests[system], tests["sigma_set"])[0, 1]) < 0.45
    assert tests["test_id"].is_unique


def test_truth_is_the_record_without_scatter() -> None:
    campaign = make(_case())
    difference = (campaign.data["mu"] - campaign.mu_true).groupby(campaign.data["test_id"]).mean()
    assert 0.4 < difference.std() / campaign.record["test_sd"] < 1.8


def test_null_is_linear_and_a_law_is_not() -> None:
    def error(campaign: object, by: str) -> float:
        return float(np.sqrt(np.mean((getattr(campaign, by) - campaign.heldout_mu) ** 2)))  # type: ignore

    null = make(_case("null", ()))
    assert error(null, "linear_mu") < 0.6 * null.record["test_sd"]
    law = make(_case(ratio=(2.0, 2.5)))
    assert error(law, "floor_mu") < 0.4 * error(law, "linear_mu")


def test_heldout_tests_are_other_tests_inside_the_ranges() -> None:
    campaign = make(_case())
    assert campaign.tests is not None and "mu" not in campaign.heldout_data
    assert not set(campaign.heldout_tests["test_id"]) & set(campaign.tests["test_id"])
    for column in ("v_set", "sigma_set", "psi_set"):
        assert (
            campaign.heldout_tests[column]
            .between(campaign.tests[column].min(), campaign.tests[column].max())
            .all()
        )
    assert len(campaign.heldout_mu) == len(campaign.heldout_data) == len(campaign.floor_mu)


@pytest.mark.slow
@pytest.mark.parametrize("law", [law.key for law in (*catalogue_laws(), *outside_laws())])
def test_every_law_is_visible_finite_and_recorded(law: str) -> None:
    campaign = make(_case(laws=(law,), ratio=(1.0, 1.0), seed=5))
    entry = campaign.record["laws"][0]
    assert np.isfinite(campaign.mu_true).all() and np.isfinite(campaign.heldout_mu).all()
    assert entry["amplitude"] > 0.0 and 0.1 < entry["ratio"] < 2.5
    assert campaign.mu_true.min() > 0.005 and campaign.mu_true.max() < 0.35
    assert campaign.record["label"] == "SYNTHETIC"


@pytest.mark.parametrize("case", [c for c in cases(30) if c.kind in ("thin", "foreign")], ids=lambda c: c.id)
def test_thin_and_foreign_tables_can_be_made(case: Case) -> None:
    campaign = make(case)
    assert len(campaign.data) == len(campaign.mu_true) > 0
    assert np.isfinite(campaign.data["mu"]).all()


def test_unknown_things_are_named() -> None:
    with pytest.raises(KeyError, match="no law 'nonsense'"):
        make(_case(laws=("nonsense",)))
    with pytest.raises(ValueError, match="kind"):
        Case("x", "strange", (), "plain", 1)
