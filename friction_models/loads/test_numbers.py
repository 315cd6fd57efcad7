"""Columns of numbers in a table of tests in which a few cells hold something else."""

from __future__ import annotations

from typing import Any

import pandas as pd

from ..common.errors import InputError, shown

#: Share of the cells that may hold something else; of more, or of fewer tests than these, the column is one of texts.
FEW, LEAST_TESTS = 0.2, 8
#: Numbers that differ in more than this share of the tests are no labels.
MANY = 0.5
#: Key of `DataFrame.attrs`: column -> test and text of the first cell that is no number, and how many there are.
NO_NUMBERS = "no_numbers"


def with_numbers(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of tests, by name, in which cells of measured numbers that hold a text are empty; `attrs` tells which.

    A column holds measured numbers where they have decimals, or differ in more than half of the tests: whole numbers may be labels beside
    others. A decimal comma is read as one.

    Examples
    --------
    >>> tests = [f"t{k}" for k in range(8)]
    >>> table = pd.DataFrame({"Ra": ["0.2", "0.4", "0.8", "ca. 0.2", "0.2", "0.4", "0.8", "0.2"]}, index=tests)
    >>> found = with_numbers(table)
    >>> found["Ra"].tolist()
    [0.2, 0.4, 0.8, nan, 0.2, 0.4, 0.8, 0.2]
    >>> found.attrs["no_numbers"]
    {'Ra': ('t3', 'ca. 0.2', 1)}
    >>> with_numbers(pd.DataFrame({"batch": ["1", "2", "X"] * 3}))["batch"].tolist()[:3]
    ['1', '2', 'X']
    """
    told, changed = dict(table.attrs.get(NO_NUMBERS, {})), {}
    for name in table.columns:
        values = table[name]
        if pd.api.types.is_numeric_dtype(values) or values.notna().sum() < LEAST_TESTS:
            continue
        recorded = values.dropna()
        numbers = _numbers(recorded)
        texts = recorded[numbers.isna()]
        plain = pd.to_numeric(recorded, errors="coerce").notna().all()
        if plain or len(texts) > FEW * len(recorded) or not _measured(numbers.dropna(), len(recorded)):
            continue
        changed[name] = numbers.reindex(table.index)
        if len(texts):
            told[str(name)] = (str(texts.index[0]), str(texts.iloc[0]), len(texts))
    if not changed:
        return table
    found = table.assign(**changed)
    found.attrs = {**table.attrs, NO_NUMBERS: told}
    return found


def check_tool_temperature(table: pd.DataFrame, where: str) -> None:
    """Refuse tests whose tool temperature is a text, but for a few: other tests are proposed at it, in degC.

    Examples
    --------
    >>> check_tool_temperature(pd.DataFrame({"T_tool": ["hot", "20"]}), "tests.csv")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: tests.csv: column 'T_tool', row 0: value 'hot' is not a number; allowed: numbers in degC, or nothing
    """
    recorded = table.get("T_tool", pd.Series(dtype=float)).reset_index(drop=True).dropna()
    texts = recorded[_numbers(recorded).isna()]
    if len(texts) > FEW * len(recorded):
        raise InputError(
            f"{where}: column 'T_tool', row {texts.index[0]}: value {shown(texts.iloc[0], 30)!r} is not a number; allowed: "
            "numbers in degC, or nothing"
        )


def _numbers(recorded: pd.Series[Any]) -> pd.Series[float]:
    """Return cells as numbers, NaN where one is none; a decimal comma is read as a point."""
    return pd.to_numeric(recorded.astype(str).str.replace(",", ".", regex=False), errors="coerce")


def _measured(numbers: pd.Series[float], tests: int) -> bool:
    """Return whether numbers are measured ones, no labels."""
    return bool((numbers % 1.0 != 0.0).any() or numbers.nunique() > MANY * tests)
