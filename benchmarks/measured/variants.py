"""Changes of a table after which the answer should be the same, or as sure at most."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd


def averages(data: pd.DataFrame, tests: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """One mean point a test; nothing that happens inside a test can be seen any more."""
    return data.groupby("test_id", as_index=False, sort=False).mean(), tests


def thin(data: pd.DataFrame, tests: pd.DataFrame, step: int = 2) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Keep every ``step``-th point of a test."""
    return data[data.groupby("test_id").cumcount() % step == 0].reset_index(drop=True), tests


def reverse_rows(data: pd.DataFrame, tests: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Reverse the row order of both tables."""
    return data.iloc[::-1].reset_index(drop=True), tests.iloc[::-1].reset_index(drop=True)


def drop_tests(
    data: pd.DataFrame, tests: pd.DataFrame, share: float = 0.1, seed: int = 0
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Leave out a random share of whole tests."""
    names = np.array(sorted(data["test_id"].unique()))
    chosen = np.random.default_rng(seed).random(len(names)) >= share
    keep = set(names[chosen]) if chosen.any() else set(names)
    return data[data["test_id"].isin(keep)].reset_index(drop=True), tests[
        tests["test_id"].isin(keep)
    ].reset_index(drop=True)


def copies(data: pd.DataFrame, tests: pd.DataFrame, number: int = 2) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Every test ``number`` times under new names: no new information, so nothing may become more certain."""
    points = [data.assign(test_id=data["test_id"] + f"_copy{index}") for index in range(number)]
    table = [tests.assign(test_id=tests["test_id"] + f"_copy{index}") for index in range(number)]
    return pd.concat(points, ignore_index=True), pd.concat(table, ignore_index=True)


def metres(data: pd.DataFrame, tests: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Speed and distance in metres instead of millimetres: a scale only, the answer should not change."""
    return data.assign(**{name: data[name] / 1000 for name in ("v_rel", "sd") if name in data}), tests


def random_column(
    data: pd.DataFrame, tests: pd.DataFrame, seed: int = 0
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Add a column of three names that mean nothing: ``batch``, or ``lot`` where the tests have a batch."""
    names = np.random.default_rng(seed).choice(["A", "B", "C"], len(tests))
    return data, tests.assign(**{"lot" if "batch" in tests else "batch": names})


VARIANTS: dict[str, Callable[[pd.DataFrame, pd.DataFrame], tuple[pd.DataFrame, pd.DataFrame]]] = {
    "averages": averages,
    "thin": thin,
    "reverse_rows": reverse_rows,
    "drop_tests": drop_tests,
    "copies": copies,
    "metres": metres,
    "random_column": random_column,
}
