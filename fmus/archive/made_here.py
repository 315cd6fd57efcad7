"""Which FMUs this program wrote on this machine. All others run in a separate process.

What an FMU says of its maker proves nothing: anybody may write that. So `pack` notes the hash of each FMU that it writes in the
user's cache folder. An FMU with that very content is ours and whole; any other one, also one of ours that was damaged, changed or
made elsewhere, runs in a process of its own, where a crash does no harm.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from friction_models.common import InputError
from friction_models.common.cached_results import cache_folder, path_digest

#: Environment variable that decides for all FMUs: 1 for a process of its own, 0 for none.
VARIABLE = "TRIBOFMU_ISOLATE"
#: A larger list starts anew: what is forgotten merely runs in a process of its own.
_MAX_BYTES = 2_000_000


def _list() -> Path:
    return cache_folder() / "fmus-made-here.txt"


def remember(path: Path) -> Path:
    """Note an FMU that was just written; return its path."""
    # A cache folder that cannot be written costs a process, nothing else.
    with contextlib.suppress(OSError):
        found = path_digest(path)
        file = _list()
        if found not in _known(file):
            anew = file.is_file() and file.stat().st_size > _MAX_BYTES
            with file.open("w" if anew else "a", encoding="ascii") as stream:
                stream.write(f"{found}\n")
    return path


def made_here(path: str | os.PathLike[str]) -> bool:
    """Whether this program wrote an FMU of this content on this machine.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "law.fmu"
    ...     _ = file.write_text("written by somebody else")
    ...     made_here(file)
    False
    """
    try:
        return path_digest(path) in _known(_list())
    except (OSError, InputError):
        return False


def _known(file: Path) -> set[str]:
    try:
        return set(file.read_text(encoding="ascii", errors="replace").split())
    except OSError:
        return set()


def runs_apart(path: str | os.PathLike[str], isolate: bool | None = None) -> bool:
    """Whether an FMU runs in a process of its own: as `isolate` says, as `VARIABLE` says, or where it was not made here.

    Raises InputError: the variable holds something else than 0 or 1.

    Examples
    --------
    >>> runs_apart("law.fmu", isolate=True), runs_apart("law.fmu", isolate=False)
    (True, False)
    """
    if isolate is not None:
        return isolate
    chosen = os.environ.get(VARIABLE, "")
    if chosen not in {"", "0", "1"}:
        raise InputError(f"{VARIABLE} = {chosen[:40]!r}, allowed: 0 or 1")
    return chosen == "1" if chosen else not made_here(path)
