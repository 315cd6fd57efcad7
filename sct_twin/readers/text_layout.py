"""Layout of a text file: encoding, delimiter, first row of numbers, names and units above it."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from friction_models.common import InputError
from friction_models.common.byte_order_marks import marked_encoding

from .header import find_header, named_columns
from .numerals import decimal_mark, is_missing, is_numeral

#: So much of a file is looked at.
HEAD_BYTES = 1 << 18
#: So many rows of numbers one after the other are a table and not lines of a header (catman writes 29 of them).
TABLE_ROWS = 10
#: A block of so many rows is the table: what follows is not compared with it.
_ENOUGH_ROWS = 200
DELIMITERS = "\t;,"
#: A number with a decimal comma, blanks, and another one.
_BETWEEN_NUMBERS = re.compile(r"\d,\d+[ ]+[-+]?\d+,\d")


@dataclass(frozen=True)
class TextLayout:
    """What stands before the numbers, and where they begin."""

    #: How cells, numbers and characters are written.
    delimiter: str
    decimal: str
    encoding: str
    #: One a column; names are unique, a unit is '' where the file says none.
    names: tuple[str, ...]
    units: tuple[str, ...]
    #: Columns without a name in the file: dropped where they hold no numbers.
    unnamed: tuple[str, ...]
    #: Lines before the first row of numbers.
    start: int
    #: What the user should know.
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Block:
    """Rows of numbers one after the other: places of the first and the last, how many, delimiter, cells of each."""

    first: int
    last: int
    rows: int
    delimiter: str
    width: int


def text_layout(file: Path) -> TextLayout:
    """Find the densest block of rows of numbers, and names and units above it.

    Raises InputError: binary content, no delimiter or blanks, no numbers, or two tables.
    """
    with file.open("rb") as stream:
        raw = stream.read(HEAD_BYTES)
    text, encoding = decode(raw, file)
    if sum(not c.isprintable() and c not in "\t\r\n\u00a0\u2009\u202f" for c in text[:4096]) > 8:
        raise _binary(file)
    # Lines as the parser sees them, which knows fewer line ends than str.splitlines.
    lines = list(io.StringIO(text, newline=""))
    if len(raw) == HEAD_BYTES and len(lines) > 1:
        del lines[-1]
    if not text.strip():
        raise InputError(f"{file}: the file is blank; allowed: a header, a units row and rows of numbers")
    block = _table(lines, file)
    delimiter = block.delimiter
    if delimiter == "," and _BETWEEN_NUMBERS.search(lines[block.first]):
        raise InputError(
            f"{file}: line {block.first + 1}, {lines[block.first].strip()[:60]!r}, has blanks between numbers with decimal commas; "
            "allowed: columns separated by comma, semicolon or tab"
        )
    rows = [cells(line, delimiter) for line in lines[block.first : block.last + 1]]
    numbered = [k for k in range(block.width) if any(k < len(row) and is_numeral(row[k]) for row in rows)]
    above = [cells(line, delimiter) for line in lines[: block.first]]
    header = find_header(above, numbered, str(file))
    mark = decimal_mark((cell for row in rows for cell in row), str(file))
    width = max(block.width, len(header.names))
    given = [*header.names, *[""] * (width - len(header.names))]
    names, notes = named_columns(given)
    if header.row is None:
        notes.insert(0, "no row of names above the numbers: columns are called by their places")
    elif header.row > 0:
        notes.insert(0, f"{block.first} lines before the numbers: names in line {header.row + 1}")
    unnamed = tuple(name for name, said in zip(names, given) if not said)
    units = (*header.units, *[""] * (width - len(header.units)))
    return TextLayout(delimiter, mark, encoding, tuple(names), units, unnamed, block.first, tuple(notes))


def cells(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without quotes and blanks around them."""
    bare = line.rstrip("\r\n")
    if '"' in bare:
        parts = next(csv.reader([bare], delimiter=delimiter), [])
    else:
        parts = bare.split(delimiter)
    return [part.strip() for part in parts]


def is_data(row: list[str]) -> bool:
    """Whether cells are a row of a table of numbers: more numbers than text."""
    numbers = sum(map(is_numeral, row))
    text = sum(1 for cell in row if cell and not is_missing(cell)) - numbers
    return numbers > text and (numbers > 1 or len(row) > 1)


