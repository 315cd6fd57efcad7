"""A data set on disk: `points.csv`, `tests.csv`, `dataset.json` in one folder, or a single file of points."""

from __future__ import annotations

import csv
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from .contract import LOADS, MU, POINT_COLUMNS, POINT_UNITS, QUANTITIES, check_units
from .errors import InputError
from .files import atomic_folder, read_json, write_json
from .tribo_loads import TriboLoads, check_column, missing_column

#: Largest table that is read; larger files are refused instead of filling the memory.
MAX_BYTES = 2 * 1024**3


def read_table(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read a CSV (with or without a units row) or Parquet table; units that do not fit are refused.

    Parameters
    ----------
    path : path-like
        ``.csv`` or ``.parquet``.

    Returns
    -------
    pandas.DataFrame
        Columns without their unit suffix (``"T [degC]"`` becomes ``"T"``).

    Raises
    ------
    InputError
        No such file, empty, too large, not a table, or a unit other than the contract's.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError(f"{file}: no such file")
    if file.stat().st_size > MAX_BYTES:
        raise InputError(f"{file}: {file.stat().st_size} bytes, allowed: at most {MAX_BYTES}")
    row_units: dict[str, str] = {}
    try:
        if file.suffix == ".parquet":
            frame = pd.read_parquet(file)
        elif file.suffix == ".csv":
            row_units = units_row(file)
            skip = [1] if row_units else None
            frame = pd.read_csv(file, dtype={"test_id": str}, low_memory=False, skiprows=skip)
        else:
            raise InputError(f"{file}: suffix {file.suffix!r} is not readable, allowed: .csv, .parquet")
    except InputError:
        raise
    except pd.errors.EmptyDataError:
        raise InputError(f"{file}: the file is empty") from None
    except (ValueError, OSError) as error:
        raise InputError(f"{file}: not a readable table ({str(error).splitlines()[0]})") from None
    if frame.columns.empty or frame.empty:
        raise InputError(f"{file}: the table has no rows")
    check_units({**row_units, **header_units(frame, str(file))}, str(file))
    return frame


def header_units(frame: pd.DataFrame, where: str) -> dict[str, str]:
    """Take the units out of the column names (``"T [degC]"`` becomes ``"T"``) and return them by column.

    Raises
    ------
    InputError
        A column stands twice.
    """
    units: dict[str, str] = {}
    names = []
    for column in map(str, frame.columns):
        name, bracket, unit = column.partition("[")
        names.append(name.strip())
        if bracket:
            units[name.strip()] = unit.rstrip("] ").strip()
    frame.columns = pd.Index(names)
    if frame.columns.duplicated().any():
        twice = frame.columns[frame.columns.duplicated()][0]
        raise InputError(f"{where}: column {twice!r} stands twice in the header; allowed: once")
    return units


def units_row(file: Path, encoding: str = "utf-8") -> dict[str, str]:
    """Return the units of the second line of a CSV by column, empty when that line holds numbers."""
    with file.open(encoding=encoding, newline="") as stream:
        rows = csv.reader(stream)
        header, second = next(rows, []), next(rows, [])
    cells = {h.partition("[")[0].strip(): c.strip("[] ") for h, c in zip(header, second, strict=False)}
    quantities = [cells[c] for c in cells if c in POINT_UNITS]
    texts = [c for c in quantities if re.match(r"[A-Za-z°%]", c) and c.lower() not in {"nan", "inf", "na"}]
    unit_like = all(c in texts or c in {"1", "-", ""} for c in quantities)
    return cells if texts and unit_like else {}


def check_points(frame: pd.DataFrame, where: str = "data", need_mu: bool = True) -> pd.DataFrame:
    """Return the points with checked columns: the contract's first, others behind.

    Raises
    ------
    InputError
        A column is missing, a value is not finite or outside its physical limits, or time runs
        backwards within a test; the message names column, row and value.
    """
    frame = frame.copy()
    if "test_id" not in frame.columns:
        raise missing_column("test_id", frame.columns, where)
    blank = frame["test_id"].isna()
    if blank.any():
        raise InputError(
            f"{where}: column 'test_id', row {int(np.argmax(blank))}: no value; allowed: any name"
        )
    frame["test_id"] = frame["test_id"].astype(str)
    for quantity in (*LOADS, *((MU,) if need_mu else ())):
        if quantity.name not in frame.columns:
            raise missing_column(quantity.name, frame.columns, where)
        frame[quantity.name] = check_column(frame[quantity.name].to_numpy(), quantity, where)
    if "t" in frame.columns:
        frame["t"] = check_column(frame["t"].to_numpy(), QUANTITIES["t"], where)
        step = frame["t"].diff()
        backwards = (step < 0) & (frame["test_id"] == frame["test_id"].shift())
        if backwards.any():
            row = int(np.argmax(backwards))
            raise InputError(
                f"{where}: column 't', row {row}: time {float(frame['t'].iloc[row])!r} s comes after "
                f"{float(frame['t'].iloc[row - 1])!r} s; time must not run backwards within a test"
            )
    front = [c for c in POINT_COLUMNS if c in frame.columns]
    return frame[front + [c for c in frame.columns if c not in front]]


def read_points(path: str | os.PathLike[str], need_mu: bool = True) -> pd.DataFrame:
    """Read and check a file of points (CSV or Parquet); see `read_table` and `check_points`."""
    return check_points(read_table(path), str(path), need_mu)


@dataclass
class DataSet:
    """Points and tests that belong together.

    Attributes
    ----------
    points : pandas.DataFrame
        One row a point: `POINT_COLUMNS`, more columns allowed.
    tests : pandas.DataFrame or None
        One row a test: `test_id` and any metadata; the optional column `role` holds ``train`` or
        ``test`` and marks the tests that are held out.
    info : dict
        Content of `dataset.json`: ``synthetic`` (bool), provenance, versions.
    """

    points: pd.DataFrame
    tests: pd.DataFrame | None = None
    info: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        # The points carry their provenance, so that a model fitted on them says whether they are synthetic.
        self.points.attrs.update(self.info)

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        tests: str | os.PathLike[str] | None = None,
        need_mu: bool = True,
    ) -> DataSet:
        """Read a data-set folder, or a single CSV/Parquet file of points with an optional test table.

        Raises
        ------
        InputError
            Anything that `read_points` refuses; a test that the points name twice or the table lacks.
        """
        source = Path(path)
        info: dict[str, Any] = {}
        table = Path(tests) if tests is not None else None
        if source.is_dir():
            points_file = next(
                (source / n for n in ("points.csv", "points.parquet") if (source / n).is_file()), None
            )
            if points_file is None:
                raise missing_points(source)
            if table is None and (source / "tests.csv").is_file():
                table = source / "tests.csv"
            info = read_info(source)
        else:
            points_file = source
        points = read_points(points_file, need_mu)
        frame = None
        if table is not None:
            frame = read_table(table)
            if "test_id" not in frame.columns:
                raise missing_column("test_id", frame.columns, str(table))
            frame["test_id"] = frame["test_id"].astype(str)
            if frame["test_id"].duplicated().any():
                twice = frame["test_id"][frame["test_id"].duplicated()].iloc[0]
                raise InputError(f"{table}: test_id {twice!r} stands in two rows; allowed: one row a test")
            if says_synthetic(frame):
                info["synthetic"] = True
        return cls(points, frame, info)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write `points.csv` (with a units row), `tests.csv` and `dataset.json`, atomically."""
        with atomic_folder(folder) as temporary:
            self.write_into(temporary)
        return Path(folder)

    def write_into(self, folder: Path) -> None:
        """Write the three files into an existing folder (not atomic; see `save`)."""
        extra = self.info.get("extra_units")
        known = {**(extra if isinstance(extra, dict) else {}), **POINT_UNITS}
        with (folder / "points.csv").open("w", encoding="utf-8", newline="\n") as stream:
            head = csv.writer(stream, lineterminator="\n")
            head.writerows([self.points.columns, [str(known.get(c, "")) for c in self.points.columns]])
            self.points.to_csv(stream, index=False, header=False, lineterminator="\n")
        if self.tests is not None:
            self.tests.to_csv(folder / "tests.csv", index=False, lineterminator="\n")
        write_json(folder / "dataset.json", {"units": POINT_UNITS, **self.info})

    @property
    def synthetic(self) -> bool:
        """Whether the points come from a virtual laboratory."""
        return bool(self.info.get("synthetic", False))

    def select(self, role: str | None) -> DataSet:
        """Return the tests of one role (``train`` or ``test``); all of them where no role is recorded."""
        if role is None or self.tests is None or "role" not in self.tests.columns:
            return self
        tests = self.tests[self.tests["role"] == role].reset_index(drop=True)
        points = self.points[self.points["test_id"].isin(tests["test_id"])].reset_index(drop=True)
        return DataSet(points, tests, self.info)

    def frames(self) -> tuple[pd.DataFrame, pd.DataFrame]:
        """Return the points of the training and of the held-out tests."""
        return self.select("train").points, self.select("test").points

    def loads(self) -> TriboLoads:
        """Return the loads of all points, with time, test and metadata."""
        return TriboLoads.from_frame(self.points, self.tests)


def missing_points(folder: Path) -> InputError:
    """Build the error for a folder that is no data set; of raw records it says what makes one of them."""
    if (folder / "raw").is_dir():
        return InputError(
            f"{folder}: raw records and no points.csv; 'tribofmu twin {folder} -o DATA' makes a data set of them"
        )
    return InputError(f"{folder}: no points.csv in this folder; a data set holds points.csv and tests.csv")


def says_synthetic(tests: pd.DataFrame) -> bool:
    """Return whether a test table says of any of its tests that it is synthetic."""
    if "synthetic" not in tests.columns:
        return False
    return bool(
        tests["synthetic"].astype(str).str.strip().str.lower().isin(["true", "1", "1.0", "yes"]).any()
    )


def read_info(folder: Path) -> dict[str, Any]:
    """Return the content of `dataset.json` in a folder, empty where there is none.

    Raises
    ------
    InputError
        Not JSON, or no JSON object.
    """
    file = folder / "dataset.json"
    return read_json(file) if file.is_file() else {}
