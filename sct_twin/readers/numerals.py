"""Numbers as text files write them: decimal point or comma, groups of thousands, cells without a value."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np
import pandas as pd

from friction_models.common import InputError
from friction_models.loads.table import bounded

#: What stands between groups of thousands beside the other of point and comma: blanks and apostrophes.
_BLANKS = " \u00a0\u2009\u202f'\u2019"
_EXPONENT = r"(?:[eE][+-]?\d+)?"
_PLAIN = re.compile(rf"^[+-]?(?:\d+[.,]?\d*|[.,]\d+){_EXPONENT}$")
_GROUPED = {
    mark: re.compile(rf"^[+-]?[1-9]\d{{0,2}}(?:([{other}{_BLANKS}])\d{{3}})(?:\1\d{{3}})*(?:[{mark}]\d+)?$")
    for mark, other in ((".", ","), (",", "."))
}
_MISSING = {"", "nan", "na", "n/a", "#n/a", "null", "none", "inf", "+inf", "-inf"}


def is_numeral(cell: str) -> bool:
    """Whether a cell holds a number in any spelling."""
    return bool(_PLAIN.match(cell)) or any(form.match(cell) for form in _GROUPED.values())


def is_missing(cell: str) -> bool:
    """Whether a cell says that there is no value."""
    return cell.lower() in _MISSING


def decimal_mark(cells: Iterable[str], where: str) -> str:
    """Return the decimal mark of cells: '.' or ','.

    A mark is decimal where what stands behind it is no group of three digits, or where the other one groups thousands.

    Raises InputError: both marks occur as decimal marks, or it cannot be told which is.

    >>> decimal_mark(["1,5", "2,25"], "test.csv"), decimal_mark(["1,500.25"], "test.csv")
    (',', '.')
    """
    shown: dict[str, str] = {}
    open_: dict[str, str] = {}
    for cell in cells:
        marks = [c for c in cell if c in ".,"]
        if not marks or not is_numeral(cell):
            continue
        last = marks[-1]
        if len(set(marks)) == 2:
            shown.setdefault(last, cell)
        elif len(marks) > 1:
            shown.setdefault(_other(last), cell)
        elif _GROUPED[_other(last)].match(cell):
            open_.setdefault(last, cell)
        else:
            shown.setdefault(last, cell)
    found = shown or open_
    if len(found) == 2:
        raise InputError(
            f"{where}: {found['.']!r} and {found[',']!r} do not say which of point and comma is the decimal mark; "
            "allowed: the same decimal mark in all columns"
        )
    return next(iter(found), ".")


#: Columns of more cells are looked through for cells that repeat.
_LONG = 10_000


def numbers_of(values: np.ndarray, decimal: str) -> tuple[np.ndarray, np.ndarray, str]:
    """Return cells as numbers, which cells are text, and what separates groups of thousands ('' for nothing)."""
    cells = pd.Series(values, dtype=object)
    if len(cells) > _LONG and pd.api.types.infer_dtype(cells, skipna=True) == "string":
        # Names repeat from row to row: each is looked at once.
        codes, once = pd.factorize(cells, use_na_sentinel=False)
        if len(once) * 4 < len(cells):
            numbers, bad, separator = numbers_of(np.asarray(once, dtype=object), decimal)
            return numbers[codes], bad[codes], separator
    if not cells.map(lambda cell: isinstance(cell, str)).any():
        numbers = pd.to_numeric(bounded(cells), errors="coerce").to_numpy(np.float64)
        return numbers, np.isnan(numbers) & cells.notna().to_numpy(), ""
    text = cells.where(cells.notna(), "").astype(str).str.strip()
    is_text = cells.map(lambda cell: isinstance(cell, str)).to_numpy()
    grouped = text.str.fullmatch(_GROUPED[decimal].pattern).to_numpy() & is_text
    separator = ""
    if grouped.any():
        first = text[grouped].iloc[0]
        separator = next(c for c in first if c in f"{_other(decimal)}{_BLANKS}")
        text = text.where(~grouped, text.str.replace(f"[{_other(decimal)}{_BLANKS}]", "", regex=True))
    if decimal == ",":
        foreign = is_text & text.str.contains(".", regex=False).to_numpy()
        text = text.where(~is_text, text.str.replace(",", ".", regex=False)).where(~foreign, "text")
    numbers = pd.to_numeric(text, errors="coerce").to_numpy(np.float64)
    return numbers, np.isnan(numbers) & cells.notna().to_numpy() & (text != "").to_numpy(), separator


def _other(mark: str) -> str:
    return "," if mark == "." else "."
