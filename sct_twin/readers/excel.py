"""Excel workbooks (``.xlsx``), read with openpyxl after the package has been checked."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from friction_models.common import InputError
from friction_models.common.ranges import is_number
from friction_models.common.wording import counted

from .formats import library
from .header import find_header, named_columns
from .table import MAX_COLUMNS, RawTable, check_shape, text_of

#: Unpacked size of a workbook [bytes], parts in it, and rows that Excel has at most.
MAX_UNPACKED = 1024**3
MAX_PARTS = 2_000
MAX_ROWS = 1_048_576
#: Rows of a sheet above its table at most.
_HEAD_ROWS = 200
#: Text this much larger than its archive is no measurement: numbers do not compress that well.
MAX_RATIO = 200.0
_DOCTYPE = tuple(
    text.encode(code) for text in ("<!DOCTYPE", "<!ENTITY") for code in ("utf-8", "utf-16-le", "utf-16-be")
)


def read_excel(file: Path) -> RawTable:
    """Read the first sheet that has a row of names, a row of units if there is one, and numbers.

    Raises InputError: not a workbook, a zip bomb, XML with entities, or no such sheet.
    """
    check_package(file)
    openpyxl = library("openpyxl", "openpyxl", file, "Excel")
    book = openpyxl.load_workbook(file, read_only=True, data_only=True, keep_links=False)
    try:
        for sheet in book.worksheets:
            # A wrong size in the file would be believed otherwise.
            sheet.reset_dimensions()
            found = _sheet(sheet.iter_rows(values_only=True), f"{file}: sheet {text_of(sheet.title)!r}")
            if found is not None:
                frame, units, notes = found
                if len(book.worksheets) > 1:
                    notes.insert(0, f"sheet {text_of(sheet.title)!r}")
                return RawTable(frame, units, str(file), "Excel", tuple(notes))
    finally:
        book.close()
    raise InputError(f"{file}: no sheet has a row of names above rows of numbers; allowed: such a sheet")


def check_package(file: Path) -> None:
    """Refuse a zip bomb and XML that declares a document type, before any parser sees the parts.

    Raises InputError: not a zip archive, encrypted, too many or too large parts, a ratio no table has, or a
    DOCTYPE.
    """
    try:
        with zipfile.ZipFile(file) as package:
            parts = package.infolist()
            if len(parts) > MAX_PARTS:
                raise InputError(f"{file}: {len(parts)} parts in the workbook; allowed: at most {MAX_PARTS}")
            total = sum(part.file_size for part in parts)
            allowed = min(MAX_UNPACKED, max(10e6, MAX_RATIO * file.stat().st_size))
            if total > allowed:
                raise InputError(
                    f"{file}: unpacks to {total} bytes, a zip bomb; allowed: at most {allowed:.0f} bytes"
                )
            for part in parts:
                if part.flag_bits & 1:
                    raise InputError(f"{file}: the workbook is encrypted; allowed: without a password")
                if part.filename.lower().endswith((".xml", ".rels", ".vml")):
                    _check_part(package, part, file)
    except InputError:
        raise
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, ValueError, EOFError, OSError) as error:
        raise InputError(f"{file}: not a readable workbook ({' '.join(str(error).split())})") from None


def _check_part(package: zipfile.ZipFile, part: zipfile.ZipInfo, file: Path) -> None:
    with package.open(part) as stream:
        tail = b""
        while block := stream.read(1 << 20):
            text = tail + block
            if any(mark in text for mark in _DOCTYPE):
                raise InputError(
                    f"{file}: part {text_of(part.filename)!r} declares a document type or entities; "
                    "allowed: plain XML"
                )
            tail = text[-32:]


def _sheet(
    rows: Iterator[tuple[Any, ...]], where: str
) -> tuple[pd.DataFrame, dict[str, str], list[str]] | None:
    """Return the table of a sheet, its units and notes: lines above, names, perhaps units, numbers, closing lines."""
    above: list[list[str]] = []
    table: list[tuple[Any, ...]] = []
    closing: list[tuple[int, str]] = []
    for line, row in enumerate(rows, 1):
        cells = _trim(row)
        if len(cells) > MAX_COLUMNS:
            raise InputError(f"{where}: {len(cells)} columns; allowed: at most {MAX_COLUMNS}")
        numbers = len(cells) > 1 and sum(map(is_number, cells)) > sum(cell is not None for cell in cells) // 2
        if not table and not numbers:
            above.append(["" if cell is None else text_of(cell) for cell in cells])
            if len(above) > _HEAD_ROWS:
                return None
        elif numbers and closing:
            raise InputError(
                f"{where}, row {line}: a second table of numbers begins behind {closing[0][1]!r} in row {closing[0][0]}; "
                "allowed: one table (one test) a sheet"
            )
        elif numbers or (table and any(map(is_number, cells)) and not any(isinstance(c, str) for c in cells)):
            table.append(cells)
        elif cells:
            closing.append((line, text_of(next(cell for cell in cells if cell is not None))))
        if len(table) > MAX_ROWS:
            raise InputError(f"{where}: more than {MAX_ROWS} rows; allowed: at most {MAX_ROWS}")
    if not table or not any(above):
        return None
    return _framed(above, table, closing, where)


def _framed(
    above: list[list[str]], table: list[tuple[Any, ...]], closing: list[tuple[int, str]], where: str
) -> tuple[pd.DataFrame, dict[str, str], list[str]]:
    """Return a sheet's rows as a table with names and units."""
    width = max(map(len, [*table, *above]))
    numbered = [
        k for k in range(width) if any(k < len(row) and is_number(row[k]) for row in table[:_HEAD_ROWS])
    ]
    header = find_header([[*row, *[""] * (width - len(row))] for row in above], numbered, where)
    names, notes = named_columns(header.names)
    if header.row is None:
        notes.insert(0, "no row of names above the numbers: columns are called by their places")
    if closing:
        notes.append(f"{counted(len(closing), 'row')} behind the numbers passed over: {closing[0][1]!r}")
    check_shape(len(table), width, where)
    padded = [(*row, *([None] * (width - len(row)))) for row in table]
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    first = 1 + len(above)
    for name, said, unit, values in zip(names, header.names, header.units, zip(*padded)):
        if not said and all(value is None for value in values):
            continue
        columns[name] = _numbers(values, name, first, where)
        units[name] = unit
    return pd.DataFrame(columns), units, notes


def _numbers(values: tuple[Any, ...], name: str, first: int, where: str) -> np.ndarray:
    text = [row for row, value in enumerate(values) if value is not None and not is_number(value)]
    if 2 * len(text) > sum(value is not None for value in values):
        # Dates and remarks.
        return np.array([None if value is None else text_of(value) for value in values], dtype=object)
    if text:
        raise InputError(
            f"{where}, row {first + text[0]}: column {name!r}: value {text_of(values[text[0]])!r} is not a number; "
            "allowed: numbers (mend the cell, or take the row out)"
        )
    return np.array([np.nan if value is None else float(value) for value in values])


def _trim(row: tuple[Any, ...]) -> tuple[Any, ...]:
    end = len(row)
    while end and row[end - 1] is None:
        end -= 1
    return row[:end]
