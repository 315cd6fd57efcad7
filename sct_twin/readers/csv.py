"""CSV and ASCII exports with a header and a units row; comma, semicolon or tab, decimal point or comma."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from friction_models.loads import InputError

#: Larger files are refused instead of filling the memory (10 million rows of six channels fit).
MAX_BYTES = 2 * 1024**3
_NUMBER = re.compile(r"^[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?$|^(nan|NaN|inf|-inf|)$")


@dataclass(frozen=True)
class RawTable:
    """Columns as they stand in a file, and the unit of each (empty where the file names none)."""

    frame: pd.DataFrame
    units: dict[str, str]
    source: str


def read_csv(path: str | os.PathLike[str]) -> RawTable:
    """Read a measurement file; the second line may hold units, or the header `name [unit]`.

    Raises
    ------
    InputError
        No such file, empty, too large, not text, no header, or rows that do not fit the header.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError(f"{file}: no such file")
    size = file.stat().st_size
    if size == 0:
        raise InputError(f"{file}: the file is empty; allowed: a header, a units row and rows of numbers")
    if size > MAX_BYTES:
        raise InputError(f"{file}: {size} bytes; allowed: at most {MAX_BYTES}")
    header, second, body, encoding = _head(file)
    delimiter = max(",;\t", key=header.count)
    if header.count(delimiter) == 0:
        raise InputError(
            f"{file}: the first line {header[:60]!r} names one column only; "
            "allowed: columns separated by comma, semicolon or tab"
        )
    names = [cell.strip().strip('"') for cell in header.split(delimiter)]
    cells = [cell.strip().strip('"') for cell in second.split(delimiter)]
    numbers = [bool(_NUMBER.match(cell)) for cell in cells]
    units: dict[str, str] = {}
    skip = 1
    if second and not all(numbers):
        if len(cells) != len(names):
            raise InputError(
                f"{file}: the units row has {len(cells)} cells, the header {len(names)}; allowed: one a column"
            )
        units = dict(zip(names, cells))
        skip = 2
    bare = []
    for name in names:
        plain, bracket, unit = name.partition("[")
        bare.append(plain.strip())
        if bracket:
            units[plain.strip()] = unit.rstrip("] ").strip()
    if len(set(bare)) != len(bare):
        twice = next(name for name in bare if bare.count(name) > 1)
        raise InputError(f"{file}: column {twice!r} stands twice in the header; allowed: once")
    decimal = "," if delimiter != "," and re.search(r"\d,\d", body) else "."
    try:
        frame = pd.read_csv(
            file,
            sep=delimiter,
            decimal=decimal,
            header=None,
            names=bare,
            skiprows=skip,
            encoding=encoding,
            low_memory=False,
            index_col=False,
            on_bad_lines="error",
        )
    except pd.errors.EmptyDataError:
        raise InputError(f"{file}: no rows behind the header; allowed: rows of numbers") from None
    except (ValueError, OSError, UnicodeError) as error:
        raise InputError(f"{file}: not a readable table ({str(error).strip().splitlines()[-1]})") from None
    if frame.empty:
        raise InputError(f"{file}: no rows behind the header; allowed: rows of numbers")
    return RawTable(frame, {name: units.get(name, "") for name in bare}, str(file))


def _head(file: Path) -> tuple[str, str, str, str]:
    """Return the first line, the second, some of the body and the encoding."""
    with file.open("rb") as stream:
        raw = stream.read(65536)
    if b"\0" in raw or raw[:2] in (b"PK", b"\x80\x04", b"\x80\x05", b"\x1f\x8b"):
        raise InputError(
            f"{file}: binary content; allowed: a text file with a header, a units row and numbers"
        )
    encoding = "utf-8-sig"
    try:
        text = raw.decode(encoding)
    except UnicodeDecodeError as error:
        # A character cut at the end of the block is no fault; anything before it is Latin-1 or not text.
        if error.start >= len(raw) - 4:
            text = raw[: error.start].decode(encoding)
        else:
            encoding = "cp1252"
            text = raw.decode(encoding, errors="replace")
    if sum(not c.isprintable() and c not in "\t\r\n" for c in text[:4096]) > 8:
        raise InputError(
            f"{file}: binary content; allowed: a text file with a header, a units row and numbers"
        )
    lines = text.splitlines()
    if not lines or not lines[0].strip():
        raise InputError(f"{file}: the first line is blank; allowed: a header with column names")
    return lines[0], lines[1] if len(lines) > 1 else "", "\n".join(lines[2:20]), encoding
