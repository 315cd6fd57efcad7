"""Columns of the test table that say more than they seem to: serial numbers, coatings written as numbers, cells that nobody filled."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.discovery import diagnose
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


def test_cells_that_nobody_filled_hold_nothing_is_missing() -> None:
    points, table = averages(3)
    batch = pd.Series(["A", "B", "C"] * 12).mask(np.random.default_rng(4).random(36) < 0.33)
    found = diagnose(points, table.assign(lubricant=batch))
    assert found.verdict == "nothing_missing" and found.confidence <= LIKELY, found.sentence
    assert any("is not recorded for many tests" in w for w in found.warnings)
