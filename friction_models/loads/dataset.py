"""A data set on disk: `points.csv`, `tests.csv`, `dataset.json` in one folder, or a single file of points."""

from __future__ import annotations

import csv
import os
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ..common.errors import InputError, check_readable, given_path
from ..common.files import atomic_folder, read_json, write_json
from ..common.folders import DATASET
from .columns import missing_column
from .contract import POINT_UNITS, UNCERTAINTY_COLUMNS
from .earlier_tables import carry
from .order import order_of_tests
from .points import check_points
from .table import Table, read_file, read_table
from .test_numbers import check_tool_temperature
from .tribo_loads import TriboLoads

#: What a test is for that has no role.
TRAINING = "train"


@dataclass
class DataSet:
    """Points and tests that belong together.

    Attributes
    ----------
    points : pandas.DataFrame
        One row a point: `POINT_COLUMNS`, more columns allowed.
    tests : pandas.DataFrame or None
        One row a test: `test_id` and any metadata; the optional column `role` holds ``train`` or
        ``test`` and marks the tests that are held out; one without a role is for training.
    info : dict
        Content of `dataset.json`: ``synthetic`` (bool), provenance, versions.
    notes : tuple of str
        What was left out, moved or accepted when the points were read, one sentence each.
    given : Table or None
        The table of points as it stands in its file, where it was asked for.
    rows : ndarray of int or None
        Row of each point in that table.
    source : str
        The file of points, for messages.

    Examples
    --------
    >>> from friction_models import DataSet
    >>> points = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [500.0, 900.0], "mu": [0.08, 0.07]})
    >>> tests = pd.DataFrame({"test_id": ["a", "b"], "role": ["train", "test"]})
    >>> data = DataSet(points, tests, {"synthetic": True})
    >>> training, held_out = data.frames()
    >>> held_out["mu"].tolist()
    [0.07]
    >>> data.synthetic
    True
    """

    points: pd.DataFrame
    tests: pd.DataFrame | None = None
    info: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    given: Table | None = field(default=None, repr=False)
    rows: npt.NDArray[np.intp] | None = field(default=None, repr=False)
    source: str = "data"

    def __post_init__(self) -> None:
        # The points carry their provenance, so that a model fitted on them says whether they are synthetic.
        self.points.attrs.update(self.info)

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        tests: str | os.PathLike[str] | None = None,
        need_mu: bool = True,
        keep_given: bool = False,
    ) -> DataSet:
        """Read a data-set folder, or a single CSV/Parquet file of points with an optional test table.

        Parameters
        ----------
        need_mu : bool
            Whether measured friction must be there.
        keep_given : bool
            Whether to keep the table of points as it stands in its file.

        Raises
        ------
        InputError
            Anything that `read_file` and `check_points` refuse; a test that the table names twice.

        Examples
        --------
        >>> import tempfile
        >>> points = pd.DataFrame({"test_id": ["a", "a"], "sd": [0.0, 1.0], "mu": [0.08, 0.07]})
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = Path(folder) / "points.csv"
        ...     points.to_csv(file, index=False)
        ...     data = DataSet.load(file)
        >>> data.points["mu"].tolist()
        [0.08, 0.07]
        """
        source = given_path(path, "a data set")
        file, table = source, Path(tests) if tests is not None else None
        if source.is_dir():
            file = points_file(source)
            if table is None and (source / "tests.csv").is_file():
                table = source / "tests.csv"
        else:
            check_readable(source, allowed="a CSV or Parquet file, or a folder with points.csv")
        given = read_file(file)
        frame = given.converted()
        points = check_points(frame, str(file), need_mu)
        about = source / "dataset.json"
        info = read_json(about) if about.is_file() else {}
        listed = None if table is None else read_tests(table)
        if listed is not None:
            _check_ids(listed["test_id"], points.frame["test_id"], f"{table}", file)
        if listed is not None and says_synthetic(listed):
            info["synthetic"] = True
        left_out = len(frame) - len(points.rows)
        if left_out:
            info["points_left_out"] = left_out
        kept = given if keep_given else None
        return cls(points.frame, listed, info, points.notes, kept, points.rows, str(file))

    def require_order(self) -> None:
        """Refuse tests of which nothing says in what order their points were measured; see `order_of_tests`.

        Raises
        ------
        InputError
            There is no time, and the distance falls within a test.
        """
        frame = self.points
        order_of_tests(frame["test_id"], frame.get("t"), frame.get("sd"), self.source, True, self.rows)

    def as_given(self, **columns: npt.NDArray[np.float64]) -> pd.DataFrame:
        """Return the table of points as it stands in its file, with further columns of values at the points.

        Rows that were left out get NaN. The data set must have been loaded with `keep_given`.
        """
        assert self.given is not None and self.rows is not None
        return self.given.with_columns(self.rows, **columns)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write `points.csv` (with a units row), `tests.csv` and `dataset.json`, atomically.

        Of a data set that stands there the test tables are kept in the folder `earlier`.
        """
        with atomic_folder(folder, DATASET) as temporary:
            self.write_into(temporary)
            carry(Path(folder), temporary)
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
        """Return the tests of one role (``train`` or ``test``); all of them where no role is recorded.

        A test that the table does not list is for training.

        Examples
        --------
        >>> points = pd.DataFrame({"test_id": ["a", "b"], "mu": [0.08, 0.07]})
        >>> tests = pd.DataFrame({"test_id": ["a", "b"], "role": ["train", "test"]})
        >>> DataSet(points, tests).select("train").points["mu"].tolist()
        [0.08]
        """
        if role is None or self.tests is None or "role" not in self.tests.columns:
            return self
        roles = roles_of(self.tests["role"])
        of_points = self.points["test_id"].map(dict(zip(self.tests["test_id"], roles))).fillna(TRAINING)
        points = self.points[of_points == role].reset_index(drop=True)
        return DataSet(points, self.tests[roles == role].reset_index(drop=True), self.info)

    def without_tests(self, names: Collection[str]) -> DataSet:
        """Return the other tests; all of them where none is named.

        Examples
        --------
        >>> points = pd.DataFrame({"test_id": ["a", "b"], "mu": [0.08, 0.07]})
        >>> DataSet(points).without_tests(["b"]).points["mu"].tolist()
        [0.08]
        """
        if not names:
            return self
        points, tests = self.points, self.tests
        points = points[~points["test_id"].astype(str).isin(names)]
        if tests is not None:
            tests = tests[~tests["test_id"].astype(str).isin(names)]
        return replace(self, points=points, tests=tests)

    def without_load_uncertainty(self) -> DataSet:
        """Return the same data without the standard uncertainties of the loads, so that nothing honours them.

        Examples
        --------
        >>> points = pd.DataFrame({"test_id": ["a"], "T": [80.0], "u_T": [5.0], "mu": [0.08]})
        >>> DataSet(points).without_load_uncertainty().points.columns.tolist()
        ['test_id', 'T', 'mu']
        """
        stated = [c for c in UNCERTAINTY_COLUMNS.values() if c in self.points.columns]
        return replace(self, points=self.points.drop(columns=stated)) if stated else self

    def frames(self) -> tuple[pd.DataFrame, pd.DataFrame]:
        """Return the points of the training and of the held-out tests."""
        return self.select("train").points, self.select("test").points

    def loads(self) -> TriboLoads:
        """Return the loads of all points, with time, test and metadata."""
        return TriboLoads.from_frame(self.points, self.tests)


def roles_of(column: pd.Series[Any]) -> pd.Series[str]:
    """Return what tests are for by the column ``role`` of their table; a blank one is for training.

    Examples
    --------
    >>> roles_of(pd.Series(["test", None, " "])).tolist()
    ['test', 'train', 'train']
    """
    role = column.astype(object).where(column.notna(), "").astype(str).str.strip()
    return role.mask(role == "", TRAINING)


def _check_ids(listed: pd.Series[str], measured: pd.Series[str], table: str, file: Path) -> None:
    """Refuse a test table that is of other tests than all of those that were measured."""
    if len(listed) and len(measured) and not listed.isin(measured).any():
        raise InputError(
            f"{table}: test_id {listed.iloc[0]!r} and all others are none of the tests in {file}; "
            f"allowed: tests that occur there, as {measured.iloc[0]!r}"
        )


def points_file(folder: Path) -> Path:
    """Return the table of points in a data-set folder.

    Raises InputError for a folder that is none; of raw records it says what makes a data set of them.
    """
    for name in ("points.csv", "points.parquet"):
        if (folder / name).is_file():
            return folder / name
    if (folder / "raw").is_dir():
        raise InputError(
            f"{folder}: raw records and no points.csv; 'tribofmu twin {folder} -o DATA' makes a data set of them"
        )
    raise InputError(f"{folder}: no points.csv in this folder; a data set holds points.csv and tests.csv")


def read_tests(path: Path) -> pd.DataFrame:
    """Read a table of tests: one row a test, `test_id` and any metadata.

    Raises InputError: no `test_id`, a row without one, or one in two rows; a tool temperature in words.
    """
    frame = read_table(path)
    if "test_id" not in frame.columns:
        raise missing_column("test_id", frame.columns, str(path))
    blank = frame["test_id"].isna().to_numpy()
    if blank.any():
        raise InputError(f"{path}: row {int(blank.argmax())} has no test_id; allowed: a name in every row")
    frame["test_id"] = frame["test_id"].astype(str)
    if frame["test_id"].duplicated().any():
        twice = frame["test_id"][frame["test_id"].duplicated()].iloc[0]
        raise InputError(f"{path}: test_id {twice!r} stands in two rows; allowed: one row a test")
    check_tool_temperature(frame, str(path))
    return frame


def says_synthetic(tests: pd.DataFrame) -> bool:
    """Return whether a test table says of any of its tests that it is synthetic.

    Examples
    --------
    >>> says_synthetic(pd.DataFrame({"test_id": ["a", "b"], "synthetic": [False, True]}))
    True
    """
    if "synthetic" not in tests.columns:
        return False
    return bool(
        tests["synthetic"].astype(str).str.strip().str.lower().isin(["true", "1", "1.0", "yes"]).any()
    )
