"""Single odd tests: the same ones whatever the tests are called, and whichever others were measured."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.estimation.campaign.binning import Campaign, prepare
from friction_models.estimation.noise.noise_floor import NoiseFloor
from friction_models.estimation.noise.odd_tests import odd_tests
from friction_models.estimation.search.base_law import base_law

from .estimation_cases import measured

SCATTER = 0.003


def odd_in(data: pd.DataFrame) -> list[str]:
    """Return the odd tests of a campaign beside a linear base."""
    campaign: Campaign = prepare(data)
    floor = NoiseFloor(0.001, SCATTER, 1e-5, 3.0, (0.0, 0.0), 0.001)
    return odd_tests(campaign, campaign.average(base_law(LinearFriction(), campaign).columns), floor)


def shifted(data: pd.DataFrame, by: dict[str, float]) -> pd.DataFrame:
    """Return the points with the mu of whole tests shifted."""
    return data.assign(mu=data["mu"] + data["test_id"].map(by).fillna(0.0))


@pytest.mark.parametrize("seed", range(4))
def test_names_of_tests_do_not_decide_which_one_is_odd(seed: int) -> None:
    """A test at the edge of what counts as odd, beside a ridge in pressure that is no line."""
    data = measured(np.random.default_rng(seed), tests=40, points=6, between=SCATTER)
    ridge = 0.01 / np.cosh((data["sigma_n"] - 1500.0) / 400.0)
    data = shifted(data.assign(mu=data["mu"] + ridge), {"t020": 5.0 * SCATTER})
    names = np.array(sorted(data["test_id"].unique()))
    said = set()
    for draw in range(8):
        other = dict(zip(names, np.random.default_rng(draw).permutation(names), strict=True))
        found = odd_in(data.assign(test_id=data["test_id"].map(other)))
        said.add(tuple(sorted(name for name in names if other[name] in found)))
    assert len(said) == 1


def test_the_oddest_of_tests_that_scatter_unevenly_stays_odd_without_some_others() -> None:
    """A seventh of the tests scatters five times as much: whether these are many or few must not decide on the one far off."""
    far = "t060"
    found = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        data = measured(rng, tests=100, points=4, between=SCATTER)
        wide = {f"t{k:03d}": float(s) for k, s in zip(range(2, 100, 7), 5.0 * SCATTER * rng.normal(size=14))}
        data = shifted(data, {**wide, far: 25.0 * SCATTER})
        names = np.array(sorted(data["test_id"].unique()))
        for _ in range(5):
            kept = names[(rng.random(len(names)) > 0.1) | (names == far)]
            found.append(odd_in(data[data["test_id"].isin(kept)]))
    assert all(far in odd for odd in found)
    assert max(len(odd) for odd in found) <= 5
