"""What pages have read of files and data sets: kept as long as the files stay as they are."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from friction_models.loads import DataSet

Read = TypeVar("Read")


def kept_while_unchanged(most: int) -> Callable[[Callable[[Path], Read]], Callable[[Path], Read]]:
    """Return a decorator for a function that reads a path: it reads once while the files stay as they are, `most` paths at a time."""

    def decorated(read: Callable[[Path], Read]) -> Callable[[Path], Read]:
        cached = lru_cache(maxsize=most)(lambda path, seen: read(path))

        @wraps(read)
        def reading(path: Path) -> Read:
            return cached(path, _seen(path))

        return reading

    return decorated


def _seen(path: Path) -> tuple[tuple[int, int], ...]:
    """Return what changes when a file, or one of a data set, changes."""
    files = [path / n for n in ("points.csv", "tests.csv", "dataset.json")] if path.is_dir() else [path]
    return tuple((s.st_mtime_ns, s.st_size) for f in files if f.is_file() for s in [f.stat()])


@kept_while_unchanged(2)
def loaded(path: Path) -> DataSet:
    """Return a data set; raises InputError for what `DataSet.load` refuses."""
    from friction_models.loads import DataSet

    return DataSet.load(path, need_mu=False)
