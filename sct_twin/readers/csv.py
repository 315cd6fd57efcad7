"""CSV and ASCII exports with a header and a units row; comma, semicolon or tab, decimal point or comma."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from friction_models.common import InputError
from friction_models.common.wording import counted

from .numerals import numbers_of
from .table import MAX_ROWS, RawTable, check_file, check_shape
from .text_layout import TextLayout, cells, other_width, second_table, text_layout

#: Rows that are parsed at once.
_PIECE = 500_000
#: More lines than this behind the numbers are not a closing remark.
_FOOTER_LINES = 100
_TOO_WIDE = re.compile(r"Expected (\d+) fields in line (\d+), saw (\d+)")


def read_csv(path: str | os.PathLike[str]) -> RawTable:
    """Read a measurement file: lines above the table, names, perhaps units, numbers, perhaps closing remarks.

    Raises
    ------
    InputError
        No such file, empty, too large, not text, no numbers, a header that does not fit, or two tables.
    """
    file = Path(path)
    check_file(file)
    layout = text_layout(file)
    names = layout.names
    lines = _line_count(file)
    check_shape(lines - layout.start, len(names), str(file))
    frame = _parsed(file, layout, lines - layout.start)
    # One line a row: without blank lines between them, a row is found again by its line.
    exact = layout.start + len(frame) in (lines - 1, lines)
    numbers, notes = _as_numbers(frame, layout)
    frame, said = _without_footer(frame, numbers, file, layout)
    if frame.empty:
        raise InputError(f"{file}: no rows behind the header; allowed: rows of numbers")
    gone = [name for name in layout.unnamed if frame[name].isna().all()]
    frame = frame.drop(columns=gone) if gone else frame
    units = {name: unit for name, unit in zip(names, layout.units) if name not in gone}
    called = [name for name in layout.unnamed if name not in gone]
    if called and len(called) < len(units):
        notes.insert(0, f"columns without a name: called {', '.join(map(repr, called))}")
    first = layout.start + 1 if exact else 0
    return RawTable(frame, units, str(file), "CSV", (*layout.notes, *notes, *said), first)


def _parsed(file: Path, layout: TextLayout, rows: int) -> pd.DataFrame:
    """Return the rows below the header as they stand there, at most `rows`."""
    source = _Source(io.FileIO(file))
    try:
        with io.TextIOWrapper(source, encoding=layout.encoding, newline="") as stream:
            for _ in range(layout.start):
                stream.readline()
            with pd.read_csv(
                stream,
                sep=layout.delimiter,
                decimal=layout.decimal,
                header=None,
                names=list(layout.names),
                nrows=MAX_ROWS + 1,
                low_memory=False,
                index_col=False,
                on_bad_lines="error",
                chunksize=_PIECE,
            ) as pieces:
                return _together(pieces, layout.names, rows)
    except pd.errors.EmptyDataError:
        raise InputError(f"{file}: no rows behind the header; allowed: rows of numbers") from None
    except (ValueError, OSError, UnicodeError) as error:
        if source.failure is not None:
            raise source.failure from None
        if "on source failed" in str(error):
            # Nothing failed inside of a read: an interrupt came between two of them.
            raise KeyboardInterrupt from None
        if isinstance(error, UnicodeDecodeError):
            raise InputError(
                f"{file}: byte {error.object[error.start]:#04x} is none of the encoding {layout.encoding}; allowed: UTF-8, UTF-16 "
                "with a byte order mark, or Windows-1252: save the file as UTF-8"
            ) from None
        wide = _TOO_WIDE.search(str(error))
        if wide is not None:
            raise other_width(file, layout.start + int(wide[2]), int(wide[3]), int(wide[1])) from None
        raise InputError(f"{file}: not a readable table ({str(error).strip().splitlines()[-1]})") from None


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


def _as_numbers(frame: pd.DataFrame, layout: TextLayout) -> tuple[dict[str, np.ndarray], list[str]]:
    """Turn cells that the parser took for text into numbers, in place; return which cells are still text.

    Columns that are text for the most part (names, dates) stay as they are and are not among the answers.
    """
    text: dict[str, np.ndarray] = {}
    notes = []
    for name in frame.columns:
        if frame[name].dtype.kind in "fiub":
            continue
        values = frame[name].to_numpy(object)
        numbers, bad, separator = numbers_of(values, layout.decimal)
        if separator:
            notes.append(f"column {name!r}: {separator!r} taken as separator of thousands")
        if 2 * bad.sum() > (~pd.isna(values)).sum():
            continue
        mixed = numbers.astype(object)
        mixed[bad] = values[bad]
        frame[name] = mixed if bad.any() else numbers
        text[name] = bad
    return text, notes


def _without_footer(
    frame: pd.DataFrame, text: dict[str, np.ndarray], file: Path, layout: TextLayout
) -> tuple[pd.DataFrame, list[str]]:
    """Return the table without the lines behind the numbers, and a note about them.

    Raises InputError: numbers follow behind lines that hold none: a second table.
    """
    count, words = np.zeros(len(frame), np.int16), np.zeros(len(frame), np.int16)
    for name in frame.columns:
        bad = text.get(name)
        if frame[name].dtype.kind in "fiub":
            count += ~np.isnan(frame[name].to_numpy(np.float64))
        elif bad is None:
            # A column of text (dates, remarks) says nothing about where the numbers end.
            continue
        else:
            count += frame[name].notna().to_numpy() & ~bad
            words += bad
    rows = (count > words) & (count > 0)
    if rows.all():
        return frame, []
    end = int(np.argmin(rows))
    later = np.flatnonzero(rows[end:])
    if len(later):
        at = _line(file, layout, end)
        raise second_table(file, at + 1, f"the lines before line {at} ({_shown(file, layout, end)!r})")
    if len(frame) - end > _FOOTER_LINES:
        raise InputError(
            f"{file}, line {_line(file, layout, end)}: {len(frame) - end} lines without numbers begin with "
            f"{_shown(file, layout, end)!r}; allowed: up to {_FOOTER_LINES} lines behind the numbers"
        )
    kept = frame.iloc[:end]
    kept = pd.DataFrame(
        {
            name: pd.to_numeric(kept[name]) if name in text and not text[name][:end].any() else kept[name]
            for name in frame.columns
        },
        copy=False,
    )
    said = _shown(file, layout, end)
    if not said and end + 1 < len(rows):
        said = next((s for k in range(end, len(rows)) if (s := _shown(file, layout, k))), "")
    if not said:
        return kept, []
    return kept, [f"{counted(len(rows) - end, 'line')} behind the numbers passed over: {said!r}"]


def _numbered_line(file: Path, layout: TextLayout, row: int) -> tuple[int, str]:
    """Return the line of a row of the table, counted from 1, and its text; the parser passes over blank lines."""
    with file.open(encoding=layout.encoding, errors="replace", newline="") as stream:
        for number, line in enumerate(stream, 1):
            if number > layout.start and line.strip():
                if row == 0:
                    return number, line
                row -= 1
    return 0, ""


def _line(file: Path, layout: TextLayout, row: int) -> int:
    return _numbered_line(file, layout, row)[0]


def _shown(file: Path, layout: TextLayout, row: int) -> str:
    """Return what stands in a line, short."""
    line = cells(_numbered_line(file, layout, row)[1], layout.delimiter)
    return " ".join(cell for cell in line if cell)[:60]


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
