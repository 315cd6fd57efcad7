"""Of several names each is missed where it is left out: a sum of formulas that bends after an unknown law is no answer."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.judge.naming.names import Names
from friction_models.discovery.judge.unseen_tests import ErrorsByTest


class _Named:
    """An effect of which only the name matters."""

    def __init__(self, name: str) -> None:
        self.name, self.effect = name, self


class _Errors:
    """Errors of 16 tests: each effect of `carried` lowers the error of the tests by that much, where it is there."""

    campaign = SimpleNamespace(mu=np.array([0.0, 10.0]))  # no error is beyond what was measured

    def __init__(self, carried: dict[str, list[float]]) -> None:
        self.carried = {name: np.array(values) for name, values in carried.items()}

    def errors(self, effects: list[_Named]) -> ErrorsByTest:
        """Return the errors with some effects."""
        there = {e.name for e in effects}
        between = 9.0 - sum((v for n, v in self.carried.items() if n in there), np.zeros(16))
        return ErrorsByTest(between, np.ones(16))


def _needed(carried: dict[str, list[float]]) -> list[str]:
    nothing = cast(Any, None)
    names = Names(cast(Any, _Errors(carried)), nothing, nothing, nothing, nothing)
    return [f.name for f in names.needed(cast(Any, [_Named(n) for n in carried]))]


def test_what_is_not_missed_is_not_named() -> None:
    clear, chance = [2.0, 3.0] * 8, [1.0, -0.9] * 8
    assert _needed({"a": clear, "b": clear}) == ["a", "b"]
    assert _needed({"a": chance, "b": clear}) == ["b"]
    assert _needed({"a": clear, "b": chance, "c": clear}) == ["a", "c"]
    assert _needed({"a": chance}) == ["a"]  # whether the only one is there is judged elsewhere


def peak(seed: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return 48 tests whose mu has a peak in temperature and pressure, which no effect describes."""
    rng = np.random.default_rng(seed)
    plan = list(product([5.0, 25.0, 100.0, 400.0], [20.0, 150.0, 300.0], [300.0, 600.0, 1200.0, 2000.0]))
    rng.shuffle(plan)
    sd = np.linspace(0.05, 20.0, 60)
    frames, told = [], []
    for k, (v, tool, p) in enumerate(plan):
        psi = rng.choice([1.1, 3.0, 7.0])
        speed = v * (1.0 + 0.03 * np.sin(0.35 * sd + rng.uniform(0.0, 6.0)))
        pressure = p * (1.0 + 0.12 * (sd / 20.0 - 0.5) * rng.uniform(0.3, 1.6))
        heat = 0.00128 * pressure * np.sqrt(speed * sd)
        T = 0.5 * (tool + 25.0) + 10.0 + heat + rng.normal(0.0, 6.0)
        mu = 0.085 + 1.2e-5 * speed - 3e-5 * (T - 100.0) - 6e-6 * (pressure - 800.0) + 1e-4 * sd
        mu += 0.05 * np.exp(-(((T - 150.0) / 35.0) ** 2) - (np.log(pressure / 800.0) / 0.45) ** 2)
        mu += rng.normal(0.0, 0.004) + rng.normal(0.0, 0.002, len(sd))
        t = np.concatenate([[0.01], 0.01 + np.cumsum(np.diff(sd) / speed[1:])])
        loads = {
            "t": t,
            "v_rel": speed,
            "T": T,
            "sigma_n": pressure,
            "sd": sd,
            "psi": 1.0 + (psi - 1.0) * (0.85 + 0.0075 * sd),
        }
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu}))
        told.append({"test_id": f"t{k:02d}", "T_tool": tool})
    return pd.concat(frames, ignore_index=True), pd.DataFrame(told)


@pytest.mark.nightly
def test_a_peak_is_no_sum_of_two_effects() -> None:
    found = diagnose(*peak(27))
    assert (found.verdict, found.effects, found.confusion_set) == ("unknown_structure", [], [])
