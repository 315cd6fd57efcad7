"""What a sliding compression test is driven with: force, speed and tool temperature over time, and its specimen."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from friction_models.common import InputError, unknown_name
from friction_models.loads import DataSet, FloatArray, missing_column
from friction_models.loads.dataset import says_synthetic
from friction_models.loads.table import read_table
from sct_twin.ingest.raw_campaign import check_test_id
from sct_twin.twin.process import F_MAX_LIMITS

#: A row of a test table.
TestRow = Mapping[str, float | str | None]
#: Columns of a test table that are parameters of the twin.
TWIN_PARAMETERS = ("specimen_diameter", "specimen_height", "bore", "tip", "tip_height", "t_wait")
#: Physical limits of what the twin is driven with.
_LIMITS = {"F_n": (0.0, 1e8, "N"), "v_slide": (0.0, 1e5, "mm/s"), "T_tool": (-273.15, 2000.0, "degC")}
#: Intervals in which a planned start of the plate is divided.
_RAMP = 60


@dataclass(frozen=True, eq=False)
class SctSchedule:
    """One test from the moment at which the plate starts to move, in n intervals.

    Raises InputError: arrays of other lengths, values out of their physical limits, nothing that slides.

    Examples
    --------
    >>> plan = {"test_id": "t1", "F_set": 50e3, "v_set": 20.0, "sd_set": 10.0, "T_tool": 20.0}
    >>> schedule = SctSchedule.from_plan(plan)
    >>> schedule.duration, schedule.distance
    (0.5, 10.0)
    """

    test_id: str
    edges: FloatArray  # times [s] from 0 on, shape (n + 1,)
    F_n: FloatArray  # mean normal force [N] of each interval, shape (n,)
    v_slide: FloatArray  # mean speed [mm/s], shape (n,)
    T_tool: FloatArray  # temperature of punch and fresh plate [degC], shape (n,)
    metadata: TestRow = field(default_factory=dict)  # the test's row of the test table
    measured: pd.DataFrame | None = None  # points of the test where it was run: columns of the contract
    synthetic: bool = False

    def __post_init__(self) -> None:
        check_test_id(self.test_id, "test table")  # it names the run folder
        where = f"test {self.test_id}"
        for name, (low, high, unit) in _LIMITS.items():
            values = getattr(self, name)
            if values.shape != (len(self.edges) - 1,):
                raise InputError(
                    f"{where}: {name!r} has shape {values.shape}, allowed: ({len(self.edges) - 1},)"
                )
            good = (values >= low) & (values <= high)
            if not good.all():
                row = int(np.argmin(good))
                raise InputError(
                    f"{where}: {name} = {float(values[row])!r} {unit} in row {row}, allowed: {low:g} to {high:g} {unit}"
                )
        low, high = F_MAX_LIMITS
        if not low <= float(self.F_n.max()) <= high:
            raise InputError(
                f"{where}: F_n is {float(self.F_n.max()):g} N at its highest, allowed: {low:g} to {high:g} N (is it in N?)"
            )
        if not (np.diff(self.edges) > 0.0).all():
            raise InputError(f"{where}: the times must increase")
        if self.distance < 0.5:
            raise InputError(f"{where}: slides {self.distance:g} mm, allowed: at least 0.5 mm")

    @property
    def duration(self) -> float:
        """Time of sliding [s]."""
        return float(self.edges[-1])

    @property
    def distance(self) -> float:
        """Sliding distance [mm]."""
        return float(self.v_slide @ np.diff(self.edges))

    def parameters(self) -> dict[str, float]:
        """Return what the test's metadata say about specimen, punch and waiting time, as parameters of the twin."""
        return {
            name: value for name in TWIN_PARAMETERS if (value := _number(self.metadata, name)) is not None
        }

    @property
    def T_specimen(self) -> float | None:
        """Temperature of the specimen before upsetting [degC]; None: that of the tool."""
        value = _number(self.metadata, "T_specimen")
        return None if value is None or value == float(self.T_tool[0]) else value

    @classmethod
    def from_points(cls, points: pd.DataFrame, row: TestRow, synthetic: bool = False) -> SctSchedule:
        """Take a test as it was driven: force and distance over time from its points, temperature from its row.

        `points` hold `t, sd` and `F_n` [N] (or `sigma_n`, where the row holds `contact_area` [mm2]) of one test; the
        row of the test table needs `T_tool` [degC].
        """
        test_id = str(row["test_id"])
        where = f"test {test_id}"
        for name in ("t", "sd"):
            if name not in points.columns:
                raise missing_column(name, points.columns, where)
        area = _number(row, "contact_area")
        if "F_n" in points.columns:
            force = points["F_n"].to_numpy(dtype=np.float64)
        elif area is not None and "sigma_n" in points.columns:
            force = area * points["sigma_n"].to_numpy(dtype=np.float64)
        else:
            raise missing_column("F_n", points.columns, where)
        T_tool = _needed(row, "T_tool", where)
        t, sd = (
            np.concatenate([np.zeros(1), points[name].to_numpy(dtype=np.float64)]) for name in ("t", "sd")
        )
        keep = np.concatenate([[True], np.diff(t) > 0.0])
        t, sd, force = t[keep], sd[keep], np.concatenate([force[:1], force])[keep]
        # The distances are the measured ones: a speed that is integrated would drift away from them.
        speed = np.maximum(np.diff(sd) / np.diff(t), 0.0)
        mean, measured = 0.5 * (force[1:] + force[:-1]), points.reset_index(drop=True)
        return cls(test_id, t, mean, speed, np.full(len(speed), T_tool), dict(row), measured, synthetic)

    @classmethod
    def from_plan(cls, row: TestRow, synthetic: bool = False) -> SctSchedule:
        """Take a test that was only planned.

        The row holds `test_id`, `F_set` [N], `v_set` [mm/s], `sd_set` [mm], `T_tool` [degC]; `ramp` [s], the time in
        which the plate reaches its speed along half a cosine (0 where missing); specimen, punch and `t_wait`.
        """
        test_id = str(row["test_id"])
        where = f"test {test_id}"
        force, speed, distance, T_tool = (
            _needed(row, name, where) for name in ("F_set", "v_set", "sd_set", "T_tool")
        )
        ramp = _number(row, "ramp") or 0.0
        if speed <= 0.0 or ramp < 0.0 or distance <= 0.5 * speed * ramp:
            raise InputError(
                f"{where}: v_set = {speed:g} mm/s, sd_set = {distance:g} mm, ramp = {ramp:g} s; allowed: a speed above 0 "
                "that is reached before the end of the sliding distance"
            )
        edges = np.linspace(0.0, ramp, _RAMP + 1) if ramp else np.zeros(1)
        gone = 0.5 * speed * (edges - (np.sin(np.pi * edges / ramp) * ramp / np.pi if ramp else 0.0))
        last = ramp + (distance - 0.5 * speed * ramp) / speed
        edges, gone = np.append(edges, last), np.append(gone, distance)
        n = len(edges) - 1
        v = np.diff(gone) / np.diff(edges)
        return cls(test_id, edges, np.full(n, force), v, np.full(n, T_tool), dict(row), synthetic=synthetic)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], row: TestRow) -> SctSchedule:
        """Read a table (CSV, Parquet) with `t` [s], `F_n` [N], `v_slide` [mm/s] and, where it varies, `T_tool` [degC]."""
        frame = read_table(path)
        for name in ("t", "F_n", "v_slide"):
            if name not in frame.columns:
                raise missing_column(name, frame.columns, str(path))
        if "T_tool" not in frame.columns:
            given = _number(row, "T_tool")
            if given is None:
                raise InputError(
                    f"{path}: no column 'T_tool'; allowed: such a column, or one value for the test (--set T_tool=20)"
                )
            frame["T_tool"] = given
        columns = {}
        for name in ("t", "F_n", "v_slide", "T_tool"):
            values = pd.to_numeric(frame[name], errors="coerce").to_numpy(dtype=np.float64)
            if not np.isfinite(values).all():
                line = int(np.argmin(np.isfinite(values)))
                raise InputError(
                    f"{path}: column {name!r}, row {line}: value {frame[name].iloc[line]!r} is not a finite number"
                )
            columns[name] = values
        if len(frame) < 2:
            raise InputError(f"{path}: {len(frame)} rows, allowed: at least 2")
        means = {name: 0.5 * (values[1:] + values[:-1]) for name, values in columns.items()}
        edges = columns["t"] - columns["t"][0]
        with _named(path):
            return cls(str(row["test_id"]), edges, means["F_n"], means["v_slide"], means["T_tool"], dict(row))


