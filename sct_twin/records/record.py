"""The raw record of one sliding compression test: channels in fixed units, checked once."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError, atomic_path
from friction_models.loads import FloatArray, missing_column

from .cells import Cell, is_given
from .channels import CHANNEL_NAMES, CHANNELS, MOTION, REQUIRED

if TYPE_CHECKING:  # FMUs of the solvers start without pandas
    import pandas as pd

#: A shorter record cannot hold the upsetting and the sliding phase.
MIN_ROWS = 50
#: Digits behind the point in the files that are written, and rows that are written at once.
_DIGITS = {"t": 9, "F_n": 1, "F_r": 2, "s": 5, "a": 1, "T_plate": 3, "v": 4}
_PIECE = 500_000


@dataclass(frozen=True, eq=False)
class SctRecord:
    """One test as it was measured.

    Parameters
    ----------
    test_id : str
        Name of the test.
    t : array_like, shape (n,)
        Time [s], strictly increasing.
    F_n, F_r : array_like, shape (n,)
        Normal force and force that drives the plate [N].
    s : array_like, shape (n,), optional
        Plate position [mm]; may be missing where there is a speed.
    a : array_like, shape (n,), optional
        Plate acceleration [mm/s2].
    T_plate : array_like, shape (n,), optional
        Plate temperature [degC].
    metadata : mapping
        The test's row of the test table (T_tool, v_set, punch geometry, ...).
    source : str
        Where it came from, for messages.
    v : array_like, shape (n,), optional
        Plate speed [mm/s]; may be missing where there is a position.
    first_line : int
        Line of the source that holds the first row, for messages; 0 where it is not known.

    Raises
    ------
    InputError
        Columns of different lengths, too few rows, values that are not finite or outside physical
        limits, time that does not increase, a force or a motion that never changes, neither position
        nor speed.

    Examples
    --------
    One second at 100 samples a second, over which the plate moves by 20 mm:

    >>> from sct_twin import SctRecord
    >>> t = np.arange(100) / 100
    >>> record = SctRecord("sct001", t, F_n=90e3 + 100 * t, F_r=7e3 + 10 * t, s=20 * t, metadata={"T_tool": 200})
    >>> len(record), round(record.sampling_rate, 6)
    (100, 100.0)
    >>> record.channels
    ('t', 'F_n', 'F_r', 's')
    >>> record.number("T_tool")
    200.0
    >>> SctRecord("sct001", t[:10], F_n=90e3 + t[:10], F_r=7e3 + t[:10], s=t[:10])
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: test sct001: 10 rows; a record needs at least 50
    """

    test_id: str
    t: FloatArray
    F_n: FloatArray
    F_r: FloatArray
    s: FloatArray | None = None
    a: FloatArray | None = None
    T_plate: FloatArray | None = None
    metadata: Mapping[str, Cell] = field(default_factory=dict)
    source: str = ""
    v: FloatArray | None = None
    first_line: int = 0

    def __post_init__(self) -> None:
        where = self.where
        for name in CHANNEL_NAMES:
            values = getattr(self, name)
            if values is None and name not in REQUIRED:
                continue
            object.__setattr__(self, name, _finite(values, name, where, self._place))
            if len(getattr(self, name)) != len(self.t):
                raise InputError(
                    f"{where}: column {name!r} has {len(getattr(self, name))} rows, 't' has {len(self.t)}; "
                    "all columns must have the same length"
                )
        if len(self.t) < MIN_ROWS:
            raise InputError(f"{where}: {len(self.t)} rows; a record needs at least {MIN_ROWS}")
        late = self.t[1:] > self.t[:-1]
        if not late.all():
            row = int(np.argmin(late)) + 1
            raise InputError(
                f"{where}: column 't', {self._place(row)}: time {float(self.t[row])!r} s comes after "
                f"{float(self.t[row - 1])!r} s; time must increase (where a second measurement begins there, "
                "give it a file of its own)"
            )
        if all(getattr(self, name) is None for name in MOTION):
            raise InputError(
                f"{where}: neither a position 's' nor a speed 'v'; allowed: one of both at least"
            )
        for name in ("F_n", "F_r", *MOTION):
            column = getattr(self, name)
            if column is not None and np.ptp(column) == 0.0:
                raise InputError(
                    f"{where}: column {name!r} is {float(column[0])!r} {CHANNELS[name].unit} in every row; "
                    "a constant signal is not a measurement"
                )

    @classmethod
    def from_frame(
        cls,
        test_id: str,
        frame: pd.DataFrame,
        metadata: Mapping[str, Cell] | None = None,
        source: str = "",
    ) -> SctRecord:
        """Build from a table in canonical columns and units.

        Raises
        ------
        InputError
            A column is missing, or anything the constructor refuses.

        Examples
        --------
        >>> import pandas as pd
        >>> t = np.arange(100) / 100
        >>> table = pd.DataFrame({"t": t, "F_n": 90e3 + 100 * t, "F_r": 7e3 + 10 * t, "v": 20 + t})
        >>> SctRecord.from_frame("sct001", table).channels
        ('t', 'F_n', 'F_r', 'v')
        """
        where = source or f"test {test_id}"
        if len(frame) == 0:
            raise InputError(f"{where}: the record has no rows; allowed: at least {MIN_ROWS}")
        for name in REQUIRED:
            if name not in frame.columns:
                raise missing_column(name, frame.columns, where)
        channels = {name: frame[name].to_numpy() for name in CHANNEL_NAMES if name in frame.columns}
        return cls.of_channels(test_id, channels, dict(metadata or {}), source)

    @classmethod
    def of_channels(
        cls,
        test_id: str,
        channels: Mapping[str, FloatArray],
        metadata: Mapping[str, Cell],
        source: str,
        first_line: int = 0,
    ) -> SctRecord:
        """Build from channels by name, of which the required ones are there."""
        t, F_n, F_r = (channels[name] for name in REQUIRED)
        s, a, T_plate, v = (channels.get(name) for name in ("s", "a", "T_plate", "v"))
        return cls(test_id, t, F_n, F_r, s, a, T_plate, metadata, source, v, first_line)

    def __len__(self) -> int:
        return len(self.t)

    def _place(self, row: int) -> str:
        return f"line {self.first_line + row}" if self.first_line else f"row {row}"

    @property
    def where(self) -> str:
        """What messages call this record."""
        return self.source or f"test {self.test_id}"

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that were recorded."""
        return tuple(name for name in CHANNEL_NAMES if getattr(self, name) is not None)

    @property
    def sampling_rate(self) -> float:
        """Samples a second [Hz], from the median time step."""
        return 1.0 / usual_step(self.t)

    def number(self, name: str, default: float | None = None) -> float:
        """Return a number of the test's metadata.

        Raises
        ------
        InputError
            It is not recorded and has no default, or is not a finite number.
        """
        where = self.where
        value: Any = self.metadata.get(name)
        if not is_given(value):
            if default is None:
                raise missing_column(name, list(self.metadata), f"{where}: test table")
            return default
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise InputError(f"{where}: metadata {name!r} is {value!r}; allowed: a number") from None
        if not np.isfinite(number):
            raise InputError(f"{where}: metadata {name!r} is {value!r}; allowed: a finite number")
        return number

    def to_frame(self) -> pd.DataFrame:
        """Return the channels as a table in canonical units."""
        import pandas as pd

        return pd.DataFrame({name: getattr(self, name) for name in self.channels}, copy=False)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write a CSV with a header and a units row, atomically."""
        with atomic_path(path) as temporary:
            write_csv(temporary, self.to_frame())
        return Path(path)


def usual_step(t: FloatArray) -> float:
    """Return the median step of a time [s], of some 500 000 pairs of samples where there are more.

    >>> usual_step(np.array([0.0, 0.5, 1.0, 1.5, 60.0]))
    0.5
    """
    first = np.arange(0, len(t) - 1, max(1, len(t) // _PIECE))
    return float(np.median(t[first + 1] - t[first]))


def write_csv(path: Path, columns: Mapping[str, npt.ArrayLike] | pd.DataFrame) -> None:
    """Write channels in canonical units as CSV: header, units row, rounded to what a data logger resolves."""
    import pyarrow as pa
    import pyarrow.csv as pa_csv

    names = [name for name in CHANNEL_NAMES if name in columns]
    values = [np.asarray(columns[name], dtype=np.float64) for name in names]
    options = pa_csv.WriteOptions(include_header=False)
    with path.open("wb") as stream:
        stream.write((",".join(names) + "\n").encode())
        stream.write((",".join(CHANNELS[name].unit for name in names) + "\n").encode())
        # In pieces: a rounded copy of ten million rows would not fit beside the record.
        for start in range(0, len(values[0]), _PIECE):
            rows = slice(start, start + _PIECE)
            rounded = [pa.array(np.round(v[rows], _DIGITS[n])) for n, v in zip(names, values)]
            pa_csv.write_csv(pa.table(rounded, names=names), stream, options)


def _finite(values: npt.ArrayLike, name: str, where: str, place: Callable[[int], str]) -> FloatArray:
    """Return the channel as float64, or name the row that is not a number or out of range."""
    quantity = CHANNELS[name]
    cells = np.asarray(values)
    if cells.dtype.kind not in "fiu":
        import pandas as pd

        cells = pd.to_numeric(pd.Series(cells.ravel(), dtype=object), errors="coerce").to_numpy()
        original = np.asarray(values, dtype=object).ravel()
    else:
        original = cells
    array = np.ascontiguousarray(cells, dtype=np.float64)
    if array.ndim != 1:
        raise InputError(f"{where}: column {name!r} has shape {array.shape}, allowed: (n,)")
    good = np.isfinite(array) & (array >= quantity.lower) & (array <= quantity.upper)
    if not good.all():
        row = int(np.argmin(good))
        last = "; the file looks truncated" if row == len(array) - 1 and not np.isfinite(array[row]) else ""
        shown = original[row].item() if isinstance(original[row], np.generic) else original[row]
        raise InputError(
            f"{where}: column {name!r}, {place(row)}: value {shown!r} is not a number from "
            f"{quantity.lower:g} to {quantity.upper:g} {quantity.unit}{last}"
        )
    return array
