"""Memory and file limits of a process that runs foreign code."""

from __future__ import annotations

import contextlib
import os

#: Largest file that it may write [bytes].
_FILE_LIMIT = 1024**3


def limit_memory(most: int) -> None:
    """Bound what this process may take [bytes], where the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    with contextlib.suppress(ValueError, OSError):
        most = min(most, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") * 3 // 4)
    # RLIMIT_DATA counts what is written to, not what libraries reserve without using it.
    for kind, value in (
        (resource.RLIMIT_DATA, most),
        (resource.RLIMIT_FSIZE, _FILE_LIMIT),
        (resource.RLIMIT_CORE, 0),
    ):
        with contextlib.suppress(ValueError, OSError):
            _, hard = resource.getrlimit(kind)
            value = value if hard == resource.RLIM_INFINITY else min(value, hard)
            resource.setrlimit(kind, (value, value))
