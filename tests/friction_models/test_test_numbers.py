"""Tables of tests in which a few cells are no numbers, or a role is blank."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models import DataSet, LinearFriction
from friction_models.common import InputError
from friction_models.discovery import diagnose
from friction_models.estimation.campaign.binning import prepare
from friction_models.loads import TriboLoads
from friction_models.training.evaluation import train

from .estimation_cases import measured


def damp() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return 16 tests in which mu rises with the humidity of the air, which was read to a tenth of a percent."""
    rng = np.random.default_rng(5)
    data = measured(rng, tests=16, points=12, between=0.003)
    names = data["test_id"].unique()
    humidity = rng.uniform(25.0, 75.0, len(names)).round(1)
    data["mu"] += data["test_id"].map(dict(zip(names, 0.0006 * humidity, strict=True)))
    return data, pd.DataFrame({"test_id": names, "humidity": humidity})


@pytest.mark.parametrize(
    "text", ["59.3 %", *(pytest.param(t, marks=pytest.mark.nightly) for t in ("n.m.", "-"))]
)
def test_one_cell_that_is_no_number_is_told_and_hides_nothing(text: str) -> None:
    data, tests = damp()
    tests["humidity"] = tests["humidity"].astype(object)
    tests.loc[4, "humidity"] = text
    found = diagnose(data, tests=tests)
    assert found.effects == ["factor:humidity"], found.sentence
    told = [w for w in found.warnings if repr(text) in w]
    assert len(told) == 1 and "humidity of the test t004" in told[0]


def test_a_decimal_comma_is_one() -> None:
    data, tests = damp()
    tests["humidity"] = tests["humidity"].map(lambda h: f"{h}".replace(".", ","))
    assert diagnose(data, tests=tests).effects == ["factor:humidity"]


def test_labels_stay_labels() -> None:
    data = measured(np.random.default_rng(1), tests=16, points=5)
    labels = ["1", "2", "3", "X"] * 4
    tests = pd.DataFrame({"test_id": data["test_id"].unique(), "batch": labels})
    column = TriboLoads.from_frame(data, tests).context_column("batch")
    assert column is not None and set(column) == set(labels)
    assert not any("batch" in w for w in prepare(data, tests).warnings)


def test_a_test_without_a_role_is_for_training() -> None:
    data = measured(np.random.default_rng(2), tests=12, points=5)
    names = data["test_id"].unique()
    roles = pd.DataFrame({"test_id": names[:11], "role": ["train"] * 7 + ["test"] * 2 + [None, " "]})
    found = DataSet(data, roles)
    assert found.select("train").points["test_id"].nunique() == 10  # the one that is not listed as well
    assert found.select("test").points["test_id"].nunique() == 2
    assert train(LinearFriction(), found).roles["train"]["points"] == 50  # the same ones


def test_an_uncertainty_that_is_no_number_is_refused_with_what_it_is() -> None:
    data = measured(np.random.default_rng(2), tests=3, points=5).assign(u_T=[1.0] * 14 + ["x"])
    with pytest.raises(InputError, match="'u_T', row 14: 'x'"):
        TriboLoads.from_frame(data)
