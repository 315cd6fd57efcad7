"""Reading of tables: CSV files of spreadsheets and loggers in any language, or Parquet, converted to the contract's units."""

from __future__ import annotations

import codecs
import csv
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd

from ..common.byte_order_marks import marked_encoding
from ..common.errors import InputError, check_readable, shown
from ..common.files import atomic_path
from ..common.imports.extras import need
from ..common.units import UNITS, conversion, differs, spelling
from .contract import POINT_UNITS, SETTING_UNITS, UNCERTAINTY_UNITS

#: Largest table that is read; larger files are refused instead of filling the memory.
MAX_BYTES = 2 * 1024**3
#: Columns whose unit is known: those of points, and what tests are set to.
KNOWN_UNITS: dict[str, str] = {**SETTING_UNITS, **UNCERTAINTY_UNITS, **POINT_UNITS}
#: Columns that decide what a file is for; another spelling of one of them is not left unread.
_NEEDED = ("test_id", *POINT_UNITS, "role", "synthetic")
#: What separates the columns of a text file.
SEPARATORS = ",;\t|"
_TEXT = (".csv", ".txt", ".dat", ".tsv", ".asc")
#: Rows from which separator, decimal sign and width are taken.
_SAMPLE = 200
_WITH_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_WITH_POINT = re.compile(r"[+-]?\d*\.\d+([eE][+-]?\d+)?")
#: A row of names: one of its cells is `test_id`.
_HEADER = re.compile(r"""(^|[,;\t|])\s*"?test_id"?\s*(\[[^]]*\]\s*)?($|[,;\t|\r\n])""")
#: What is no separator in a header. A bracket ends at the next one of either kind: else thousands that open, and never close, are each
#: followed to the end of the line.
_QUOTED = re.compile(r'"[^"]*"|\[[^\[\]]*\]')
_ROUND = re.compile(r"^(.*\S)\s*\(([^()]*)\)$")


@dataclass(frozen=True)
class Table:
    """A table as it stands in its file."""

    #: Cells as they stand in the file, under bare column names.
    frame: pd.DataFrame
    #: Unit of each column for which the file names one.
    units: dict[str, str]
    #: How the file names each column.
    headings: list[str]
    #: The file, for messages.
    where: str

    def converted(self, known: Mapping[str, str] = KNOWN_UNITS) -> pd.DataFrame:
        """Return the columns with those of known quantities in the units that `known` gives.

        Raises InputError: a unit that does not measure the quantity, or text that would have to be converted.
        """
        frame = self.frame.copy(deep=False)
        for name, unit in self.units.items():
            if not differs(name, unit, known):
                continue
            factor, offset = conversion(known[name], unit, name, self.where)
            values = pd.to_numeric(frame[name], errors="coerce")
            # of durations, dates and True pandas makes numbers
            other = frame[name].dtype.kind in "mMb"
            bad = (frame[name].notna() & (values.isna() | other)).to_numpy()
            if bad.any():
                row = int(np.argmax(bad))
                raise InputError(
                    f"{self.where}: column {name!r}, row {row}: value {frame[name].iloc[row]!r} is not a number [{unit}]"
                )
            # of a difference no zero is converted
            frame[name] = values.astype(np.float64) * factor + (0.0 if name in UNCERTAINTY_UNITS else offset)
        return frame

    def with_columns(self, rows: np.ndarray, **columns: np.ndarray) -> pd.DataFrame:
        """Return the table as the file has it, with further columns; rows that `rows` does not name get NaN."""
        frame = self.frame.copy(deep=False)
        # A unit from a row of units goes into the heading where nobody would expect it.
        frame.columns = pd.Index(
            [
                f"{name} [{self.units[name]}]"
                if heading == name and differs(name, self.units.get(name, ""), KNOWN_UNITS)
                else heading
                for name, heading in zip(self.frame.columns, self.headings, strict=True)
            ]
        )
        for name, values in columns.items():
            whole = np.full(len(frame), np.nan)
            whole[rows] = values
            frame[name] = whole
        return frame


