"""CSV and ASCII exports with a header and a units row; comma, semicolon or tab, decimal point or comma."""

from __future__ import annotations

import codecs
import io
import os
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from friction_models.loads import InputError

from .table import MAX_ROWS, RawTable, check_file, check_shape, split_unit

_NUMBER = re.compile(r"^[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?$|^(nan|NaN|inf|-inf|)$")
#: So many rows of numbers in a row are data and not part of a long header (catman writes 29 lines of it).
_DATA_ROWS = 10
_HEAD_BYTES = 1 << 18
#: Rows that are parsed at once.
_PIECE = 500_000


@dataclass(frozen=True)
class _Layout:
    """What stands before the numbers, and where they begin (lines to skip, or a byte behind a preamble)."""

    delimiter: str
    header: str
    second: str
    body: str
    encoding: str
    start: int | None = None
    notes: tuple[str, ...] = ()


def read_csv(path: str | os.PathLike[str]) -> RawTable:
    """Read a measurement file; the second line may hold units, or the header `name [unit]`.

    Raises
    ------
    InputError
        No such file, empty, too large, not text, no header, or rows that do not fit the header.
    """
    file = Path(path)
    check_file(file)
    layout = _head(file)
    header, second, delimiter = layout.header, layout.second, layout.delimiter
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
        plain, unit = split_unit(name)
        bare.append(plain)
        if name in units:
            units[plain] = units.pop(name)
        if unit:
            units[plain] = unit
    if len(set(bare)) != len(bare):
        twice = next(name for name in bare if bare.count(name) > 1)
        raise InputError(f"{file}: column {twice!r} stands twice in the header; allowed: once")
    rows = _line_count(file)
    check_shape(rows, len(bare), str(file))
    decimal = "," if delimiter != "," and re.search(r"\d,\d", layout.body) else "."
    source = _Source(io.FileIO(file))
    if layout.start is not None:
        source.seek(layout.start)
    try:
        with (
            source,
            pd.read_csv(
                source,
                sep=delimiter,
                decimal=decimal,
                header=None,
                names=bare,
                skiprows=skip if layout.start is None else 0,
                encoding=layout.encoding,
                nrows=MAX_ROWS + 1,
                low_memory=False,
                index_col=False,
                on_bad_lines="error",
                chunksize=_PIECE,
            ) as pieces,
        ):
            frame = _together(pieces, bare, rows)
    except pd.errors.EmptyDataError:
        raise InputError(f"{file}: no rows behind the header; allowed: rows of numbers") from None
    except (ValueError, OSError, UnicodeError) as error:
        if source.failure is not None:
            raise source.failure from None
        if "on source failed" in str(error):
            # Nothing failed inside of a read: an interrupt came between two of them.
            raise KeyboardInterrupt from None
        raise InputError(f"{file}: not a readable table ({str(error).strip().splitlines()[-1]})") from None
    if frame.empty:
        raise InputError(f"{file}: no rows behind the header; allowed: rows of numbers")
    check_shape(len(frame), len(bare), str(file))
    named = {name: units.get(name, "") for name in bare}
    return RawTable(frame, named, str(file), "CSV", layout.notes)


def _together(pieces: Iterable[pd.DataFrame], names: Sequence[str], rows: int) -> pd.DataFrame:
    """Return one table of many pieces, at most `rows` long: the whole never stands in memory twice."""
    columns: dict[str, np.ndarray] = {name: np.empty(rows) for name in names}
    count = 0
    for piece in pieces:
        end = min(count + len(piece), rows)
        for name in names:
            values = piece[name].to_numpy()[: end - count]
            if values.dtype.kind not in "fiub" and columns[name].dtype.kind == "f":
                columns[name] = columns[name].astype(object)
            columns[name][count:end] = values
        count = end
    return pd.DataFrame({name: values[:count] for name, values in columns.items()}, copy=False)


def _line_count(file: Path) -> int:
    """Return how many lines a file has at most."""
    ends = {b"\n": 0, b"\r": 0}
    with file.open("rb") as stream:
        while block := stream.read(1 << 24):
            for mark in ends:
                ends[mark] += block.count(mark)
    return max(ends.values()) + 1


class _Source(io.BufferedReader):
    """A file that remembers what interrupted its reading: the parser makes an error of its own of it."""

    failure: BaseException | None = None

    def read(self, size: int | None = -1, /) -> bytes:
        return self._kept(super().read, size)

    def read1(self, size: int = -1, /) -> bytes:
        return self._kept(super().read1, size)

    def _kept(self, read: Callable[..., bytes], size: int | None) -> bytes:
        try:
            return read(size)
        except BaseException as error:
            self.failure = error
            raise


