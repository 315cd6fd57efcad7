"""The command line as real processes: started in a folder, watched from outside, interrupted as at a terminal."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

COMMAND = str(Path(sys.executable).with_name("tribofmu"))
needs_proc = pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="looks into /proc")


def environment(place: Path, **more: str) -> dict[str, str]:
    """Return an environment without Python's own settings, with a cache in the folder."""
    kept = {n: v for n, v in os.environ.items() if n not in {"PYTHONPATH", "PYTHONSAFEPATH"}}
    return kept | {"OMP_NUM_THREADS": "1", "XDG_CACHE_HOME": str(place / "cache")} | more


def has_workers(pid: int) -> bool:
    """Whether two processes of a pool have started: each has a second thread then."""
    ready = [p for p in _children(pid) if "spawn_main" in _read(p, "cmdline") and len(_tasks(p)) > 1]
    return len(ready) >= 2


def interrupted(
    words: list[str], place: Path, when: Callable[[int], bool], **more: str
) -> tuple[int, str, str]:
    """Send an interrupt to a command and its children when `when` is true; return code, output and errors."""
    process = subprocess.Popen(
        words,
        cwd=place,
        env=environment(place, **more),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A job in the background of a shell, as this test may be, ignores interrupts, and so would its children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        until = time.monotonic() + 200.0
        while not when(process.pid) and process.poll() is None:
            assert time.monotonic() < until, f"{words} does not come so far"
            time.sleep(0.01)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=200.0)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    return process.returncode, output, errors


def _read(pid: int, name: str) -> str:
    try:
        return Path(f"/proc/{pid}/{name}").read_text(errors="replace")
    except OSError:
        return ""


def _tasks(pid: int) -> list[str]:
    try:
        return os.listdir(f"/proc/{pid}/task")
    except OSError:
        return []


def _children(pid: int) -> list[int]:
    return [int(c) for task in _tasks(pid) for c in _read(pid, f"task/{task}/children").split()]
