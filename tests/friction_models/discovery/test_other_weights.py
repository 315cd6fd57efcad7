"""Base and effects are fitted with other weights than the model alone: what these gain is not credited to an effect."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from friction_models.discovery import refine
from friction_models.discovery.refinement_rounds import BETTER, history_text, round_notes
from friction_models.families.refinement_history import checked_round
from friction_models.loads import DataSet
from orchestrator.report.pages.refinement import refinement_page

TESTS, POINTS = 16, 20


def made(seed: int = 3, effect: float = 0.0) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return tests of one law, each with an offset of its own, and their table; `effect` is added in every second one, worn ones.

    mu = 0.12 - 0.05 T/(600 + T) - 0.002 sqrt(sigma_n/10), in which temperature and pressure change along each test; a fit in which
    all points count alike takes a part of the offsets for their slopes.
    """
    rng = np.random.default_rng(seed)
    place = np.linspace(0.0, 1.0, POINTS)
    T = rng.uniform(20.0, 150.0, (TESTS, 1)) + 60.0 * place * rng.choice([-1.0, 1.0], (TESTS, 1)) + 60.0
    sigma_n = rng.uniform(500.0, 1500.0, (TESTS, 1)) + 400.0 * np.sin(
        7.0 * place + rng.uniform(0.0, 6.0, (TESTS, 1))
    )
    v = rng.uniform(20.0, 80.0, (TESTS, 1)) * (1.0 + place[::-1] ** 2)
    mu = 0.12 - 0.05 * T / (600.0 + T) - 0.002 * np.sqrt(sigma_n / 10.0) + rng.normal(0.0, 0.0003, T.shape)
    mu += rng.normal(0.0, 0.008, (TESTS, 1)) + effect * (np.arange(TESTS)[:, None] % 2)
    columns = {"sd": np.tile(60.0 * place, (TESTS, 1)), "v_rel": v, "T": T, "sigma_n": sigma_n, "mu": mu}
    points = pd.DataFrame({name: values.ravel() for name, values in columns.items()})
    points.insert(0, "test_id", np.repeat([f"t{k:02d}" for k in range(TESTS)], POINTS))
    worn = np.arange(TESTS) % 2
    tests = pd.DataFrame({"test_id": points["test_id"].unique(), "press": "same", "coin": "heads"})
    tests = tests.assign(worn=np.where(worn, "yes", "no"), each=[f"number {k}" for k in range(TESTS)])
    tests.loc[rng.permutation(TESTS)[: TESTS // 2], "coin"] = "tails"
    return points, tests.assign(dose=3.0, hours=rng.uniform(0.0, 5.0, TESTS))


def test_an_effect_is_not_credited_with_the_weights() -> None:
    """Which side a coin showed says nothing of friction; the error falls, more than chance, by the weights."""
    points, tests = made()
    model = refine(points, tests, model="linear", add="factor:coin")
    entry = model.error_history_[-1]  # type: ignore[attr-defined]
    before, after, refitted = (entry[when]["rmse"] for when in ("before", "after", "refitted"))
    assert after < BETTER * before and entry["clear"] and after > BETTER * refitted
    said = (
        "The fall comes from the other weights of the joint fit, not from factor:coin: with these weights alone "
        f"RMSE {refitted:.5f}."
    )
    text = history_text([entry])
    assert "NO BETTER" in text and said in text
    page = refinement_page(refine(points, tests), model, DataSet(points, tests), "linear")
    assert f"<li>{said}</li>" in page
    assert checked_round(entry) == entry
    older = {k: v for k, v in entry.items() if k != "refitted"}
    assert (
        checked_round(older) == older and "NO BETTER" not in history_text([older]) and not round_notes(older)
    )


def test_an_effect_that_is_there_keeps_its_credit() -> None:
    points, tests = made(effect=0.05)
    entry = refine(points, tests, add="factor:worn").error_history_[-1]  # type: ignore[attr-defined]
    assert entry["after"]["rmse"] < 0.6 * entry["refitted"]["rmse"]
    assert "NO BETTER" not in history_text([entry]) and "weights" not in history_text([entry])


def test_it_is_said_where_the_weights_account_for_more_than_a_third() -> None:
    entry: dict[str, Any] = {"added": ["viscous"], "judged_by": "9 tests"}
    errors = {"before": 0.0090, "after": 0.0060, "refitted": 0.0079}
    entry |= {when: {"rmse": value, "mae": value} for when, value in errors.items()}
    (said,) = round_notes(entry)
    assert said.startswith("0.00110 of the fall come from the other weights") and "RMSE 0.00790" in said
    assert said in history_text([entry]) and "NO BETTER" not in history_text([entry])
    assert not round_notes(entry | {"refitted": {"rmse": 0.0081, "mae": 0.0081}})
    with pytest.raises(InputError, match="is no round of additions"):
        checked_round(entry | {"refitted": {"rmse": "small"}})


def test_a_model_with_effects_and_a_law_that_is_not_linear_have_these_weights_already() -> None:
    points, tests = made()
    model = refine(points, tests, model="linear", add="factor:worn", force=True)
    for base in (model, "power_law"):
        again = refine(points, tests, model=base, add="factor:coin", force=True)
        assert "refitted" not in again.error_history_[-1]  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("column", "words"), [("press", "has the same level in all of the 16"), ("dose", "has the same level"),
                          ("each", "has another text in nearly each of the 16"), ("hours", "")],
)  # fmt: skip
def test_a_column_that_says_nothing_of_other_tests_is_refused(column: str, words: str) -> None:
    points, tests = made()
    if not words:
        assert refine(points, tests, add=f"factor:{column}", force=True).is_fitted
        return
    with pytest.raises(
        InputError, match=f"factor:{column}: the column {words}.*; allowed: a column with at least two"
    ):
        refine(points, tests, add=f"factor:{column}", force=True)


def test_levels_of_tests_that_are_held_out_do_not_count() -> None:
    points, tests = made()
    tests["role"] = np.where(tests["worn"] == "yes", "train", "test")
    with pytest.raises(InputError, match="has the same level in all of the 8 tests that are fitted"):
        refine(points, tests, add="factor:worn")
