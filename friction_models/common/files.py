"""Atomic writing: a file or folder is written beside its target, then renamed, so that nobody sees half of it."""

from __future__ import annotations

import contextlib
import errno
import json
import lzma
import math
import os
import shutil
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tokenize import TokenError
from typing import Any

from .byte_order_marks import decoded
from .errors import InputError, check_readable, shown
from .folders import FolderKind, check_folder, check_parents
from .replaced_outputs import making_way
from .wording import kind_of

#: What the standard library and NumPy raise on damaged archives of arrays.
DAMAGED = (
    *(zipfile.BadZipFile, zlib.error, struct.error, lzma.LZMAError, EOFError, OSError, TokenError),
    *(ValueError, TypeError, SyntaxError, OverflowError, MemoryError, NotImplementedError, RuntimeError),
)


@contextmanager
def atomic_path(target: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary file path beside `target`; rename it onto `target` when the block succeeds.

    On an error, or an interrupt, the temporary file is removed and `target` stays as it was.

    Raises InputError: `target` is a folder, or cannot be: see `check_file`.

    Examples
    --------
    >>> folder = tempfile.TemporaryDirectory()
    >>> file = Path(folder.name) / "result.txt"
    >>> with atomic_path(file) as temporary:
    ...     _ = temporary.write_text("whole")
    ...     file.exists()
    False
    >>> file.read_text()
    'whole'
    >>> with atomic_path(file) as temporary:
    ...     _ = temporary.write_text("ha")
    ...     raise OSError("the disk is gone")
    Traceback (most recent call last):
        ...
    OSError: the disk is gone
    >>> file.read_text()
    'whole'
    >>> folder.cleanup()
    """
    final = check_file(target)
    with _naming(final), _parents(final):
        # A short part of the name: the temporary one must not be longer than names may be.
        handle, name = tempfile.mkstemp(
            prefix=f".{final.name[:40]}.", suffix=final.suffix[:20], dir=final.parent
        )
        os.close(handle)
        temporary = Path(name)
        try:
            yield temporary
            temporary.chmod(0o644)
            with making_way(final, temporary):
                temporary.replace(final)
        finally:
            temporary.unlink(missing_ok=True)


@contextmanager
def atomic_folder(target: str | os.PathLike[str], kind: FolderKind) -> Iterator[Path]:
    """Yield a temporary folder beside `target`; put it in place of `target` when the block succeeds.

    On an error, or an interrupt, the temporary folder is removed and `target` stays as it was.

    Raises InputError: `target` is something else than a new or empty folder, or one of this kind; see
    `check_folder`.

    Examples
    --------
    >>> kind = FolderKind("a study of wear", marks=("wear.json",))
    >>> with tempfile.TemporaryDirectory() as place:
    ...     with atomic_folder(Path(place) / "wear", kind) as temporary:
    ...         _ = write_json(temporary / "wear.json", {"depth": 0.1})
    ...     sorted(p.relative_to(place).as_posix() for p in Path(place).rglob("*"))
    ['wear', 'wear/wear.json']
    """
    final = check_folder(target, kind)
    with _naming(Path(target)), _parents(final):
        temporary = Path(tempfile.mkdtemp(prefix=f".{final.name[:40]}.", dir=final.parent))
        try:
            yield temporary
            temporary.chmod(0o755)
            check_folder(target, kind)  # again: much may have happened meanwhile
            with making_way(final, temporary, kind):
                _put_in_place(temporary, final)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)


@contextmanager
def _parents(target: Path) -> Iterator[None]:
    """Make the folders above `target`; on an error those that were made go again."""
    made = [folder for folder in target.absolute().parents if not folder.exists()]
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        with contextlib.suppress(OSError):  # no longer empty: somebody uses them
            for folder in made:
                folder.rmdir()
        raise


def _put_in_place(folder: Path, final: Path) -> None:
    """Rename a folder onto another, which is removed when that was done."""
    if not final.exists():
        folder.replace(final)
        return
    aside = Path(tempfile.mkdtemp(prefix=f".{final.name[:40]}.old.", dir=final.parent))
    try:
        final.replace(aside / "old")
        try:
            folder.replace(final)
        except BaseException:
            (aside / "old").replace(final)
            raise
    finally:
        # Never with what could not be put back.
        if final.exists():
            shutil.rmtree(aside, ignore_errors=True)


def check_file(target: str | os.PathLike[str]) -> Path:
    """Return the path of a file to be written, when it can be; nothing is changed.

    Raises InputError: a folder, a name without an end, too long, below a file or where one may not write.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as place:
    ...     file = check_file(Path(place) / "runs" / "one.csv")
    ...     file.name, file.parent.exists()
    ('one.csv', False)
    >>> check_file(".")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: .: is a folder; allowed: a file
    """
    final = Path(target)
    try:
        if final.is_dir():
            raise InputError(f"{final}: is a folder; allowed: a file")
        if final.is_symlink():  # also one that the system keeps, as that of the standard output
            raise InputError(f"{final}: is a link, which is not replaced; allowed: a file")
        if final.exists() and not final.is_file():  # a device, a pipe: renamed onto it, a file would end it
            raise InputError(f"{final}: is no plain file; allowed: a file")
        if not final.is_file():
            check_parents(final)
    except OSError as error:
        raise InputError(f"{shown(final)}: cannot be written ({error.strerror})") from None
    return final


#: Errors that say that something cannot be written, whoever raises them.
_OF_THE_DISK = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS}


@contextmanager
def _naming(target: Path) -> Iterator[None]:
    """Let errors of the disk name what was to be written, not the temporary beside it.

    The OSError has the name of `target` also where a library met a full disk and says something else.
    """
    try:
        yield
    except InputError:
        raise
    except (OSError, RuntimeError) as error:
        # A library that meets a full disk may call it anything: netCDF a missing permission.
        number = errno.ENOSPC if _full(target) else getattr(error, "errno", None)
        hidden = f".{target.name[:40]}."
        name = getattr(error, "filename", None)
        ours = any(part.startswith(hidden) for part in Path(str(name)).parts)
        if number is not None and (ours or (name is None and number in _OF_THE_DISK)):
            raise OSError(number, os.strerror(number), str(target)) from error
        raise


def _full(target: Path) -> bool:
    """Return whether the disk of a path has no room left."""
    above = next((p for p in Path(os.path.abspath(target)).parents if p.exists()), None)
    return above is not None and shutil.disk_usage(above).free < 1 << 16


def write_text(target: str | os.PathLike[str], text: str) -> Path:
    """Write `text` as UTF-8, atomically; return the path.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as place:
    ...     write_text(Path(place) / "notes" / "first.txt", "µ = 0.1").read_text(encoding="utf-8")
    'µ = 0.1'
    """
    with atomic_path(target) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return Path(target)


def write_json(target: str | os.PathLike[str], content: Any) -> Path:
    """Write `content` as indented JSON with a final newline, atomically; NaN is refused.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as place:
    ...     print(write_json(Path(place) / "model.json", {"mu": 0.1}).read_text())
    {
      "mu": 0.1
    }
    """
    return write_text(target, json.dumps(content, indent=2, allow_nan=False) + "\n")


def _integer(digits: str) -> int | float:
    """Return a whole number; one that no float holds is infinite, which every check of a number refuses."""
    return int(digits) if len(digits) < 300 else float(digits)


def read_json(path: Path, most: float = math.inf) -> dict[str, Any]:
    """Read a JSON object from a file of `most` bytes at most.

    Raises InputError: the file cannot be read, is too large, is not JSON, or holds something else.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as place:
    ...     read_json(write_json(Path(place) / "model.json", {"mu": 0.1}))
    {'mu': 0.1}
    """
    if path.is_file():
        check_readable(path, most)
    try:
        content = json.loads(decoded(path.read_bytes()), parse_int=_integer)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; allowed: a JSON file") from None
    except (ValueError, OSError, RecursionError) as error:
        raise InputError(f"{path}: not readable JSON ({error})") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: holds {kind_of(content)}, allowed: a JSON object")
    return content
