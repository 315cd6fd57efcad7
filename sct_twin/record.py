"""The raw record of one sliding compression test: 1 kHz channels in fixed units, checked once."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from friction_models.loads import FloatArray, InputError, atomic_path, missing_column

from .channels import CHANNEL_NAMES, CHANNELS

#: A shorter record cannot hold the upsetting and the sliding phase.
MIN_ROWS = 50


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
    s : array_like, shape (n,)
        Plate position [mm].
    a : array_like, shape (n,)
        Plate acceleration [mm/s2].
    T_plate : array_like, shape (n,)
        Plate temperature [degC].
    metadata : mapping
        The test's row of the test table (T_tool, v_set, punch geometry, ...).
    source : str
        Where it came from, for messages.

    Raises
    ------
    InputError
        Columns of different lengths, too few rows, values that are not finite or outside physical
        limits, time that does not increase, a force or a position that never changes.
    """

    test_id: str
    t: FloatArray
    F_n: FloatArray
    F_r: FloatArray
    s: FloatArray
    a: FloatArray
    T_plate: FloatArray
    metadata: Mapping[str, Any] = field(default_factory=dict)
    source: str = ""

    def __post_init__(self) -> None:
        where = self.source or f"test {self.test_id}"
        for name in CHANNEL_NAMES:
            object.__setattr__(self, name, _finite(getattr(self, name), name, where))
            if len(getattr(self, name)) != len(self.t):
                raise InputError(
                    f"{where}: column {name!r} has {len(getattr(self, name))} rows, 't' has {len(self.t)}; "
                    "all columns must have the same length"
                )
        if len(self.t) < MIN_ROWS:
            raise InputError(f"{where}: {len(self.t)} rows; a record needs at least {MIN_ROWS}")
        step = np.diff(self.t)
        if (step <= 0).any():
            row = int(np.argmax(step <= 0)) + 1
            raise InputError(
                f"{where}: column 't', row {row}: time {float(self.t[row])!r} s comes after "
                f"{float(self.t[row - 1])!r} s; time must increase"
            )
        for name in ("F_n", "F_r", "s"):
            column = getattr(self, name)
            if np.ptp(column) == 0.0:
                raise InputError(
                    f"{where}: column {name!r} is {float(column[0])!r} {CHANNELS[name].unit} in every row; "
                    "a constant signal is not a measurement"
                )

    @classmethod
    def from_frame(
        cls,
        test_id: str,
        frame: pd.DataFrame,
        metadata: Mapping[str, Any] | None = None,
        source: str = "",
    ) -> SctRecord:
        """Build from a table in canonical columns and units.

        Raises
        ------
        InputError
            A column is missing, or anything the constructor refuses.
        """
        where = source or f"test {test_id}"
        if len(frame) == 0:
            raise InputError(f"{where}: the record has no rows; allowed: at least {MIN_ROWS}")
        for name in CHANNEL_NAMES:
            if name not in frame.columns:
                raise missing_column(name, frame.columns, where)
        columns = {name: frame[name].to_numpy() for name in CHANNEL_NAMES}
        return cls(test_id=test_id, metadata=dict(metadata or {}), source=source, **columns)

    def __len__(self) -> int:
        return len(self.t)

    @property
    def sampling_rate(self) -> float:
        """Samples a second [Hz], from the median time step."""
        return float(1.0 / np.median(np.diff(self.t)))

    def number(self, name: str, default: float | None = None) -> float:
        """Return a number of the test's metadata.

        Raises
        ------
        InputError
            It is not recorded and has no default, or is not a finite number.
        """
        where = self.source or f"test {self.test_id}"
        value = self.metadata.get(name)
        if value is None or (isinstance(value, float) and np.isnan(value)) or value == "":
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
        return pd.DataFrame({name: getattr(self, name) for name in CHANNEL_NAMES})

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write a CSV with a header and a units row, atomically."""
        with atomic_path(path) as temporary:
            write_csv(temporary, self)
        return Path(path)


def write_csv(path: Path, record: SctRecord) -> None:
    """Write the channels as CSV: header, units row, rounded to what a data logger resolves."""
    import pyarrow as pa
    import pyarrow.csv as pa_csv

    digits = {"t": 6, "F_n": 1, "F_r": 2, "s": 5, "a": 1, "T_plate": 3}
    columns = [pa.array(np.round(getattr(record, name), digits[name])) for name in CHANNEL_NAMES]
    with path.open("wb") as stream:
        stream.write((",".join(CHANNEL_NAMES) + "\n").encode())
        stream.write((",".join(CHANNELS[name].unit for name in CHANNEL_NAMES) + "\n").encode())
        options = pa_csv.WriteOptions(include_header=False)
        pa_csv.write_csv(pa.table(columns, names=list(CHANNEL_NAMES)), stream, options)


def _finite(values: npt.ArrayLike, name: str, where: str) -> FloatArray:
    """Return the channel as float64, or name the row that is not a number or out of range."""
    quantity = CHANNELS[name]
    cells = np.asarray(values)
    if cells.dtype.kind not in "fiu":
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
            f"{where}: column {name!r}, row {row}: value {shown!r} is not a number from "
            f"{quantity.lower:g} to {quantity.upper:g} {quantity.unit}{last}"
        )
    return array
