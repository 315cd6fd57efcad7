"""Dates in the column `order` of a test table number the tests as they were run; other texts are told, and not used."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose, refine
from friction_models.estimation.campaign.binning import prepare

DAYS = pd.date_range("2024-01-28", periods=24, freq="D")


def drifting() -> tuple[pd.DataFrame, np.ndarray]:
    """Return single means of a law that falls with speed, shifted a little more from test to test, and their places in the order."""
    rng = np.random.default_rng(4)
    place = rng.permutation(24)
    data = pd.DataFrame({"test_id": [f"t{k:02d}" for k in range(24)], "v_rel": rng.uniform(5.0, 200.0, 24)})
    mu = 0.1 - 1e-4 * data["v_rel"] + 1e-3 * place + rng.normal(0.0, 0.001, 24)
    return data.assign(mu=mu), place


@pytest.mark.parametrize(
    "written", ["%Y-%m-%d", "%d.%m.%Y", "%Y-%m-%dT%H:%M:%S+01:00", "%d.%m.%Y %H:%M", None]
)
def test_dates_are_the_order_of_the_tests(written: str | None) -> None:
    data, place = drifting()
    numbers = pd.DataFrame({"test_id": data["test_id"], "order": place + 1})
    dates = [DAYS[k] if written is None else DAYS[k].strftime(written) for k in place]
    model = refine(data, numbers.assign(order=dates), add="sensor_drift")
    expected = refine(data, numbers, add="sensor_drift")
    assert model.amplitudes_ == expected.amplitudes_
    assert expected.amplitudes_[0]["k_d"] == pytest.approx(0.1, rel=0.1)


def test_other_texts_are_told_and_not_used() -> None:
    data, place = drifting()
    table = pd.DataFrame({"test_id": data["test_id"], "order": [f"run {k + 1}" for k in place]})
    campaign = prepare(data, table)
    assert "order" not in campaign.system
    assert any("order" in w and "'run " in w and "2024-01-31" in w for w in diagnose(data, table).warnings)
    # one slip among numbers, too
    table["order"] = ["24b", *map(str, place[1:])]
    assert any("'24b'" in w for w in prepare(data, table).warnings)
