"""Tests in another unit are told; wide plans are not."""

from __future__ import annotations

import numpy as np
import pytest

from friction_models.estimation.campaign.binning import prepare

from .estimation_cases import measured


@pytest.mark.parametrize(("name", "unit"), [("sigma_n", "MPa"), ("v_rel", "mm/s"), ("sd", "mm")])
@pytest.mark.parametrize("some", [1, 6])
def test_tests_in_another_unit_are_told(name: str, unit: str, some: int) -> None:
    data = measured(np.random.default_rng(4), tests=24, points=5)
    ids = sorted(data["test_id"].unique())[:some]
    data.loc[data["test_id"].isin(ids), name] /= 1000.0
    (said,) = (w for w in prepare(data).warnings if "another unit" in w)
    assert f"{name} of {some} test" in said and f"{unit} is expected" in said and ids[0] in said


def test_loads_of_a_plan_are_in_one_unit() -> None:
    data = measured(np.random.default_rng(4), tests=24, points=5)
    levels = dict(zip(sorted(data["test_id"].unique()), np.repeat([0.1, 2.0, 40.0, 800.0], 6), strict=True))
    for wide in (data, data.assign(v_rel=data["test_id"].map(levels)), data.assign(v_rel=0.0)):
        assert not any("another unit" in w for w in prepare(wide).warnings)
