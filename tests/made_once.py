"""A folder that the first process of a run of the tests makes, and the others take."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

#: Longest wait for the process that makes it [s].
PATIENCE = 600.0


def made_once(folder: Path, make: Callable[[Path], object]) -> Path:
    """Return `folder` when it is there; who asks first makes it."""
    begun, ready = (folder.with_name(f"{folder.name}.{state}") for state in ("begun", "ready"))
    try:
        begun.touch(exist_ok=False)
    except FileExistsError:
        until = time.monotonic() + PATIENCE
        while not ready.exists():
            assert time.monotonic() < until, f"{folder} was begun and is not ready"
            time.sleep(0.1)
    else:
        try:
            make(folder)
        finally:  # who waits for what failed sees that it is not there
            ready.touch()
    return folder