def _worth(row: list[str]) -> int:
    """Return how much a row speaks for its delimiter: "0,5;1,5" split at commas leaves text between two numbers."""
    text = sum(not is_numeral(cell) and not is_missing(cell) for cell in row)
    return len(row) - 2 * text


def decode(raw: bytes, file: Path) -> tuple[str, str]:
    """Return the text and its encoding: UTF-8, UTF-16 or UTF-32 with a byte order mark, or Windows-1252.

    Raises InputError: binary content.
    """
    marked = marked_encoding(raw)
    if marked != "utf-8-sig":
        unit = 4 if marked == "utf-32" else 2
        return raw[: len(raw) // unit * unit].decode(marked, "replace"), marked
    if b"\0" in raw or raw[:2] in (b"PK", b"\x80\x04", b"\x80\x05", b"\x1f\x8b"):
        raise _binary(file)
    try:
        return raw.decode("utf-8-sig"), "utf-8-sig"
    except UnicodeDecodeError as error:
        # A character cut at the end of the block is no fault; anything before it is Latin-1 or not text.
        if len(raw) == HEAD_BYTES and error.start >= len(raw) - 4:
            return raw[: error.start].decode("utf-8-sig"), "utf-8-sig"
        return raw.decode("cp1252", errors="replace"), "cp1252"


def _binary(file: Path) -> InputError:
    return InputError(f"{file}: binary content; allowed: a text file with a header, a units row and numbers")


def _table(lines: list[str], file: Path) -> _Block:
    """Return the block with the most numbers; refuse a file with two tables.

    Raises InputError: no delimiter, no rows of numbers, or another table before this one.
    """
    found = [block for delimiter in DELIMITERS for block in _blocks(lines, delimiter)]
    if not found:
        first = next((line.strip() for line in lines if line.strip()), "")
        if not any(delimiter in first for delimiter in DELIMITERS):
            raise InputError(
                f"{file}: the first line names one column only; "
                "allowed: columns separated by comma, semicolon or tab"
            )
        if any(sum(map(is_numeral, cells(line, d))) > 1 for d in DELIMITERS for line in lines):
            raise InputError(
                f"{file}: no row holds more numbers than text (first line {first[:60]!r}); allowed: fewer columns of text than "
                "of numbers; what is text in a table of points can stand in tests.csv beside it"
            )
        raise InputError(
            f"{file}: no rows behind the header (first line {first[:60]!r}); allowed: rows of numbers below the names"
        )
    best = max(found, key=lambda block: block.rows * _worth(cells(lines[block.first], block.delimiter)))
    for other in found:
        if other.delimiter == best.delimiter and other.rows >= TABLE_ROWS and other.first != best.first:
            one, two = sorted((other, best), key=lambda block: block.first)
            behind = cells(lines[one.last + 1], best.delimiter)
            if is_data(behind):
                raise other_width(file, one.last + 2, len(behind), one.width)
            raise second_table(file, two.first + 1, f"lines {one.first + 1} to {one.last + 1}")
    return best


def other_width(file: Path, line: int, count: int, width: int) -> InputError:
    """Return the error of a line that has more or fewer cells than its table."""
    return InputError(
        f"{file}, line {line}: {count} cells, the table has {width}; allowed: as many in every line (a second table, or "
        "a remark behind the numbers, belongs into a file of its own)"
    )


def second_table(file: Path, line: int, other: str) -> InputError:
    """Return the error of a file with two tables of numbers."""
    return InputError(
        f"{file}: a second table of numbers begins in line {line}, the first stands in {other}; allowed: one table "
        "(one test) a file: split the file there"
    )


def _blocks(lines: list[str], delimiter: str) -> Iterator[_Block]:
    """Yield the runs of rows of numbers with as many cells each, up to the first that is long enough."""
    first, last, rows, width = 0, 0, 0, 0
    for index, line in enumerate(lines):
        row = cells(line, delimiter) if delimiter in line else []
        numbers = len(row) > 1 and is_data(row)
        if numbers and rows and len(row) == width:
            last, rows = index, rows + 1
            if rows == _ENOUGH_ROWS:
                break
            continue
        if rows and not line.strip():
            # A blank line alone does not end a table: some programs write every line end twice.
            continue
        if rows:
            yield _Block(first, last, rows, delimiter, width)
        first, last, rows, width = index, index, int(numbers), len(row)
    if rows:
        yield _Block(first, last, rows, delimiter, width)
