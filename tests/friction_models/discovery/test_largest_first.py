"""Of several effects the one that carries most of the error on unseen tests leads, each with its own rivals."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.judge.naming.rivals import Rivals

PRESSURE = {"pressure_saturation", "pressure_power"}


def large_between_and_small_along(seed: int) -> pd.DataFrame:
    """Return 40 tests at rising loads: mu falls by 0.05 with the load, and rises by 0.012 along every test, which many points show."""
    rng = np.random.default_rng([seed, 4])
    sd = np.linspace(0.0, 600.0, 25)
    frames = []
    for k, sigma in enumerate(np.geomspace(20.0, 400.0, 40)):
        level = 0.10 + 0.06 / (1.0 + (sigma / 60.0) ** 1.5) + rng.normal(0.0, 0.004)
        mu = level + 0.012 * (1.0 - np.exp(-sd / 80.0)) + rng.normal(0.0, 0.001, len(sd))
        frames.append(
            pd.DataFrame(
                {"test_id": f"t{k:02d}", "t": sd / 10.0, "v_rel": 10.0, "sigma_n": sigma, "sd": sd, "mu": mu}
            )
        )
    return pd.concat(frames, ignore_index=True)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.nightly)])
def test_a_small_rise_that_many_points_show_does_not_lead(seed: int) -> None:
    found = diagnose(large_between_and_small_along(seed))
    assert found.verdict == "ambiguous" and found.effects[0] in PRESSURE
    assert found.effects[1:] == ["running_in"]
    told = found.confusion_set
    assert "rate_state" in told[told.index("running_in") :]  # what runs in has rivals of its own
    assert PRESSURE & set(told[1 : told.index("running_in")])


def test_a_name_that_carries_more_than_twice_as_much_leads() -> None:
    """Without the one unseen tests lose 4 of 10, without the other 3, or 1: the search knows more than they do of what is close."""
    first, second = (cast(Any, SimpleNamespace(name=name)) for name in ("first", "second"))
    for carried, led in ((3.0, ["first", "second"]), (1.0, ["second", "first"])):
        left = {("first", "second"): 1.0, ("first",): 5.0, ("second",): 1.0 + carried}

        def errors(kept: list[Any], left: dict[Any, float] = left) -> Any:
            return SimpleNamespace(rms=left[tuple(sorted(f.name for f in kept))] ** 0.5)

        straight = cast(Any, SimpleNamespace(errors=errors))
        rivals = Rivals(cast(Any, None), cast(Any, None), straight, cast(Any, None))
        assert [f.name for f in rivals.largest_first([first, second])] == led
