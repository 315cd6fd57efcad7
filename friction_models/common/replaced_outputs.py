"""What a command replaces is put beside it under the next free number, where something of it would be lost."""

from __future__ import annotations

import filecmp
import itertools
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from .folders import FolderKind, absolute, json_object

#: Environment variable: with the value ``no`` outputs of the same name are replaced, and nothing of them is kept.
KEEP = "TRIBOFMU_KEEP_EARLIER"


class Moved(NamedTuple):
    """An output that made way for a new one."""

    name: Path
    now: Path


@dataclass
class _Watched:
    places: dict[Path, Path]
    moved: list[Moved] = field(default_factory=list)


_watched: ContextVar[_Watched | None] = ContextVar("watched", default=None)


@contextmanager
def keeping_earlier(outputs: Iterable[Path]) -> Iterator[list[Moved]]:
    """Keep what stands under these names when `atomic_path` or `atomic_folder` replaces it; yield what was moved.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from friction_models.common import write_text
    >>> with TemporaryDirectory() as place:
    ...     file = write_text(Path(place) / "mu.txt", "0.08")
    ...     with keeping_earlier([file]) as moved:
    ...         _ = write_text(file, "0.04")
    ...     [(m.now.name, m.now.read_text()) for m in moved]
    [('mu.txt.1', '0.08')]
    """
    watched = _Watched({absolute(path): path for path in outputs})
    if os.environ.get(KEEP, "").lower() == "no":
        watched.places.clear()
    token = _watched.set(watched)
    try:
        yield watched.moved
    finally:
        _watched.reset(token)


@contextmanager
def making_way(final: Path, new: Path, kind: FolderKind | None = None) -> Iterator[None]:
    """Put `final` aside for `new` where it is to be kept; on an error in the block it comes back."""
    watched = _watched.get()
    # What the command itself writes a second time is not kept.
    given = watched.places.pop(absolute(final), None) if watched is not None else None
    if watched is None or given is None or not os.path.lexists(final) or not _loses(final, new, kind):
        yield
        return
    aside = moved_aside(final)
    try:
        yield
    except BaseException:
        aside.replace(final)
        raise
    watched.moved.append(Moved(given, given.with_name(aside.name)))


def moved_aside(final: Path) -> Path:
    """Rename a file or folder to the next free of NAME.1, NAME.2 and so on; return where it is now."""
    # File systems allow 255 bytes; in UTF-8 a letter has up to four.
    stem = final.name if len(os.fsencode(final.name)) <= 245 else final.name[:60]
    places = (final.with_name(f"{stem}.{number}") for number in itertools.count(1))
    return final.replace(next(p for p in places if not os.path.lexists(p)))


def _loses(old: Path, new: Path, kind: FolderKind | None) -> bool:
    """Return whether something in an old output is not in the new one, apart from when it was made and how long that took."""
    if kind is None:
        return old.is_symlink() or not filecmp.cmp(old, new, shallow=False)
    for place, folders, files in os.walk(old):
        inside = Path(place).relative_to(old)
        for name in files:
            file = inside / name
            if not _same(old / file, new / file, file.as_posix(), kind):
                return True
        if any((Path(place) / name).is_symlink() for name in folders):
            return True
    return False


def _same(old: Path, new: Path, name: str, kind: FolderKind) -> bool:
    if old.is_symlink() or not new.is_file():
        return False
    if filecmp.cmp(old, new, shallow=False):
        return True
    if name not in kind.dated:
        return False
    return not name.endswith(".json") or _timeless(old, kind) == _timeless(new, kind)


def _timeless(file: Path, kind: FolderKind) -> dict[str, Any]:
    return {key: value for key, value in json_object(file).items() if key not in kind.times}
