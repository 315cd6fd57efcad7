"""Cells of a table of tests as numbers and texts, whatever pandas made of them."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pandas as pd


def with_plain_cells(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose columns hold numbers, texts and dates, nothing where a cell is blank, and have texts as names.

    Categories become their texts, and truth values with gaps numbers. What cannot be compared, as a list, becomes its text; so does a
    number beyond all that a float holds.

    Examples
    --------
    >>> tests = pd.DataFrame({"coating": pd.Categorical(["TiN", None, " "]), "oil": [1, 10**400, 2], 7: [[1], "x", None]})
    >>> plain = with_plain_cells(tests)
    >>> plain["coating"].isna().tolist(), plain["oil"].tolist()[0], plain["7"].tolist()
    ([False, True, True], 1, ['[1]', 'x', None])
    """
    columns = [_plain(table[name]) for name in table.columns]
    found = pd.concat(columns, axis=1) if columns else table.copy()
    found.attrs = table.attrs
    return found.set_axis([str(name) for name in table.columns], axis=1)


def _plain(values: pd.Series[Any]) -> pd.Series[Any]:
    """Return a column of cells of Python, or of numbers of NumPy."""
    if isinstance(values.dtype, np.dtype) and not pd.api.types.is_object_dtype(values):
        return values
    if pd.api.types.is_numeric_dtype(values):
        return values.astype("Float64").astype(float)
    cells = [_cell(v) for v in values.astype(object)]
    return pd.Series(cells, index=values.index, dtype=object, name=values.name)


def _cell(value: Any) -> Any:
    """Return a cell as it is, as a text, or None where it is blank."""
    if isinstance(value, str):
        return value if value.strip() else None
    if isinstance(value, (list, tuple, dict, set, np.ndarray)):
        return str(value)
    if isinstance(value, int) and abs(value) > sys.float_info.max:
        return str(value)
    return None if pd.isna(value) else value