def held_out_schedules(data: DataSet, only: list[str] | None = None) -> list[SctSchedule]:
    """Return the held-out tests of a data set (all of them where no role is recorded), or the tests named.

    The data set needs a test table, as `SctSchedule.from_points` says.
    """
    if data.tests is None:
        raise InputError(
            "the data set has no test table; allowed: one with a row a test and at least test_id and T_tool"
        )
    known = [str(name) for name in data.tests["test_id"]]
    for name in only or []:
        if name not in known:
            raise unknown_name("test", name, known, "test table")
    chosen = data
    if not only:
        held_out = data.select("test")
        chosen = held_out if len(held_out.points) else data
    assert chosen.tests is not None
    rows = {str(row["test_id"]): row for row in chosen.tests.to_dict("records")}
    return [
        SctSchedule.from_points(points, {str(k): v for k, v in rows[str(name)].items()}, data.synthetic)
        for name, points in chosen.points.groupby("test_id", sort=False)
        if str(name) in rows and (not only or str(name) in only)
    ]


def planned_schedules(path: str | os.PathLike[str]) -> list[SctSchedule]:
    """Return the tests of a plan: a table with a row a test, see `SctSchedule.from_plan`.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     plan = Path(place) / "plan.csv"
    ...     _ = plan.write_text(chr(10).join(["test_id,F_set,v_set,sd_set,T_tool", "t1,50000,20,10,20"]))
    ...     [(s.test_id, s.duration, s.distance) for s in planned_schedules(plan)]
    [('t1', 0.5, 10.0)]
    """
    frame = read_table(path)
    if "test_id" not in frame.columns:
        raise missing_column("test_id", frame.columns, str(path))
    synthetic = says_synthetic(frame)
    rows = [{str(k): v for k, v in row.items()} for row in frame.to_dict("records")]
    with _named(path):
        return [SctSchedule.from_plan(row, synthetic) for row in rows]


@contextmanager
def _named(path: str | os.PathLike[str]) -> Iterator[None]:
    """Let an error name the file."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _number(row: TestRow, name: str) -> float | None:
    """Return a finite number of the metadata; None where it is not recorded."""
    value = row.get(name)
    if value is None or value == "" or (isinstance(value, float) and math.isnan(value)):
        return None
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"test {row.get('test_id')}: {name} = {value!r}, allowed: a finite number")
    return number


def _needed(row: TestRow, name: str, where: str) -> float:
    value = _number(row, name)
    if value is None:
        raise missing_column(name, list(row), where)
    return value