def read_table(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read a table in the units of the contract; see `read_file` and `Table.converted`.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "points.csv"
    ...     pd.DataFrame({"test_id": ["a"], "T [K]": [293.15], "sigma_n [GPa]": [0.5]}).to_csv(file, index=False)
    ...     table = read_table(file)
    >>> table[["T", "sigma_n"]].values.tolist()
    [[20.0, 500.0]]
    """
    return read_file(path).converted()


def read_file(
    path: str | os.PathLike[str], known: Mapping[str, str] = KNOWN_UNITS, max_bytes: int = MAX_BYTES
) -> Table:
    """Read a CSV or Parquet table as it stands in the file.

    CSV: comma, semicolon, tab or vertical bar, decimal point or comma; lines above a row of names with `test_id` are passed over; UTF-8, UTF-16 with a byte order mark, or Windows-1252. Units
    stand in the header (``T [K]``, ``T (K)``) or in a row below it.

    `known` has the unit of each column that measures a known quantity: by them a row of units is told from numbers.

    Raises InputError: no such file, empty, too large, not a table, a column that stands twice, values without
    a column.
    """
    file = Path(path)
    check_readable(file, max_bytes, "a CSV or Parquet file")
    try:
        if file.suffix.lower() == ".parquet":
            need("pyarrow", "solvers", f"{file}: a Parquet file")
            frame = pd.read_parquet(file)
            headings = [str(c) for c in frame.columns]
            names, units = _names(headings, str(file), known)
            frame.columns = pd.Index(names)
        elif file.suffix.lower() in _TEXT:
            frame, headings, units = _read_csv(file, known)
        else:
            raise InputError(
                f"{file}: suffix {file.suffix!r} is not readable, allowed: .csv, .parquet, {', '.join(_TEXT[1:])}"
            )
    except InputError:
        raise
    # Also of damaged Parquet.
    except (ValueError, LookupError, TypeError, RuntimeError, OSError, csv.Error) as error:
        raise InputError(f"{file}: not a readable table ({shown(error)})") from None
    if frame.columns.empty or frame.empty:
        raise InputError(f"{file}: the table has no rows; allowed: rows below the names of the columns")
    if "test_id" in frame.columns:
        # A million points have a hundred names.
        codes, tests = pd.factorize(frame["test_id"])
        stripped = np.array([*(str(name).strip() for name in tests), np.nan], dtype=object)
        frame["test_id"] = stripped[codes]
    return Table(frame, units, headings, str(file))


def _read_csv(file: Path, known: Mapping[str, str]) -> tuple[pd.DataFrame, list[str], dict[str, str]]:
    """Return the cells under bare names, the headings, and the units."""
    encoding = encoding_of(file)
    above, separator = header_of(file)
    with file.open(encoding=encoding, newline="") as stream:
        rows = csv.reader(islice(stream, above, None), delimiter=separator, skipinitialspace=True)
        filled = ((above + rows.line_num, row) for row in rows if any(map(str.strip, row)))
        (skip, headings), *sample = islice(filled, _SAMPLE)
    headings = [h.strip() for h in headings]
    if len(headings) == 1 and "test_id" in headings[0].split()[1:] + headings[0].split()[:-1]:
        raise InputError(
            f"{file}: blanks between the columns ({shown(headings[0], 30)!r}); allowed: comma, semicolon, tab or vertical bar"
        )
    declared = len(headings)
    names, units = _names(headings, str(file), known)
    if sample and (row_units := _units_row(names, sample[0][1], known)):
        units = {**row_units, **units}
        skip = sample.pop(0)[0]
    width = max((len(row) for _, row in sample), default=0)
    headings += [""] * (width - len(headings))
    names += [f"Unnamed: {k}" for k in range(len(names), width)]
    with file.open(encoding=encoding, newline="") as stream:
        for _ in islice(stream, skip):
            pass
        try:
            frame = pd.read_csv(
                stream,
                sep=separator,
                decimal=_decimal(separator, names, [row for _, row in sample], known),
                header=None,
                names=names,
                index_col=False,
                dtype={"test_id": str},
                skipinitialspace=True,
                low_memory=False,
            )
        except pd.errors.EmptyDataError:
            raise InputError(
                f"{file}: the table has no rows; allowed: rows below the names of the columns"
            ) from None
    return *_without_blanks(frame, headings, declared, file), units


def header_of(file: Path) -> tuple[int, str]:
    """Return how many lines stand above the names of the columns, and the separator of a text file."""
    with file.open(encoding=encoding_of(file), newline="") as stream:
        lines = [(k, line) for k, line in enumerate(islice(stream, _SAMPLE)) if line.strip()]
    if not lines:
        raise InputError(f"{file}: the file is empty; allowed: names of columns, and rows below them")
    # What a laboratory writes above the names of the columns is passed over.
    above, header = next(((k, line) for k, line in lines if _HEADER.search(line)), lines[0])
    return above, max(SEPARATORS, key=_QUOTED.sub("", header).count)


def bounded(cells: pd.Series) -> pd.Series:
    """Return cells in which whole numbers that no float holds are infinite; pandas hands them on as they are."""
    return cells.map(lambda cell: float(str(cell)) if type(cell) is int else cell)


def _without_blanks(
    frame: pd.DataFrame, headings: list[str], declared: int, file: Path
) -> tuple[pd.DataFrame, list[str]]:
    """Leave out rows and unnamed columns without any value, as separators at the ends of lines make them."""
    for name in frame.columns[frame.dtypes.map(lambda kind: kind == np.dtype(object)).to_numpy(bool)]:
        frame[name] = bounded(frame[name])
    empty = frame.isna().to_numpy()
    kept = [bool(heading) or not empty[:, k].all() for k, heading in enumerate(headings)]
    if any(kept[declared:]):
        extra = declared + kept[declared:].index(True)
        row = int(np.argmin(empty[:, extra]))
        raise InputError(
            f"{file}: row {row} has the value {str(frame.iloc[row, extra])!r} in column {extra + 1}, the header names "
            f"{declared}; allowed: a name for every column"
        )
    frame = frame.drop(columns=[name for name, keep in zip(frame.columns, kept, strict=True) if not keep])
    if blank := np.flatnonzero(empty.all(axis=1)).tolist():
        frame = frame.drop(index=blank).reset_index(drop=True)
    return frame, [h for h, keep in zip(headings, kept, strict=True) if keep]


def _names(headings: list[str], where: str, known: Mapping[str, str]) -> tuple[list[str], dict[str, str]]:
    """Return the bare name of every column (``"T [K]"`` is ``"T"``), and the units by name.

    Raises InputError: a column stands twice, or differs from one that decides what the table says in capitals
    or blanks only.
    """
    names: list[str] = []
    units: dict[str, str] = {}
    for k, heading in enumerate(headings):
        name, bracket, unit = (part.strip() for part in heading.partition("["))
        match = None if bracket else _ROUND.match(heading)
        # In round brackets anything may stand: only a unit is taken for one.
        if match and match[1] in known and spelling(match[2]) in UNITS:
            name, unit = match[1], match[2]
        name = name or f"Unnamed: {k}"
        if name in names:
            other = headings[names.index(name)]
            shown = "" if heading == other else f", as {other!r} and as {heading!r}"
            raise InputError(f"{where}: column {name!r} stands twice in the header{shown}; allowed: once")
        names.append(name)
        if unit := unit.rstrip("] ").strip():
            units[name] = unit
    for name in names:
        meant = {_folded(n): n for n in _NEEDED if n != "t"}.get(_folded(name), name)
        if name not in _NEEDED and meant != name and (meant in names or meant in {"role", "synthetic"}):
            beside = " beside it" if meant in names else ""
            raise InputError(f"{where}: column {name!r}; allowed: {meant!r}{beside}, or a name of its own")
    return names, units


def _folded(name: str) -> str:
    return re.sub(r"[\s_]", "", name).casefold()


def _units_row(names: list[str], cells: list[str], known: Mapping[str, str]) -> dict[str, str]:
    """Return the units of the first row below the header by column, empty where it is a row of values."""
    by_name = {n: c.strip().strip("[]()").strip() for n, c in zip(names, cells, strict=False)}
    quantities = [cell for name, cell in by_name.items() if name in known]
    units = [c for c in quantities if re.match(r"[A-Za-z°%µμ℃]", c) and c.lower() not in _NO_VALUE]
    if not units or any(c not in units and c not in {"1", "-", ""} for c in quantities):
        return {}
    # A row that names a test holds its texts, or the names of the columns once more.
    if by_name.get("test_id", "") not in {"", "-", "1"} and any(spelling(c) not in UNITS for c in units):
        return {}
    return {name: cell for name, cell in by_name.items() if cell}


#: What stands for a missing value and not for a unit.
_NO_VALUE = {"nan", "inf", "na", "n/a", "null", "none", "true", "false"}


def _decimal(separator: str, names: list[str], rows: list[list[str]], known: Mapping[str, str]) -> str:
    """Return the decimal sign: a comma where numbers have one and do not have a point."""
    if separator == ",":
        return "."
    cells = [[cell.strip() for name, cell in zip(names, row, strict=False) if name in known] for row in rows]
    for chosen in (cells, rows):
        comma, point = (
            any(form.fullmatch(cell.strip()) for row in chosen for cell in row)
            for form in (_WITH_COMMA, _WITH_POINT)
        )
        if comma or point:
            return "," if comma and not point else "."
    return "."


def encoding_of(file: Path) -> str:
    """Return the encoding of a text file; raises ValueError for binary content."""
    decoder = codecs.getincrementaldecoder("utf-8")()
    with file.open("rb") as stream:
        encoding = marked_encoding(stream.read(4))
        if encoding != "utf-8-sig":
            return encoding
        stream.seek(0)
        while block := stream.read(1 << 24):
            if b"\0" in block:
                raise ValueError("binary content; allowed: text")
            if encoding == "utf-8-sig":
                try:
                    decoder.decode(block)
                except UnicodeDecodeError:
                    encoding = "cp1252"
    return encoding


def write_table(path: Path, frame: pd.DataFrame) -> None:
    """Write a table as CSV or, by its suffix, as Parquet, atomically; raises InputError without the library for Parquet."""
    if path.suffix != ".csv":
        need("pyarrow", "solvers", f"{path}: a Parquet file")
    with atomic_path(path) as temporary:
        if path.suffix == ".csv":
            frame.to_csv(temporary, index=False, lineterminator="\n")
        else:
            frame.to_parquet(temporary, index=False)
