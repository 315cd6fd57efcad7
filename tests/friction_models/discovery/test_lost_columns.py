"""Columns of the test table that say more than they seem to: serial numbers, coatings written as numbers, cells that nobody filled."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from friction_models.discovery import diagnose, refine
from friction_models.discovery.judge.doubts import LIKELY, MOSTLY


def averages(seed: int, tests: int = 36) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return averages of tests in which friction depends on the pressure alone, and their table with a run order."""
    rng = np.random.default_rng([seed, 61])
    names = [f"t{k:02d}" for k in range(tests)]
    loads = {
        "v_rel": rng.choice([5.0, 20.0, 80.0], tests),
        "T": rng.choice([20.0, 80.0, 140.0], tests),
        "sigma_n": rng.choice([200.0, 400.0, 600.0], tests),
    }
    mu = 0.1 - 2e-5 * (loads["sigma_n"] - 400.0) + rng.normal(0.0, 0.003, tests)
    table = pd.DataFrame({"test_id": names, "order": rng.permutation(tests) + 1})
    return pd.DataFrame({"test_id": names, **loads, "mu": mu}), table


def test_serial_numbers_are_an_order_as_others_are() -> None:
    """A drift over the numbers from 1001 on left a base far below zero: it was no drift, and another column was named."""
    points, table = averages(1)
    points["mu"] += 0.03 * ((table["order"] - 1.0) / 35.0) ** 1.2
    found = diagnose(points, table)
    later = diagnose(points, table.assign(order=table["order"] + 1000))
    assert found.effects == ["sensor_drift"], found.sentence
    assert (later.verdict, later.effects) == (found.verdict, found.effects)
    assert abs(later.confidence - found.confidence) < 0.02


def test_coatings_that_are_numbers_are_told_wherever_most_is_left() -> None:
    """Levels in no order of their numbers were noise, and the hint came only where the column led what is left."""
    points, table = averages(2)
    coating = np.random.default_rng(5).permutation(np.arange(36) % 5) + 1
    points["mu"] += np.array([0.0, 0.008, -0.008, 0.008, 0.0])[coating - 1]
    found = diagnose(points, table.assign(coating=coating))
    assert any("coating is taken as a quantity of 1, 2, 3, 4 and 5" in w for w in found.warnings)
    assert found.confidence <= MOSTLY
    assert not any("is taken as a quantity" in w for w in diagnose(points, table).warnings)


