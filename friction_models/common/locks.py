"""Locks that let one process at a time work in a folder."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import InputError


@contextmanager
def locked(file: Path, busy: str) -> Iterator[None]:
    """Keep other processes out of a block by a lock on `file`; it ends with this process, however that ends.

    Raises InputError: another process is in such a block; the text is `busy`.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     with locked(Path(place) / "lock", "another run is at work here"):
    ...         print("alone")
    alone
    """
    handle = os.open(file, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        if not _taken(handle):
            raise InputError(busy)
        yield
    finally:
        os.close(handle)


@contextmanager
def one_at_a_time(folder: Path) -> Iterator[None]:
    """Let one after the other into a short block that writes in a folder; nothing is left in it.

    Windows locks no folders: there, nobody waits.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place, one_at_a_time(Path(place)):
    ...     print("alone")
    alone
    """
    if sys.platform == "win32":
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        _taken(handle, wait=True)
        yield
    finally:
        os.close(handle)


def _taken(handle: int, wait: bool = False) -> bool:
    """Take the lock of an open file (or, but on Windows, folder); False where another process has it and nobody waits."""
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        pass  # a file system without locks
    return True
