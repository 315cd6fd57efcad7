"""Looking at processes, and interpreters of the tests' own."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

import pytest


def children() -> set[int]:
    """Return the processes that this one has started and not yet collected."""
    tasks = Path("/proc/self/task")
    if not tasks.is_dir():
        pytest.skip("no /proc: the children of this process cannot be listed")
    found: set[int] = set()
    for task in tasks.iterdir():
        with contextlib.suppress(OSError):  # a thread that ends meanwhile
            found |= {int(p) for p in (task / "children").read_text().split()}
    return found


def gone(pid: int, seconds: float = 20.0) -> bool:
    """Return whether a process ends, or is only waiting to be collected, within a time."""
    for _ in range(int(seconds / 0.05)):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.05)
    return False


def script(place: Path, text: str) -> Path:
    file = place / "python-of-the-test"
    file.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    file.chmod(0o755)
    return file
