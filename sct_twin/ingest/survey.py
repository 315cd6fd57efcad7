"""Survey of measurement files: every test is read, mapped to channels and checked."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from friction_models.common import InputError, nearest, shown
from friction_models.common.files import read_json
from friction_models.common.processes.pool import Progress
from friction_models.loads.dataset import says_synthetic

from ..readers import RawTable, read_file
from ..records.record import SctRecord
from .channel_map import ChannelMap, Map
from .measurement_files import (
    LeftOut,
    NameTemplate,
    Source,
    measurement_files,
    passed_over,
    proposed,
    tests_beside,
)
from .quality import quality_row, repeats
from .raw_campaign import check_test_id, read_test_table


@dataclass(frozen=True)
class FoundColumn:
    """A column of a file: its name, unit, smallest and largest value, and the channel it becomes."""

    name: str
    unit: str
    low: float
    high: float
    quantity: str | None

    @classmethod
    def of(cls, table: RawTable, name: str, mapping: ChannelMap) -> FoundColumn:
        """Describe a column of a table."""
        used = mapping.used(table).get(name)
        unit = (used.unit if used is not None else None) or table.units.get(name, "")
        numbers, _ = table.numbers(name)
        known = numbers[~np.isnan(numbers)]
        low, high = (float(known.min()), float(known.max())) if len(known) else (np.nan, np.nan)
        return cls(name, unit, low, high, None if used is None else used.quantity)


@dataclass(frozen=True)
class FileFound:
    """A file that could be read: its format, columns and what the reader says about it."""

    file: str
    format: str
    columns: tuple[FoundColumn, ...]
    notes: tuple[str, ...]
    table: RawTable | None = None

    @property
    def layout(self) -> tuple[str, tuple[tuple[str, str, str | None], ...]]:
        """What files of the same logger have in common."""
        return self.format, tuple((column.name, column.unit, column.quantity) for column in self.columns)


@dataclass
class Survey:
    """What was found."""

    #: Readable files; the first one of each layout keeps its table.
    files: list[FileFound] = field(default_factory=list)
    #: Quality of the tests that can be used.
    rows: list[dict[str, object]] = field(default_factory=list)
    #: Their rows of the test table.
    tests: list[dict[str, object]] = field(default_factory=list)
    #: Files that cannot be used, and why.
    left_out: list[LeftOut] = field(default_factory=list)
    #: What is known about the campaign.
    info: dict[str, Any] = field(default_factory=dict)
    #: Tests that were looked at.
    count: int = 0
    #: Template by which files would get the names of the test table.
    proposal: str | None = None

    @property
    def test_table(self) -> pd.DataFrame:
        """One row a test, `test_id` first."""
        frame = pd.DataFrame(self.tests)
        return frame[["test_id", *(c for c in frame.columns if c != "test_id")]] if len(frame) else frame


def survey(
    source: Source,
    channel_map: Map = None,
    tests: str | os.PathLike[str] | None = None,
    take: Callable[[SctRecord], None] | None = None,
    progress: Progress | None = None,
    test_id: str | None = None,
) -> Survey:
    """Read every test, judge it, and call `take` with each record that can be used.

    The other arguments are those of `sct_twin.ingest.campaign_files.ingest`.

    Raises InputError: no files, or a bad channel map or test table. A file that cannot be used is left out
    with a reason.
    """
    mapping = ChannelMap.load(channel_map)
    files, home = measurement_files(source)
    # The test table that is named, or else the one beside the files, if there is one.
    beside = Path(tests) if tests is not None else None if home is None else tests_beside(home)
    table = None if beside is None else read_test_table(beside)
    result = Survey(info=_info(home, table, mapping))
    mass = float(result.info.get("moving_mass_kg") or 0.0)
    work: list[tuple[str, Path | None, Path]] = [(file.stem, None, file) for file in files]
    if mapping.files is not None:
        pairs, result.left_out = mapping.files.pairs(files)
        work = list(pairs)
    result.count = len(work)
    names = NameTemplate.load(test_id, "--test-id") or mapping.names
    known: dict[str, Path] = {}
    seen: dict[bytes, str] = {}
    tried: set[str] = set()
    listed = [] if table is None else list(table["test_id"])
    for number, (name, before, file) in enumerate(work):
        test = name
        try:
            test = name if names is None else names.test_of(name, f"{file}: ")
            check_test_id(test, str(file))
            if test in known:
                raise InputError(
                    f"{file}: a second file of test {test!r}, the first is {known[test]}; allowed: one file a test"
                )
            record, notes = _record(result, mapping, before, file, test, table)
            if table is not None and test not in listed:
                notes.append(_not_listed(test, listed))
            if (same := seen.setdefault(_numbers(record), test)) != test:
                notes.append(f"holds the same numbers as test {same!r}: is it a copy?")
            row = {**quality_row(record, record.number("moving_mass", mass)), "notes": "; ".join(notes)}
            if take is not None:
                take(record)
            known[test] = file
            result.rows.append(row)
            result.tests.append({**record.metadata, "test_id": test})
        except InputError as error:
            reason = shown(error, 1000)
            if table is not None and test not in listed and "test table" in reason:
                reason += f"; test {test!r} is {_not_listed(test, listed)}"
            result.left_out.append(LeftOut(str(file), reason))
        except MemoryError:
            result.left_out.append(LeftOut(str(file), f"{file}: too large for the memory"))
        finally:
            if progress is not None:
                progress(number + 1, len(work), test)
        tried.add(test)
    gone = sorted(set(listed) - tried)
    result.left_out += [
        LeftOut("", f"test {shown(test, 100)!r} of the test table has no file") for test in gone
    ]
    if table is not None and names is None:
        result.proposal = proposed(gone, [file for name, _, file in work if name not in listed])
    result.left_out += passed_over(source)
    if result.tests:
        for row, count in zip(result.rows, repeats(result.test_table)):
            row["repeats"] = count
    return result


def _info(home: Path | None, table: pd.DataFrame | None, mapping: ChannelMap) -> dict[str, object]:
    """Return what is known about the campaign: its own file, if there is one, the test table, the channel map."""
    info: dict[str, object] = {"synthetic": False}
    if home is not None and (home / "campaign.json").is_file():
        info = read_json(home / "campaign.json")
    if table is not None and says_synthetic(table):
        info["synthetic"] = True
    if mapping.moving_mass is not None:
        info["moving_mass_kg"] = mapping.moving_mass
    return info


def _numbers(record: SctRecord) -> bytes:
    """Return what two records share when all their channels hold the same numbers."""
    total = sha256()
    for name in record.channels:
        total.update(name.encode() + np.ascontiguousarray(getattr(record, name)).tobytes())
    return total.digest()


def _not_listed(test: str, listed: Sequence[str]) -> str:
    close = nearest(test, listed)
    return "not in the test table" + (f" (is it {close!r} there?)" if close else "")


def _record(
    result: Survey,
    mapping: ChannelMap,
    before: Path | None,
    file: Path,
    test_id: str,
    table: pd.DataFrame | None,
) -> tuple[SctRecord, list[str]]:
    """Read one test from its file or its two files."""
    metadata = dict(mapping.metadata)
    if table is not None:
        hits = table[table["test_id"] == test_id]
        if not hits.empty:
            metadata |= {str(k): v for k, v in hits.iloc[0].dropna().items()}
    first = None if before is None else _read(result, mapping, before)
    last = _read(result, mapping, file)
    if first is None:
        return mapping.record(last, test_id, metadata), []
    return mapping.joined(first, last, test_id, metadata)


def _read(result: Survey, mapping: ChannelMap, file: Path) -> RawTable:
    table = read_file(file)
    columns = tuple(FoundColumn.of(table, str(name), mapping) for name in table.frame.columns)
    found = FileFound(str(file), table.format, columns, table.notes)
    if all(found.layout != other.layout for other in result.files):
        # The first file of a layout is kept for a draft of the map, without its rows but a few.
        numbered = [column.name for column in columns if not np.isnan(column.low)]
        head = RawTable(table.frame[numbered].head(5).copy(), table.units, table.source, table.format)
        found = FileFound(str(file), table.format, columns, table.notes, head)
    result.files.append(found)
    return table
