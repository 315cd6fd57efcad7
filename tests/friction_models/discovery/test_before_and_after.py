"""Errors before and after an addition have the intervals that `compare` gives, and say whether the fall is more than chance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.discovery_campaigns import campaign
from friction_models import ComposedFriction, LinearFriction, load_model
from friction_models.common import InputError
from friction_models.discovery import compare, refine
from friction_models.discovery.refinement_rounds import history_text
from friction_models.discovery.resampling import before_and_after
from friction_models.families.refinement_history import checked_round


def test_they_are_those_of_compare(tmp_path: Any) -> None:
    points, tests, _ = campaign("wear_out", seed=21, strength=1.0, thin=10)
    model = refine(points, tests, model=LinearFriction(), add=["wear_out"])
    entry = model.error_history_[-1]  # type: ignore[attr-defined]
    held = points["test_id"].isin(tests.loc[tests["role"] == "test", "test_id"]).to_numpy()
    plain = LinearFriction().fit_frame(points[~held], tests)
    found = compare({"before": plain, "after": model}, points[held], tests)
    for when in ("before", "after"):
        errors = found.errors[when]
        assert entry["intervals"][when]["rmse"] == pytest.approx(errors.rmse_interval)
        assert entry["intervals"][when]["mae"] == pytest.approx(errors.mae_interval)
        low, high = entry["intervals"][when]["rmse"]
        assert low < entry[when]["rmse"] < high
    assert entry["clear"] is True and found.clear
    low, high = entry["intervals"]["fall"]["rmse"]
    assert 0.0 < low < entry["before"]["rmse"] - entry["after"]["rmse"] < high
    assert "more than chance" in history_text([entry])
    model.save(tmp_path / "better")
    kept = load_model(tmp_path / "better")
    assert isinstance(kept, ComposedFriction) and kept.error_history_ == [entry]


def test_a_fall_that_comes_from_one_test_may_be_chance() -> None:
    """The same errors but in one test of ten, which is better by much: many sets of tests are drawn without it."""
    group = np.repeat(np.arange(10), 20)
    before = np.where(np.arange(200) % 2, 0.005, -0.005)
    after = np.where(group == 0, 0.0, before) * 1.01
    change = before_and_after(before, after, group)
    assert np.mean(after**2) < np.mean(before**2) and not change.fell and not change.rose
    fall = change.intervals["fall"]["rmse"]
    assert fall is not None and fall[0] < 0.0 < fall[1]
    # Fewer than six tests never show more than chance, and one shows no interval.
    assert not before_and_after(before[:100], 0.5 * before[:100], group[:100]).fell
    alone = before_and_after(before[:20], 0.5 * before[:20], group[:20])
    assert alone.intervals["fall"] == {"rmse": None, "mae": None} and not alone.fell
    # What differs by rounding alone neither fell nor rose.
    rounded = before_and_after(before, before * (1.0 - 1e-9), group)
    assert not rounded.fell and not rounded.rose


def test_a_certain_rise_is_not_said_to_be_chance() -> None:
    rise = {"before": [0.0040, 0.0046], "after": [0.0043, 0.0049], "fall": [-0.00042, -0.00009]}
    errors = {when: {"rmse": value, "mae": value} for when, value in (("before", 0.0043), ("after", 0.0046))}
    entry: dict[str, Any] = {"added": ["a"], "judged_by": "9 tests", **errors, "clear": False}
    entry["intervals"] = {when: {"rmse": found, "mae": found} for when, found in rise.items()}
    said = "higher by 0.00009 to 0.00042: more than chance"
    for known in ({"rose": True}, {}):  # older files do not have it
        assert said in history_text([entry | known]) and "may be chance" not in history_text([entry | known])
    # Too few tests for that, which the interval alone does not show.
    assert "may be chance" in history_text([entry | {"rose": False}])


def test_a_rise_is_judged_as_a_fall_is() -> None:
    """In the tests of the fit mu falls with temperature; in the others it is level, which a constant knows better."""
    tests = np.arange(13)
    T, held = 20.0 + 9.0 * (tests % 7), tests > 4
    mu = np.where(held, 0.094, 0.1 - 0.003 * (tests % 7)) + 0.0002 * (tests % 3)
    data = pd.DataFrame({"test_id": np.repeat(tests, 6), "sd": np.tile(2.0 * np.arange(6), 13)})
    data = data.assign(T=np.repeat(T, 6), mu=np.repeat(mu, 6))
    table = pd.DataFrame({"test_id": tests, "role": np.where(held, "test", "train")})
    model = refine(data, table, model="constant", add="thermal_softening", force=True)
    entry = model.error_history_[-1]  # type: ignore[attr-defined]
    assert entry["rose"] is True and entry["clear"] is False and checked_round(entry) == entry
    low, high = entry["intervals"]["fall"]["rmse"]
    assert high < 0.0 and f"higher by {-high:.5f} to {-low:.5f}: more than chance" in history_text([entry])


@pytest.mark.parametrize(
    "strange", [{"intervals": 3}, {"intervals": {"before": 1}}, {"clear": "yes"}, {"rose": 1},
                {"intervals": {k: {"rmse": [0.1, float("nan")], "mae": None} for k in ("before", "after", "fall")}}],
)  # fmt: skip
def test_files_of_others_are_refused(strange: dict[str, Any]) -> None:
    errors = {"rmse": 0.005, "mae": 0.004}
    entry = {"added": ["a"], "judged_by": "9 tests", "before": errors, "after": errors}
    assert checked_round(entry) == entry
    with pytest.raises(InputError, match="is no round of additions"):
        checked_round(entry | strange)
