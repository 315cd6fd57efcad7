"""Search for the rows of column names and of units above the numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from friction_models.common import InputError

from .numerals import is_numeral
from .table import split_unit

_ATOM = (
    r"(?:[µμukMm]?(?:m|s|N|g|V|A|Pa|Hz|W|J)|min|h|sec|cm|dm|in|inch|mil|mils|deg|rad|daN|lbf|lbs?|kip|kgf|kp|ksi|psi|GPa|"
    r"bar|mbar|K|C|F|degC|degF|°C|°F|°|º[CF]|Grad|rpm|U|Nm|kNm|t|%|‰|Ohm|Ω|dB|1|Digits?|counts?)"
)
_UNIT = re.compile(rf"^{_ATOM}(?:\^?-?[1-9]|[²³])?(?:\s?[/*·]\s?{_ATOM}(?:\^?-?[1-9]|[²³])?)*$")
_NONE = {"", "-", "--", "–"}


@dataclass(frozen=True)
class Header:
    """Names and units of the columns, one a column ('' where the file says none), and the row of the names."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    row: int | None


def find_header(above: Sequence[Sequence[str]], numbered: Sequence[int], where: str) -> Header:
    """Find names and units in the rows above a table of numbers.

    The units are the last row of which at least half the cells are units; the row above it holds the names. Without
    units, the names are the last row with ``name [unit]``, or else the last one that names the most columns.

    Raises InputError: the row of names has fewer cells than the rows of numbers: they cannot be told apart.

    - `above`: cells of the rows above the first row of numbers, from the beginning of the file.
    - `numbered`: columns with numbers.
    """
    rows = [index for index, row in enumerate(above) if any(row)]
    names, units = None, None
    for place in range(len(rows) - 1, 0, -1):
        if _are_units(above[rows[place]], numbered):
            names, units = rows[place - 1], rows[place]
            break
    if names is None or not _names_columns(above[names], numbered):
        units = None
        naming = [index for index in rows if _names_columns(above[index], numbered)]
        bracketed = [index for index in naming if _has_brackets(above[index])]
        most = max((_filled(above[index], numbered) for index in naming), default=0)
        full = [index for index in naming if _filled(above[index], numbered) == most]
        names = next(iter((bracketed or full)[::-1]), None)
    count = max(numbered, default=0) + 1
    if names is None:
        return Header(("",) * count, ("",) * count, None)
    if len(above[names]) < count:
        raise InputError(
            f"{where}, line {names + 1}: the row of names has {len(above[names])} cells, the rows of numbers have "
            f"{count}; allowed: one cell a column, blank ones too (are the names shifted? Mend the header)"
        )
    cells = [*above[names]]
    marks = [] if units is None else [cell.strip("[]()").strip() for cell in above[units]]
    count = max(count, len(cells))
    said = [split_unit(cell) if cell else ("", "") for cell in cells]
    said += [("", "")] * (count - len(said))
    marks += [""] * (count - len(marks))
    return Header(
        tuple(name for name, _ in said),
        tuple(unit or ("" if mark in _NONE else mark) for (_, unit), mark in zip(said, marks)),
        names,
    )


def named_columns(names: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return a name for every column, each once, and what was done for it.

    A column without a name is called by its place, columns of one name are numbered: none of them keeps the bare
    name, so that a channel map has to say which one it means.
    """
    given = [name or f"column {place}" for place, name in enumerate(names, 1)]
    called: list[str] = []
    notes: list[str] = []
    for name in given:
        if given.count(name) == 1:
            called.append(name)
            continue
        number = next(n for n in range(1, 2 * len(given)) if f"{name} ({n})" not in (*called, *given))
        called.append(f"{name} ({number})")
    for name in dict.fromkeys(given):
        if given.count(name) > 1:
            same = [repr(new) for new, old in zip(called, given) if old == name]
            notes.append(f"column {name!r} stands {len(same)} times: called {', '.join(same)}")
    return called, notes


def numbered(name: str, columns: Iterable[object]) -> list[str]:
    """Return what `named_columns` has called the columns of one name: those in `columns` that are ``name (1)`` and so on."""
    return [str(column) for column in columns if re.fullmatch(rf"{re.escape(name)} \(\d+\)", str(column))]


def is_unit(text: str) -> bool:
    """Whether a cell is a usual unit: a units row is known by such cells."""
    bare = text.strip().strip("[]()").strip()
    return bare in _NONE or bool(_UNIT.match(bare))


def _are_units(row: Sequence[str], numbered: Sequence[int]) -> bool:
    cells = [row[k] for k in numbered if k < len(row) and row[k]]
    units = sum(map(is_unit, cells))
    # Zeros of another line of a logger are no units.
    return 2 * units >= max(len(cells), 1) and not all(map(is_numeral, cells))


def _names_columns(row: Sequence[str], numbered: Sequence[int]) -> bool:
    """Whether a row names most columns with numbers; a line ``key; value`` does not."""
    cells = [row[k] for k in numbered if k < len(row) and row[k]]
    words = sum(not is_numeral(cell) for cell in cells)
    return 2 * words > len(numbered) and 2 * words > len(cells)


def _filled(row: Sequence[str], numbered: Sequence[int]) -> int:
    return sum(1 for k in numbered if k < len(row) and row[k])


def _has_brackets(row: Sequence[str]) -> bool:
    cells = [cell for cell in row if cell]
    return 2 * sum(bool(split_unit(cell)[1]) for cell in cells) >= len(cells)
