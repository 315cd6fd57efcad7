"""Results that are kept to save time, and the hashes by which they are recognised.

Beside each kept file or folder lie its key and a checksum. A result that was damaged, changed or exchanged for
another does not match them and is computed again.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from .errors import InputError
from .files import write_json

#: Files of a package that are sources of its results.
_SOURCES = (".py", ".yaml", ".c", ".h")


def path_digest(path: str | os.PathLike[str]) -> str:
    """Return the hash of a file's content, or of the names and contents of all files in a folder.

    Raises InputError: nothing is there, or it cannot be read.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     for name, text in (("a.txt", "mu"), ("b.txt", "mu"), ("c.txt", "nu")):
    ...         _ = (Path(place) / name).write_text(text)
    ...     a, b, c = (path_digest(Path(place) / name) for name in ("a.txt", "b.txt", "c.txt"))
    >>> a == b, a == c
    (True, False)
    """
    place = Path(path)
    result = hashlib.sha256()
    try:
        if not place.is_dir():
            with place.open("rb") as stream:
                return hashlib.file_digest(stream, "sha256").hexdigest()
        for file in sorted(p for p in place.rglob("*") if p.is_file()):
            result.update(f"{file.relative_to(place).as_posix()}\0{path_digest(file)}\n".encode())
    except OSError as error:
        raise InputError(f"{place}: cannot be read ({error.strerror}); allowed: a file or a folder") from None
    return result.hexdigest()


def fingerprint(*parts: object) -> str:
    """Return a hash of contents and settings; bytes are taken as they are.

    Examples
    --------
    >>> fingerprint("fre", 0.1) == fingerprint("fre", 0.1), fingerprint("fre", 0.1) == fingerprint("fre", 0.2)
    (True, False)
    """
    result = hashlib.sha256()
    for part in parts:
        result.update(part if isinstance(part, bytes) else repr(part).encode())
        result.update(b"\0")
    return result.hexdigest()[:32]


def digest(content: Any) -> str:
    """Return the hash of JSON-able content; raises TypeError or ValueError for other content, NaN among it.

    Examples
    --------
    >>> digest({"v": 20, "T": 80}) == digest({"T": 80, "v": 20})
    True
    >>> digest({"v": float("nan")})
    Traceback (most recent call last):
        ...
    ValueError: ...
    """
    text = json.dumps(content, sort_keys=True, allow_nan=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def code_digest(names: Iterable[str]) -> str:
    """Return the hash of the sources of packages and modules, as they lie on the disk now.

    Raises InputError: no such package.

    Examples
    --------
    >>> code_digest(["json", "json"]) == code_digest(["json"])
    True
    """
    return digest({name: _sources(name) for name in sorted(set(names))})


def _sources(name: str) -> list[list[str]]:
    """Return file names and content hashes of one package or module."""
    files, top = source_files(name), source_place(name)
    return [[(p.name if p == top else p.relative_to(top or p).as_posix()), path_digest(p)] for p in files]


def source_files(name: str) -> list[Path]:
    """Return the sources of a package or module.

    Raises InputError: no such package.

    Examples
    --------
    >>> [file.name for file in source_files("json.decoder")]
    ['decoder.py']
    """
    place = source_place(name)
    if place is None:
        raise InputError(f"campaign: code {name!r}; allowed: an importable package or module with sources")
    if place.is_file():
        return [place]
    return sorted(p for p in place.rglob("*") if p.suffix in _SOURCES and p.is_file())


@cache
def source_place(name: str) -> Path | None:
    """Return the file of a module or the folder of a package, None where there is no such source.

    Examples
    --------
    >>> source_place("json.decoder").name, source_place("json").name, source_place("no_such_package")
    ('decoder.py', 'json', None)
    """
    try:
        spec = importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return None
    if spec is None or spec.origin is None:
        return None
    file = Path(spec.origin)
    return file.parent if file.name == "__init__.py" else file


def keep(path: Path, key: str) -> None:
    """Write beside a finished file or folder that it is the result of `key`, and its checksum.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "force.csv"
    ...     _ = file.write_text("1.0")
    ...     keep(file, "run 7")
    ...     sorted(p.name for p in Path(place).iterdir())
    ['force.csv', 'force.csv.kept']
    """
    write_json(_seal(path), {"key": key, "sha256": path_digest(path)})


def is_kept(path: Path, key: str) -> bool:
    """Return whether a file or folder is the result of `key`, unchanged since `keep`.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "force.csv"
    ...     _ = file.write_text("1.0")
    ...     keep(file, "run 7")
    ...     print(is_kept(file, "run 7"), is_kept(file, "run 8"))
    ...     _ = file.write_text("2.0")
    ...     print(is_kept(file, "run 7"))
    True False
    False
    """
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

    Raises PermissionError: it is another user's.
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
