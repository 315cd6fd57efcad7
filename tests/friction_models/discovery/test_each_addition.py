"""Of several effects that are added together each is judged by leaving it out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from friction_models.discovery import refine
from friction_models.discovery.refinement_rounds import history_text, round_notes
from friction_models.families.refinement_history import checked_round
from friction_models.loads import DataSet
from orchestrator.report.pages.refinement import refinement_page

TESTS, POINTS = 16, 12


def made() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return tests of a law, and their table: `oil` shifts mu, and which side a `coin` showed does not.

    mu = 0.1 + 0.02 cos(T/80), 0.03 less with oil b.
    """
    rng = np.random.default_rng(5)
    T = rng.uniform(20.0, 120.0, (TESTS, 1)) + 40.0 * np.linspace(0.0, 1.0, POINTS)
    oil, coin = np.arange(TESTS) % 2, np.arange(TESTS) // 2 % 2
    mu = 0.1 + 0.02 * np.cos(T / 80.0) - 0.03 * oil[:, None] + rng.normal(0.0, 0.002, (TESTS, 1))
    mu += rng.normal(0.0, 0.0005, mu.shape)
    names = [f"t{k:02d}" for k in range(TESTS)]
    columns = {"sd": np.tile(np.linspace(1.0, 60.0, POINTS), TESTS), "T": T.ravel(), "mu": mu.ravel()}
    tests = {"oil": np.where(oil, "b", "a"), "coin": np.where(coin, "heads", "tails")}
    return pd.DataFrame({"test_id": np.repeat(names, POINTS), **columns}), pd.DataFrame(
        {"test_id": names, **tests}
    )


def test_it_is_said_which_of_them_is_needed() -> None:
    points, tests = made()
    told: list[tuple[int, int, str]] = []
    model = refine(points, tests, add=["factor:oil", "factor:coin"], progress=lambda *step: told.append(step))
    entry = model.error_history_[-1]  # type: ignore[attr-defined]
    oil, coin = entry["without"]["factor:oil"], entry["without"]["factor:coin"]
    assert oil["needed"] is True and coin["needed"] is False
    assert oil["rmse"] > 2.0 * entry["after"]["rmse"] and coin["rmse"] < 1.02 * entry["after"]["rmse"]
    # What is left out is judged as if it had never been added.
    alone = refine(points, tests, add="factor:oil").error_history_[-1]  # type: ignore[attr-defined]
    assert coin["rmse"] == pytest.approx(alone["after"]["rmse"]) and "without" not in alone
    lines = [
        f"without factor:oil RMSE {oil['rmse']:.5f} (it is needed)",
        f"without factor:coin RMSE {coin['rmse']:.5f} (it is not needed)",
    ]
    text = history_text([entry]).splitlines()
    assert [line.strip() for line in text if "without" in line] == lines
    page = refinement_page(refine(points, tests), model, DataSet(points, tests), "linear")
    assert all(f"<li>{line}</li>" in page for line in lines)
    # Each of the four folds has five fits, and all of them are counted.
    assert [step[:2] for step in told] == [(k, 20) for k in range(20)]
    assert told[-1][2] == "without factor:coin"


def test_a_rise_that_may_be_chance_shows_neither() -> None:
    errors = {"rmse": 0.0050, "mae": 0.0040}
    entry: dict[str, Any] = {"added": ["a", "b"], "judged_by": "9 tests", "before": errors, "after": errors}
    entry["without"] = {
        "a": {"rmse": 0.0055, "mae": 0.0044, "needed": False},
        "b": errors | {"needed": False},
    }
    assert checked_round(entry) == entry
    assert round_notes(entry) == [
        "without a RMSE 0.00550 (it may be needed: the rise may be chance)",
        "without b RMSE 0.00500 (it is not needed)",
    ]
    for strange in (3, {"a": errors}, {"a": errors | {"needed": "yes"}}, {"a": {"needed": True}}):
        with pytest.raises(InputError, match="is no round of additions"):
            checked_round(entry | {"without": strange})
