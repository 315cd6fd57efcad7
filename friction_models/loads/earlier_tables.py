"""Test tables before the present one, kept in the folder `earlier` beside it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd

from ..common.files import atomic_path

#: Folder beside the table for the tables before.
EARLIER = "earlier"


def keep(table: Path, folder: Path) -> Path:
    """Copy a table into the folder `earlier` of a folder, under the next number; return where it is."""
    place = folder / EARLIER
    place.mkdir(exist_ok=True)
    numbers = [
        int(p.stem.rpartition("-")[2])
        for p in place.glob(f"{table.stem}-[0-9]*{table.suffix}")
        if p.stem[-3:].isdigit()
    ]
    kept = place / f"{table.stem}-{max(numbers, default=0) + 1:03d}{table.suffix}"
    with atomic_path(kept) as temporary:
        temporary.write_bytes(table.read_bytes())
    return kept


def carry(before: Path, after: Path) -> None:
    """Keep the tables of a folder in the one that takes its place: those of `earlier`, and its own where it differs."""
    old, new = before / "tests.csv", after / "tests.csv"
    if (before / EARLIER).is_dir():
        shutil.copytree(before / EARLIER, after / EARLIER, symlinks=True)
    if old.is_file() and not (new.is_file() and new.read_bytes() == old.read_bytes()):
        keep(old, after)


def with_columns_of(tests: pd.DataFrame, before: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Return a test table with the columns that only the one before has, and their names; tests of the same name keep their cells.

    Examples
    --------
    >>> now, before = pd.DataFrame({"test_id": ["a", "b"]}), pd.DataFrame({"test_id": ["b"], "role": ["test"]})
    >>> with_columns_of(now, before)[0].fillna("").values.tolist()
    [['a', ''], ['b', 'test']]
    """
    more = [str(c) for c in before.columns if c not in tests.columns]
    return tests.merge(before[["test_id", *more]], on="test_id", how="left"), more