def _head(file: Path) -> _Layout:
    """Return how the table is laid out, from the beginning of the file."""
    with file.open("rb") as stream:
        raw = stream.read(_HEAD_BYTES)
    text, encoding = _decode(raw, file)
    if sum(not c.isprintable() and c not in "\t\r\n" for c in text[:4096]) > 8:
        raise _binary(file)
    lines = text.splitlines()
    found = _behind_preamble(text, encoding, 3 if raw.startswith(codecs.BOM_UTF8) else 0)
    if found is not None:
        return found
    if not lines or not lines[0].strip():
        raise InputError(f"{file}: the first line is blank; allowed: a header with column names")
    delimiter = max(",;\t", key=lines[0].count)
    return _Layout(delimiter, lines[0], lines[1] if len(lines) > 1 else "", "\n".join(lines[2:20]), encoding)


def _decode(raw: bytes, file: Path) -> tuple[str, str]:
    """Return the text and its encoding: UTF-8, UTF-16 with a byte order mark, or Windows-1252."""
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw[: len(raw) // 2 * 2].decode("utf-16", "replace"), "utf-16"
    if b"\0" in raw or raw[:2] in (b"PK", b"\x80\x04", b"\x80\x05", b"\x1f\x8b"):
        raise _binary(file)
    try:
        return raw.decode("utf-8-sig"), "utf-8-sig"
    except UnicodeDecodeError as error:
        # A character cut at the end of the block is no fault; anything before it is Latin-1 or not text.
        if error.start >= len(raw) - 4:
            return raw[: error.start].decode("utf-8-sig"), "utf-8-sig"
        return raw.decode("cp1252", errors="replace"), "cp1252"


def _binary(file: Path) -> InputError:
    return InputError(f"{file}: binary content; allowed: a text file with a header, a units row and numbers")


def _behind_preamble(text: str, encoding: str, mark: int) -> _Layout | None:
    """Return the layout of a file with lines before its header or many header lines, as catman writes.

    The numbers begin where ten rows of them follow each other; the lines above with as many cells are the
    header: names, units, then what else the logger says about each channel. None for a plain table.
    """
    lines = text.splitlines(keepends=True)
    first, delimiter = _first_row(lines)
    plain = first > 0 and lines[0].count(delimiter) == lines[first].count(delimiter)
    if plain and any(_is_row(line, delimiter) for line in lines[1:3]):
        return None
    if first < 3 or encoding == "utf-16":
        # pandas cannot start in the middle of UTF-16; such files are plain tables.
        return None
    width = lines[first].count(delimiter)
    block: list[str] = []
    for line in reversed(lines[:first]):
        if line.rstrip("\r\n").count(delimiter) != width or not line.strip():
            if block:
                break
            continue
        block.insert(0, line.rstrip("\r\n"))
    if not block:
        return None
    start = mark + sum(len(line.encode(encoding.removesuffix("-sig"), "replace")) for line in lines[:first])
    body = "".join(lines[first : first + 20])
    second = block[1] if len(block) > 1 else ""
    note = f"{first} lines before the numbers: names in line {_lines_before(lines, block[0]) + 1}"
    return _Layout(delimiter, block[0], second, body, encoding, start, (note,))


def _lines_before(lines: list[str], wanted: str) -> int:
    """Return how many lines stand before a line."""
    return next(i for i, line in enumerate(lines) if line.rstrip("\r\n") == wanted)


def _first_row(lines: list[str]) -> tuple[int, str]:
    """Return the first of `_DATA_ROWS` rows of numbers and their delimiter; (0, '') without such rows."""
    for delimiter in "\t;,":
        run, width = 0, 0
        for index, line in enumerate(lines):
            numbers = _is_row(line, delimiter)
            run = run + 1 if numbers and (run == 0 or line.count(delimiter) == width) else int(numbers)
            width = line.count(delimiter)
            if run == _DATA_ROWS:
                return index - _DATA_ROWS + 1, delimiter
    return 0, ""


def _is_row(line: str, delimiter: str) -> bool:
    cells = [cell.strip() for cell in line.rstrip("\r\n").split(delimiter)]
    return len(cells) > 1 and all(map(_NUMBER.match, cells)) and any(cells)
