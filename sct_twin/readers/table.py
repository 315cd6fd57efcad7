"""The table that every reader returns, and the size limits of all readers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from friction_models.common import InputError, check_readable
from friction_models.loads import FloatArray

#: Larger files are refused instead of filling the memory (10 million rows of six channels fit).
MAX_BYTES = 2 * 1024**3
#: More rows or columns than a test can have.
MAX_ROWS = 20_000_000
MAX_COLUMNS = 2_000
#: Cells of one table: 20 million rows of ten channels, 1.6 GB.
MAX_CELLS = 200_000_000

_TIME = re.compile(r"^(t|time|timestamps?|zeit|temps|tempo)\b|\b(time|zeit)\b", re.IGNORECASE)
_BRACKET = re.compile(r"^(.*\S)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*$")


def check_file(file: Path) -> None:
    """Raise before a file is opened that is not there, empty or too large.

    Raises InputError: names the file and what is allowed.
    """
    check_readable(file, MAX_BYTES, "a file of measurements")
    if file.stat().st_size == 0:
        raise InputError(f"{file}: the file is empty; allowed: a header, a units row and rows of numbers")


@dataclass(frozen=True)
class RawTable:
    """Columns as they stand in a file, and the unit of each (empty where the file names none).

    Attributes
    ----------
    frame : pandas.DataFrame
        One column a channel, all on one time base.
    units : dict
        Unit of each column, '' where the file names none.
    source : str
        The file, for messages.
    format : str
        What the file turned out to be.
    notes : tuple of str
        What the reader did or left out, for the user to see.
    first_line : int
        Line of the file that holds the first row, where every row has a line of its own; else 0.

    Examples
    --------
    >>> table = RawTable(pd.DataFrame({"F": [1.0, "overload", 3.0]}), {"F": "kN"}, "test.csv", first_line=3)
    >>> numbers, row = table.numbers("F")
    >>> numbers.tolist(), row, table.place(row)
    ([1.0, nan, 3.0], 1, 'line 4')
    """

    frame: pd.DataFrame
    units: dict[str, str]
    source: str
    format: str = "CSV"
    notes: tuple[str, ...] = ()
    first_line: int = 0

    def place(self, row: int) -> str:
        """Return where a row stands, for messages: its line in the file where that is known."""
        return f"line {self.first_line + row}" if self.first_line else f"row {row}"

    def numbers(self, name: str) -> tuple[FloatArray, int | None]:
        """Return a column as numbers (NaN for text and empty cells) and the first row that holds text, if any."""
        values = self.frame[name]
        if values.dtype.kind in "fiu":
            return values.to_numpy(np.float64), None
        numbers = pd.to_numeric(values, errors="coerce")
        text = (numbers.isna() & values.notna()).to_numpy()
        return numbers.to_numpy(np.float64), int(np.argmax(text)) if text.any() else None


@dataclass
class Signal:
    """One channel of a file that stores channels one by one, with its own time where it has one."""

    name: str
    unit: str
    values: npt.NDArray[Any]
    time: npt.NDArray[Any] | None = None
    group: str = ""
    #: Seconds of all signals are in this unit; a time channel of the file keeps its own.
    time_name: str = "t"
    time_unit: str = "s"


def split_unit(name: str) -> tuple[str, str]:
    """Return (name, unit) of a heading such as ``Force [kN]`` or ``Force (kN)``; '' without a unit.

    >>> split_unit("Force [kN]"), split_unit("Force (kN)"), split_unit("Force")
    (('Force', 'kN'), ('Force', 'kN'), ('Force', ''))
    """
    match = _BRACKET.match(name.strip())
    if match is None:
        return name.strip(), ""
    return match[1].strip(), (match[2] if match[2] is not None else match[3]).strip()


def is_time(name: str) -> bool:
    """Whether a channel of this name is the time base of its neighbours.

    >>> is_time("Time [s]"), is_time("Zeit"), is_time("Force")
    (True, True, False)
    """
    return bool(_TIME.search(name.strip()))


def check_shape(rows: int, columns: int, where: str) -> None:
    """Refuse a table that would fill the memory. Raises InputError: too many rows, columns or cells."""
    if not 0 <= rows <= MAX_ROWS or not 0 <= columns <= MAX_COLUMNS or rows * columns > MAX_CELLS:
        raise InputError(
            f"{where}: {rows} rows in {columns} columns; allowed: at most {MAX_ROWS} rows, "
            f"{MAX_COLUMNS} columns and {MAX_CELLS} cells"
        )


def table_of_signals(signals: Sequence[Signal], where: str, kind: str, notes: Sequence[str] = ()) -> RawTable:
    """Put channels of one or several rates on the time base of the fastest.

    A slower channel with a time of its own is interpolated linearly, its ends held; one of another
    length without a time cannot be placed and is left out with a note.

    Raises InputError: no channel, or more cells than allowed.

    A slow channel is interpolated to the times of the fast one:

    >>> fast = Signal("F", "kN", np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 0.1, 0.2, 0.3]))
    >>> slow = Signal("T", "degC", np.array([20.0, 50.0]), np.array([0.0, 0.3]))
    >>> table = table_of_signals([fast, slow], "test.mf4", "MDF")
    >>> table.frame["T"].round(6).tolist()
    [20.0, 30.0, 40.0, 50.0]
    >>> table.notes
    ("channel 'T': 2 rows interpolated to 4",)
    """
    signals = [signal for signal in signals if len(signal.values)]
    if not signals:
        raise InputError(f"{where}: no channel with numbers in this {kind} file; allowed: at least one")
    timed = [signal for signal in signals if signal.time is not None and len(signal.time) > 1]
    base = max(timed or signals, key=lambda signal: len(signal.values))
    rows = len(base.values)
    check_shape(rows, len(signals), where)
    said = list(notes)
    columns: dict[str, npt.NDArray[Any]] = {}
    units: dict[str, str] = {}
    grid = None if base.time is None else np.asarray(base.time, np.float64)
    if grid is not None:
        columns[base.time_name] = grid
        units[base.time_name] = base.time_unit
    for signal in signals:
        values = signal.values
        own = None if signal.time is None else np.asarray(signal.time, np.float64)
        same = len(values) == rows and (own is None or grid is None or np.array_equal(own, grid))
        if not same:
            if own is None or grid is None or len(own) != len(values) or len(own) < 2:
                said.append(f"channel {signal.name!r} has {len(values)} rows and no time: left out")
                continue
            if not (np.isfinite(own).all() and (np.diff(own) > 0).all()):
                said.append(f"channel {signal.name!r} has a time that does not increase: left out")
                continue
            values = np.interp(grid, own, values.astype(np.float64))
            said.append(f"channel {signal.name!r}: {len(own)} rows interpolated to {rows}")
        name = signal.name
        if name in columns and signal.group:
            name = f"{signal.group}/{name}"
        number = 2
        while name in columns:
            name = f"{signal.name} ({number})"
            number += 1
        columns[name] = values
        units[name] = signal.unit
    return RawTable(pd.DataFrame(columns), units, where, kind, tuple(said))


def text_of(value: object, limit: int = 200) -> str:
    """Return a short printable text of what a file says about a channel."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return "".join(c for c in text[:limit] if c.isprintable()).strip()
