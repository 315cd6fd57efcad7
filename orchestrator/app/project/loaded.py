"""Data sets that pages have read: kept as long as their files stay as they are."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from friction_models.loads import DataSet


def loaded(path: Path) -> DataSet:
    """Return a data set, read once for as long as its files stay as they are.

    Raises InputError: what `DataSet.load` refuses.
    """
    return _read(path, stamp(path))


def stamp(path: Path) -> tuple[tuple[int, int], ...]:
    """Return what changes when the files of a data set change."""
    files = [path / n for n in ("points.csv", "tests.csv", "dataset.json")] if path.is_dir() else [path]
    return tuple((s.st_mtime_ns, s.st_size) for f in files if f.is_file() for s in [f.stat()])


@lru_cache(maxsize=2)
def _read(path: Path, seen: tuple[tuple[int, int], ...]) -> DataSet:
    return DataSet.load(path, need_mu=False)
