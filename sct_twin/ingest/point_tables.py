"""`points`: from the point tables of any laboratory to a data set."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from friction_models.common import InputError
from friction_models.common.errors import shown
from friction_models.common.processes.pool import Progress
from friction_models.common.units import conversion
from friction_models.common.wording import counted
from friction_models.loads import LOAD_NAMES, DataSet, missing_column
from friction_models.loads.contract import POINT_COLUMNS, POINT_UNITS
from friction_models.loads.dataset import read_tests, says_synthetic
from friction_models.loads.earlier_tables import with_columns_of
from friction_models.loads.points import check_points

from ..readers import RawTable, read_file
from ..readers.header import numbered
from ..records.cells import Cell
from .measurement_files import Source, is_test_table, measurement_files, passed_over, tests_beside
from .point_map import PointColumn, PointMap, PointMapSource


@dataclass
class PointTables:
    """What `read_point_tables` found."""

    dataset: DataSet
    #: What was left out, moved or accepted.
    notes: list[str] = field(default_factory=list)

    def headline(self) -> str:
        """Return how much was read."""
        points = self.dataset.points
        said = f"{counted(points['test_id'].nunique(), 'test')}, {counted(len(points), 'point')}"
        absent = [name for name in LOAD_NAMES if name not in points]
        return f"{said}; not measured: {', '.join(absent)}" if absent else said


def read_point_tables(
    source: Source,
    point_map: PointMapSource = None,
    progress: Progress | None = None,
    synthetic: bool = False,
    read: Callable[[Path], RawTable] = read_file,
) -> PointTables:
    """Read tables of points and return them as a data set in the units of the contract.

    Raises InputError: a file that cannot be read, lacks a mapped column, has text between its numbers or a unit that
    does not fit; a test in two files; what `check_points` refuses.

    - `source`: a folder or single files, of any format that `ingest` reads. A file holds one test, or several with a
      column of their names. A table `tests.csv` beside them adds what is known of each test.
    - `point_map`: which columns are what; None for columns named as in the contract.
    - `synthetic`: whether the values were computed and not measured.
    - `read`: reads one file; for those who hold tables that were read before.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "oil_300K_t1.csv"
    ...     _ = file.write_text("speed;COF\\n0,5;0,08\\n0,6;0,07\\n")
    ...     columns = {"speed": {"quantity": "v_rel", "unit": "m/s"}, "COF": "mu"}
    ...     found = read_point_tables(file, {"columns": columns, "file_name": "{lubricant}_{T_K}K_{test_id}"})
    >>> found.dataset.points["v_rel"].tolist(), found.dataset.tests.values.tolist()
    ([500.0, 600.0], [['t1', 'oil', 300.0]])
    """
    mapping = PointMap.load(point_map)
    files = point_files(source)
    frames: list[pd.DataFrame] = []
    tests: dict[str, dict[str, Cell]] = {}
    first: dict[str, Path] = {}
    notes = [entry.reason for entry in passed_over(source)]
    for number, file in enumerate(files):
        frame, about, said = _one(file, mapping, read)
        for test in about:
            if test in first:
                raise InputError(
                    f"{file}: test {test!r} stands in {first[test].name}, too; allowed: each test in one file, or a "
                    "file_name that tells them apart"
                )
            first[test] = file
        tests |= about
        frames.append(frame)
        notes += [f"{file.name}: {text}" for text in said]
        if progress is not None:
            progress(number + 1, len(files), file.name)
    lacking = {c for frame in frames for c in frames[0].columns.symmetric_difference(frame.columns)}
    if lacking:
        raise InputError(
            f"{mapping.source}: {', '.join(sorted(lacking))} only in some of the files; allowed: the same columns in all"
        )
    points = check_points(pd.concat(frames, ignore_index=True), "points")
    table = pd.DataFrame([{"test_id": test, **row} for test, row in tests.items()])
    table = table[table["test_id"].isin(points.frame["test_id"].unique())].reset_index(drop=True)
    table, said = _with_tests_beside(table, source, files)
    notes += said
    info = {"synthetic": synthetic or says_synthetic(table), "files": [file.name for file in files]}
    return PointTables(DataSet(points.frame, table, info, points.notes), [*notes, *points.notes])


def _with_tests_beside(
    table: pd.DataFrame, source: Source, files: list[Path]
) -> tuple[pd.DataFrame, list[str]]:
    """Return the test table with the columns that only the one beside the files has, and what there is to say.

    Raises InputError: there are two tables beside the files, or the one is no test table.
    """
    homes = {file.parent for file in files}
    folders = [
        Path(source) if isinstance(source, str | os.PathLike) and Path(source).is_dir() else None,
        measurement_files(files)[1],
        homes.pop() if len(homes) == 1 else None,
    ]
    beside = next((found for home in folders if home and (found := tests_beside(home))), None)
    if beside is None or beside in files:
        return table, []
    known = read_tests(beside)
    if not table["test_id"].isin(known["test_id"]).any():
        return table, [f"{beside.name} names none of the tests and is not used"]
    table, more = with_columns_of(table, known)
    said = [f"{', '.join(more)}: taken from {beside.name}"] if more else []
    there, named = set(table["test_id"]), set(known["test_id"])
    for names, what in ((there - named, "not in"), (named - there, "without points in")):
        if names:
            said.append(
                f"{counted(len(names), 'test')} {what} {beside.name}: {shown(', '.join(sorted(names)), 100)}"
            )
    return table, said


def point_files(source: Source) -> list[Path]:
    """Return the files; of a single folder also tables that are called as those of a data set."""
    if isinstance(source, str | os.PathLike) and (Path(source) / "points.csv").is_file():
        return [Path(source) / "points.csv"]
    files = measurement_files(source)[0]
    return [file for file in files if not is_test_table(file)] or files


def _one(
    file: Path, mapping: PointMap, read: Callable[[Path], RawTable]
) -> tuple[pd.DataFrame, dict[str, dict[str, Cell]], list[str]]:
    """Return the points of a file, what is known about its tests, and what there is to say."""
    table = read(file)
    present = [str(name) for name in table.frame.columns]
    used = mapping.used(present)
    if mapping.columns is None:
        _check_once(present, file)
    for name in mapping.columns or {}:
        if name not in used:
            raise missing_column(name, present, str(file))
    if all(column.quantity != "mu" for column in used.values()):
        error = missing_column("mu", present, str(file))
        raise InputError(f"{error}; a point map (--map) says which column it is, --dry-run drafts one")
    kept, notes = _kept(table, mapping)
    notes += table.notes
    from_name = mapping.file_name.of(file.stem, f"{file}: ") if mapping.file_name else {}
    about = {**mapping.metadata, **{k: v for k, v in from_name.items() if k != "test_id"}}
    by = {column.quantity: name for name, column in used.items() if column.quantity}
    if "test_id" in by:
        names = _texts(table.frame[by["test_id"]])
    else:
        names = pd.Series(str(from_name.get("test_id", file.stem)), index=table.frame.index)
    columns: dict[str, object] = {"test_id": names.to_numpy()}
    columns |= {q: _numbers(table, by[q], used[by[q]]) for q in POINT_COLUMNS[1:] if q in by}
    frame = pd.DataFrame(columns)[kept].reset_index(drop=True)
    if frame.empty:
        raise InputError(f"{file}: no row lies within the limits of 'only'; allowed: one at least")
    tests: dict[str, dict[str, Cell]] = {str(test): dict(about) for test in frame["test_id"].unique()}
    gone = names.nunique() - len(tests)
    if gone:
        notes.append(f"{counted(gone, 'test')} without a row within the limits left out")
    for name, column in used.items():
        if column.test_table is not None:
            values = table.frame[name]
            values = values if values.dtype.kind in "fiu" else _texts(values)
            values = values[kept].reset_index(drop=True)
            _add_column(tests, frame["test_id"], values, name, column.test_table, file)
    return frame, tests, notes


def _check_once(present: list[str], file: Path) -> None:
    """Raise InputError: a quantity stands in several columns; the reader numbers them."""
    for name in POINT_COLUMNS:
        if again := numbered(name, present):
            raise InputError(
                f"{file}: column {name!r} stands {len(again)} times; allowed: once, or a point map (--map) that says which of "
                f"{', '.join(map(repr, again))} it is"
            )


def _kept(table: RawTable, mapping: PointMap) -> tuple[np.ndarray, list[str]]:
    """Return which rows lie within the limits of the map."""
    kept = np.ones(len(table.frame), dtype=bool)
    for name, (low, high) in mapping.only.items():
        if name not in table.frame.columns:
            raise missing_column(name, table.frame.columns, table.source)
        values, _ = table.numbers(name)
        kept &= values >= (-np.inf if low is None else low)
        kept &= values <= (np.inf if high is None else high)
    left_out = int((~kept).sum())
    return kept, [
        f"left out, outside of the limits of {', '.join(mapping.only)}: {left_out} of {counted(len(kept), 'row')}"
    ] if left_out else []


def _numbers(table: RawTable, name: str, column: PointColumn) -> np.ndarray:
    values, bad = table.numbers(name)
    if bad is not None:
        raise InputError(
            f"{table.source}: column {name!r}, {table.place(bad)}: value {table.frame[name].iloc[bad]!r} is not a number; "
            "allowed: numbers and empty cells"
        )
    unit = column.unit or table.units.get(name, "")
    if unit and column.quantity is not None:
        factor, offset = conversion(POINT_UNITS[column.quantity], unit, name, table.source)
        values = values * factor + offset
    return column.sign * values


def _texts(values: pd.Series) -> pd.Series:
    """Return names as texts: test 7 of a column of numbers is '7' and not '7.0'."""
    if values.dtype.kind == "f" and not values.isna().any() and (values % 1 == 0).all():
        values = values.astype(np.int64)
    if pd.api.types.infer_dtype(values, skipna=True) == "string":
        # Names repeat from row to row.
        return values.map({v: str(v).strip() for v in values.dropna().unique()})
    return values.map(lambda v: str(v).strip(), na_action="ignore")


def _add_column(
    tests: dict[str, dict[str, Cell]],
    names: pd.Series,
    values: pd.Series,
    column: str,
    target: str,
    file: Path,
) -> None:
    """Put what a column says of each test into the test table. Raises InputError: it says two things of one test."""
    for test, cells in values.groupby(names.to_numpy(), sort=False):
        different = cells.dropna().unique()
        if len(different) > 1:
            raise InputError(
                f"{file}: column {column!r} has {len(different)} values in test {test!r} ({shown(different[0], 40)}, "
                f"{shown(different[1], 40)}, ...); allowed: one, since it becomes column {target!r} of the test table"
            )
        if len(different):
            cell = different[0]
            tests[str(test)][target] = cell.item() if hasattr(cell, "item") else cell