def half_filled(seed: int, offset: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return averages whose lubricant is empty for a third of the tests; friction with A is off by `offset`."""
    points, table = averages(seed)
    lubricant = pd.Series(["A", "B", "C"] * 12)
    points["mu"] += offset * (lubricant == "A")
    return points, table.assign(lubricant=lubricant.mask(np.random.default_rng(seed + 1).random(36) < 0.33))


@pytest.mark.parametrize("seed", [3, 5, *(pytest.param(k, marks=pytest.mark.nightly) for k in (6, 7, 8, 9))])
def test_what_a_column_does_is_seen_though_many_cells_are_empty(seed: int) -> None:
    """Empty cells counted with the commonest text, which hid it: nothing was missing, or was 0.7 sure to be."""
    found = diagnose(*half_filled(seed, 0.015))
    assert found.effects == ["factor:lubricant"], found.sentence
    assert any("tests: they count as a level of their own" in w for w in found.warnings)


def test_that_nothing_is_recorded_may_itself_go_with_an_offset() -> None:
    """A column that was empty for more than half of the tests was not looked at, and nobody was told."""
    points, table = averages(4)
    empty = np.random.default_rng(11).random(36) < 0.6
    points["mu"] += 0.015 * empty
    lubricant = pd.Series(["A", "B", "C"] * 12).mask(empty)
    found = diagnose(points, table.assign(lubricant=lubricant))
    assert found.effects == ["factor:lubricant"], found.sentence
    hardly = diagnose(points, table.assign(lubricant=lubricant.where(np.arange(36) < 10)))
    said = [w for w in hardly.warnings if "are no factors: lubricant is recorded for" in w]
    assert len(said) == 1, hardly.warnings


def test_empty_cells_make_no_effect() -> None:
    found = [diagnose(*half_filled(seed, 0.0)) for seed in (3, 5, 6)]
    assert all(f.verdict == "nothing_missing" and f.confidence <= LIKELY for f in found)
    assert any("is not recorded for many tests" in w for w in found[0].warnings)


def test_a_model_knows_tests_for_which_nothing_is_recorded() -> None:
    points, table = half_filled(5, 0.015)
    model = refine(points, table, add=["factor:lubricant"])
    assert model.system_variables[0].labels == ("A", "B", "C", "not recorded")
    one = points.head(1)
    by_label = {
        label: float(model.predict_frame(one, tests=pd.DataFrame({"test_id": one["test_id"], "lubricant": [label]}))[0])
        for label in ("A", "not recorded", None, "Z")
    }  # fmt: skip
    assert by_label[None] == by_label["not recorded"] != by_label["A"]
    assert by_label["Z"] != by_label["not recorded"]


def test_tests_without_the_column_of_a_model_are_refused_in_words() -> None:
    """It was a KeyError in the basis of an effect."""
    points, table = half_filled(5, 0.015)
    model = refine(points, table, add=["factor:lubricant"])
    with pytest.raises(InputError, match="needs the column 'lubricant' of the table of tests"):
        diagnose(points, table.drop(columns="lubricant"), model=model)


@pytest.mark.parametrize(
    "cells",
    [
        pd.Series(pd.Categorical(["A", "B", None, "C", "A", " "] * 6)),
        pd.Series(["A", "B", pd.NA, "C", "A", ""] * 6, dtype="string"),
        pd.Series([True, False, None, True, False, None] * 6, dtype="boolean"),
        pd.Series([1, 10**400, 2] * 12, dtype=object),
        pd.Series([["a"], {"b": 1}, None, 2.5, b"c", pd.Timestamp("2024-01-31")] * 6, dtype=object),
    ],
)
@pytest.mark.parametrize("name", ["lubricant", 7, None])
def test_columns_of_all_kinds_are_taken(cells: pd.Series, name: object) -> None:
    points, table = averages(3)
    assert diagnose(points, table.assign(column=cells).rename(columns={"column": name})).verdict


def test_a_column_whose_name_is_no_text_counts_as_others_do() -> None:
    points, table = averages(4)
    coating = np.arange(36) % 3
    points["mu"] += 0.015 * (coating == 1)
    texts = pd.Series(["A", "B", "C"])[coating].to_numpy()
    assert diagnose(points, table.assign(column=texts).rename(columns={"column": 7})).effects == ["factor:7"]


def test_a_model_that_predicts_what_no_square_holds_is_refused() -> None:
    points, table = averages(3)
    with pytest.raises(InputError, match=r"predict gave 1e\+300; allowed: friction coefficients"):
        diagnose(points, table, model=SimpleNamespace(predict=lambda loads: np.full(len(loads), 1e300)))


def test_the_temperature_of_a_room_is_no_load() -> None:
    """Ten tests of a law that falls with speed: beside a slope along what a thermometer reads, nothing was missing, 0.8 sure."""
    rng = np.random.default_rng(3)
    v = np.array([1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 600.0, 10.0, 100.0, 1.0])
    p = np.array([100.0, 300.0, 500.0, 100.0, 300.0, 500.0, 100.0, 300.0, 500.0, 500.0])
    mu = 0.12 - 0.02 * np.arctan(1.5 * np.log(v / 15.0)) + rng.normal(0.0, 0.003, 10)
    names = [f"t{k}" for k in range(10)]
    for seed in range(3):
        room = 25.0 + np.random.default_rng(seed).normal(0.0, 0.5, 10)
        found = diagnose(pd.DataFrame({"test_id": names, "v_rel": v, "T": room, "sigma_n": p, "mu": mu}))
        assert "stribeck" in found.confusion_set, found.sentence


def test_an_odd_test_that_no_other_of_its_coating_reaches_is_told() -> None:
    """It may show what the coating does there; "look at its record" was all that was said."""
    points, table = averages(7)
    hottest = points["T"] == points["T"].max()
    coating = np.where(np.arange(36) % 3 == 0, "polymer", "soap")
    coating = np.where(hottest & (coating == "polymer"), "soap", coating)
    lone = int(np.flatnonzero(hottest)[0])
    coating[lone] = "polymer"
    points.loc[lone, "mu"] += 0.06
    found = diagnose(points, table.assign(coating=coating))
    (said,) = (w for w in found.warnings if "was left out" in w)
    name = points["test_id"][lone]
    assert f"{name} is the only test of coating polymer at T above 80 degC" in said
    usual = diagnose(points, table.assign(coating=np.where(np.arange(36) % 2, "polymer", "soap")))
    assert not any("is the only test of" in w for w in usual.warnings)
