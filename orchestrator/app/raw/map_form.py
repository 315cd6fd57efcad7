"""What a form says about the columns of measurement files, as the map that `ingest` or `points` takes; no page is needed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.common.units import conversion, units_like
from friction_models.loads import FloatArray
from friction_models.loads.contract import POINT_COLUMNS, POINT_UNITS, QUANTITIES
from sct_twin.ingest.channel_guess import guess_channels, name_and_unit
from sct_twin.ingest.point_guess import guess_point_columns
from sct_twin.readers import RawTable
from sct_twin.records.channels import CHANNELS

#: Columns of a file that a form shows.
MOST_COLUMNS = 60
#: Stands for a column of the test table in the choice of a column of points.
TEST_TABLE = "test_table"


@dataclass
class ColumnForm:
    """What a form says about one column, which the file calls `name`."""

    name: str
    file_unit: str = ""
    number: bool = True
    #: The channel or quantity; empty where it is not used; `TEST_TABLE`.
    is_: str = ""
    #: Where the file's own does not hold.
    unit: str = ""
    sign: int = 1
    #: Zero reading, in the unit of the column.
    offset: float | None = None
    #: As in a channel map: ``5 kN/V``; uncertainty of a force cell [N].
    scale: str = ""
    std: float | None = None
    #: Limits of the rows that are kept (points).
    low: float | None = None
    high: float | None = None
    column: str = ""
    #: In place of a scale, in a map that was written by hand.
    sensitivity: str = ""


@dataclass
class MapForm:
    """What a form says about a set of files: `records` of a tribometer over time, or tables of points."""

    records: bool
    columns: list[ColumnForm]
    #: Moving mass [kg].
    mass: float | None = None
    #: Template of the files' names.
    name: str = ""
    #: What all tests share.
    metadata: dict[str, object] = field(default_factory=dict)
    #: ``upsetting`` and ``sliding``: from and to [s]; or ``detect``.
    phases: object = "detect"
    #: What a saved map says about columns that the first file does not have.
    absent: dict[str, object] = field(default_factory=dict)
    #: ``despike`` and ``low_pass`` of a map that was written by hand.
    filters: dict[str, object] = field(default_factory=dict)

    @classmethod
    def of(cls, table: RawTable, records: bool, saved: Mapping[str, object]) -> MapForm:
        """Return the form of a saved map, or of what is recognised where none was saved.

        Examples
        --------
        >>> import pandas as pd
        >>> table = RawTable(pd.DataFrame({"t": [0.0], "COF": [0.1]}), {"t": "s"}, "file.csv")
        >>> [c.is_ for c in MapForm.of(table, False, {}).columns]
        ['t', 'mu']
        """
        names = [str(c) for c in table.frame.columns][:MOST_COLUMNS]
        columns = [
            ColumnForm(n, table.units.get(n, ""), table.frame[n].dtype.kind in "fiu", column=n) for n in names
        ]
        form = cls(records, columns)
        entries = saved.get("channels" if records else "columns")
        was_saved = isinstance(entries, Mapping)
        drafted = dict(entries if isinstance(entries, Mapping) else drafted_columns(table, records))
        for column in columns:
            if column.name in drafted:
                _fill(column, drafted.pop(column.name))
        if not was_saved:
            for column in columns:
                if records and column.is_ == "F_n" and _pulls(table.numbers(column.name)[0]):
                    column.sign = -1
            return form
        form.absent = drafted
        metadata = saved.get("metadata")
        form.mass = number(saved.get("moving_mass"))
        form.metadata = dict(metadata) if isinstance(metadata, Mapping) else {}
        form.name = str(saved.get("test_id" if records else "file_name") or "")
        form.phases = saved.get("phases") or "detect"
        only = saved.get("only")
        for column in columns:
            limits = only.get(column.name) if isinstance(only, Mapping) else None
            if isinstance(limits, Mapping):
                column.low, column.high = number(limits.get("min")), number(limits.get("max"))
        form.filters = {k: saved[k] for k in ("despike", "low_pass") if records and k in saved}
        return form

    def content(self) -> dict[str, object]:
        """Return the map as the command line takes it."""
        entries = {c.name: _entry(c, self.records) for c in self.columns if c.is_}
        found: dict[str, object] = {"channels" if self.records else "columns": {**entries, **self.absent}}
        if self.records:
            found |= {"moving_mass": self.mass} if self.mass is not None else {}
        else:
            limits = {
                c.name: {k: v for k, v in (("min", c.low), ("max", c.high)) if v is not None}
                for c in self.columns
                if c.low is not None or c.high is not None
            }
            found |= {"only": limits} if limits else {}
        found |= {"test_id" if self.records else "file_name": self.name} if self.name else {}
        found |= {"metadata": self.metadata} if self.metadata else {}
        found |= {"phases": self.phases} if self.records else {}
        return found | self.filters


def choices(records: bool) -> dict[str, str]:
    """Return what a column may be, for a field to choose from."""
    if records:
        return {"": "not used", **{n: f"{n}: {c.meaning} [{c.unit}]" for n, c in CHANNELS.items()}}
    said = {n: f"{n}: {QUANTITIES[n].meaning} [{QUANTITIES[n].unit}]" for n in POINT_COLUMNS[1:]}
    return {
        "": "not used",
        "test_id": "test_id: name of the test",
        **said,
        TEST_TABLE: "column of the test table",
    }


def units_of(quantity: str, records: bool) -> list[str]:
    """Return the usual units of a channel or quantity."""
    known = CHANNELS[quantity].unit if records and quantity in CHANNELS else POINT_UNITS.get(quantity, "")
    return units_like(known) if known and known != "1" else ["1", "%"] if known else []


def looks_like_records(table: RawTable) -> bool:
    """Whether a table has forces over time and no friction."""
    columns = guess_point_columns(table)
    if any(entry.get("quantity") == "mu" for entry in columns.values()):
        return False
    found = {g.quantity: g.candidates for g in guess_channels(table)}
    return bool(found.get("F_n") or found.get("F_r"))


def drafted_columns(table: RawTable, records: bool) -> dict[str, dict[str, str]]:
    """Return what is recognised, as entries of a map."""
    if not records:
        return guess_point_columns(table)
    entries: dict[str, dict[str, str]] = {}
    for guess in guess_channels(table):
        if guess.column is not None:
            unit = "" if table.units.get(guess.column) else name_and_unit(guess.column)[1]
            entries[guess.column] = {"quantity": guess.quantity, **({"unit": unit} if unit else {})}
    return entries


@dataclass(frozen=True)
class Beyond:
    """Rows of a column with values that cannot be; the limits, in the unit of the file, that leave them out."""

    column: str
    rows: int
    low: float | None
    high: float | None

    @property
    def words(self) -> str:
        """What the rows have in common."""
        below = [] if self.low is None else [f"below {self.low:g}"]
        return " or ".join([*below, *([] if self.high is None else [f"above {self.high:g}"])])


def beyond_limits(form: MapForm, table: RawTable, problem: str) -> Beyond | None:
    """Return which rows of the first file would have to be left out for what was refused; None for another problem.

    Examples
    --------
    >>> import pandas as pd
    >>> table = RawTable(pd.DataFrame({"COF": [0.1, -0.9, 0.2]}), {}, "file.csv")
    >>> said = "points: column 'mu', row 1: value -0.9 is outside the allowed range -0.4 to 10"
    >>> found = beyond_limits(MapForm.of(table, False, {}), table, said)
    >>> found.column, found.rows, found.words
    ('COF', 1, 'below -0.4')
    """
    told = re.search(r"column '(\w+)', .* outside the allowed range (\S+) to (\S+)", problem)
    column = next((c for c in form.columns if told and c.is_ == told[1] and c.sign == 1), None)
    if told is None or column is None:
        return None
    try:
        unit = column.unit or column.file_unit
        factor, offset = conversion(POINT_UNITS[column.is_], unit, column.name) if unit else (1.0, 0.0)
        low, high = ((float(limit) - offset) / factor for limit in (told[2], told[3]))
    except (InputError, KeyError, ValueError):
        return None
    values = table.numbers(column.name)[0]
    below, above = int((values < low).sum()), int((values > high).sum())
    if not below + above:
        return None
    return Beyond(column.name, below + above, low if below else None, high if above else None)


def _pulls(values: FloatArray) -> bool:
    """Whether a force is negative under load, as of a cell that counts compression so.

    Examples
    --------
    >>> _pulls(np.array([0.1, 0.0, -90.0])), _pulls(np.array([-0.1, 90.0])), _pulls(np.array([np.nan]))
    (True, False, False)
    """
    known = values[np.isfinite(values)]
    return bool(len(known)) and float(-known.min()) > 3.0 * max(float(known.max()), 0.0)


def _fill(column: ColumnForm, entry: Any) -> None:
    entry = {"quantity": entry} if isinstance(entry, str) else entry
    if not isinstance(entry, Mapping):
        return
    if entry.get("test_table"):
        column.is_, column.column = TEST_TABLE, str(entry["test_table"])
        return
    column.is_ = str(entry.get("quantity") or "")
    column.unit = str(entry.get("unit") or "")
    column.sign = -1 if entry.get("sign") == -1 else 1
    column.offset, column.std = number(entry.get("offset")), number(entry.get("std"))
    column.scale = str(entry.get("scale") or "")
    column.sensitivity = str(entry.get("sensitivity") or "")


def _entry(column: ColumnForm, records: bool) -> dict[str, object]:
    """Return what a map says about a column; what is not filled in, or means nothing to points, is left out."""
    if column.is_ == TEST_TABLE:
        return {"test_table": column.column}
    said = {
        "quantity": column.is_,
        "unit": column.unit or None,
        "sign": -1 if column.sign == -1 else None,
        "offset": column.offset or None if records else None,
        "scale": column.scale or None if records else None,
        "std": column.std if records else None,
        "sensitivity": column.sensitivity or None,
    }
    return {name: value for name, value in said.items() if value is not None}


def number(value: object) -> float | None:
    """Return a number of a file; None for what a field for numbers cannot show.

    Examples
    --------
    >>> number(3), number(float("inf")), number(True), number(10**400), number("3")
    (3.0, None, None, None, None)
    """
    known = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
    return float(value) if known and isinstance(value, int | float) else None
