"""Single odd tests: the same ones whatever the tests are called."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.estimation.campaign.binning import BinnedTests, prepare
from friction_models.estimation.noise.noise_floor import NoiseFloor
from friction_models.estimation.noise.odd_tests import odd_tests
from friction_models.estimation.search.base_law import base_law

from .estimation_cases import measured

SCATTER = 0.003


def odd_in(data: pd.DataFrame) -> list[str]:
    """Return the odd tests of a campaign beside a linear base."""
    campaign: BinnedTests = prepare(data)
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
