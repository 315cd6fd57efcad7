"""Excel workbooks (``.xlsx``), read with openpyxl after the package has been checked."""

from __future__ import annotations

import itertools
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from friction_models.loads import InputError

from .formats import library
from .table import MAX_COLUMNS, RawTable, check_shape, split_unit, text_of

#: Unpacked size of a workbook [bytes], parts in it, and rows that Excel has at most.
MAX_UNPACKED = 1024**3
MAX_PARTS = 2_000
MAX_ROWS = 1_048_576
#: Text this much larger than its archive is no measurement: numbers do not compress that well.
MAX_RATIO = 200.0
_DOCTYPE = tuple(
    text.encode(code) for text in ("<!DOCTYPE", "<!ENTITY") for code in ("utf-8", "utf-16-le", "utf-16-be")
)


def read_excel(file: Path) -> RawTable:
    """Read the first sheet that has a row of names, a row of units if there is one, and numbers.

    Raises
    ------
    InputError
        Not a workbook, a zip bomb, XML with entities, or no such sheet.
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
                frame, units = found
                note = f"sheet {text_of(sheet.title)!r}" if len(book.worksheets) > 1 else ""
                return RawTable(frame, units, str(file), "Excel", (note,) if note else ())
    finally:
        book.close()
    raise InputError(f"{file}: no sheet has a row of names above rows of numbers; allowed: such a sheet")


def check_package(file: Path) -> None:
    """Refuse a zip bomb and XML that declares a document type, before any parser sees the parts.

    Raises
    ------
    InputError
        Not a zip archive, encrypted, too many or too large parts, a ratio no table has, or a DOCTYPE.
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


def _sheet(rows: Iterator[tuple[Any, ...]], where: str) -> tuple[pd.DataFrame, dict[str, str]] | None:
    """Return the table of a sheet: names, perhaps units, numbers; what stands above them is passed over."""
    above: list[tuple[Any, ...]] = []
    first: tuple[Any, ...] | None = None
    for row in itertools.islice(rows, 200):
        cells = _trim(row)
        if len(cells) > MAX_COLUMNS:
            raise InputError(f"{where}: {len(cells)} columns; allowed: at most {MAX_COLUMNS}")
        if len(cells) > 1 and above and sum(_is_number(cell) for cell in cells) > len(cells) // 2:
            first = cells
            break
        if cells:
            above.append(cells)
    if first is None:
        return None
    width = len(first)
    heads = [row for row in above if len(row) == width and all(isinstance(cell, str) for cell in row)]
    second = [row for row in above[-1:] if len(row) <= width and heads and row is not heads[-1]]
    if not heads:
        return None
    if len(heads) > 1 and above[-1] is heads[-1] and above[-2:-1] == heads[-2:-1]:
        names, marks = heads[-2], list(heads[-1])
    else:
        # A units row may leave cells empty.
        names, marks = heads[-1], list(second[0]) if second else []
    units: dict[str, str] = {}
    plain: list[str] = []
    for number, name in enumerate(names):
        bare, unit = split_unit(text_of(name))
        if bare in units:
            raise InputError(f"{where}: column {bare!r} stands twice in the header; allowed: once")
        mark = marks[number] if number < len(marks) else None
        units[bare] = text_of(mark) if isinstance(mark, str) else unit
        plain.append(bare)
    table: list[tuple[Any, ...]] = []
    for row in itertools.chain([first], rows):
        cells = _trim(row)
        if cells:
            table.append((*cells[:width], *([None] * (width - len(cells)))))
        if len(table) > MAX_ROWS:
            raise InputError(f"{where}: more than {MAX_ROWS} rows; allowed: at most {MAX_ROWS}")
    check_shape(len(table), width, where)
    columns: dict[str, Any] = {}
    for name, values in zip(plain, zip(*table)):
        columns[name] = _numbers(values, name, where)
    return pd.DataFrame(columns), units


def _numbers(values: tuple[Any, ...], name: str, where: str) -> np.ndarray:
    for row, value in enumerate(values):
        if value is not None and not _is_number(value):
            raise InputError(f"{where}: column {name!r}, row {row}: value {text_of(value)!r} is not a number")
    return np.array([np.nan if value is None else float(value) for value in values])


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _trim(row: tuple[Any, ...]) -> tuple[Any, ...]:
    end = len(row)
    while end and row[end - 1] is None:
        end -= 1
    return row[:end]
