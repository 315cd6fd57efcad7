"""Results kept to save time. A file beside each result holds a checksum and the key of what it was computed from.

A result that was damaged, changed or replaced is computed again.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

from .errors import InputError
from .files import write_json


def path_digest(path: str | os.PathLike[str]) -> str:
    """Return the hash of a file's content, or of the names and contents of all files in a folder.

    Raises
    ------
    InputError
        Nothing is there, or it cannot be read.
    """
    place = Path(path)
    digest = hashlib.sha256()
    try:
        if not place.is_dir():
            with place.open("rb") as stream:
                return hashlib.file_digest(stream, "sha256").hexdigest()
        for file in sorted(p for p in place.rglob("*") if p.is_file()):
            digest.update(f"{file.relative_to(place).as_posix()}\0{path_digest(file)}\n".encode())
    except OSError as error:
        raise InputError(f"{place}: cannot be read ({error.strerror}); allowed: a file or a folder") from None
    return digest.hexdigest()


def keep(path: Path, key: str) -> None:
    """Write beside a finished file or folder that it is the result of `key`, and its checksum."""
    write_json(_seal(path), {"key": key, "sha256": path_digest(path)})


def is_kept(path: Path, key: str) -> bool:
    """Return whether a file or folder is the result of `key`, unchanged since `keep`."""
    if not path.exists():
        return False
    try:
        content = json.loads(_seal(path).read_text(encoding="utf-8"))
        return bool(content == {"key": key, "sha256": path_digest(path)})
    except (InputError, OSError, ValueError, RecursionError):
        return False


def _seal(path: Path) -> Path:
    return path.with_name(f"{path.name}.kept")


def cache_folder() -> Path:
    """Return the user's cache folder of the project; nobody else can write to it or read it.

    Raises
    ------
    PermissionError
        It is another user's.
    """
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    folder = Path(base) / "tribofmu"
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    there = folder.stat()
    if hasattr(os, "getuid"):
        if there.st_uid != os.getuid():
            raise PermissionError(
                1, "is the folder of another user; XDG_CACHE_HOME names another", str(folder)
            )
        if there.st_mode & 0o077:
            folder.chmod(0o700)
    return folder
