"""A command in a forked child of this process: bounded in time, memory and disk, its words caught."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from dataclasses import dataclass
from pathlib import Path

#: What one command may take [bytes].
MEMORY, FILE = 12 * 1024**3, 512 * 1024**2


@dataclass
class Ended:
    """How a command ended.

    Attributes
    ----------
    code : int
        Exit code; the negative number of a signal.
    out, err : str
        What it printed.
    seconds : float
        How long it took; NaN when it was stopped at the limit.
    left : str
        The processes that it left running, empty where there are none.
    """

    code: int
    out: str
    err: str
    seconds: float
    left: str

    @property
    def hung(self) -> bool:
        return self.seconds != self.seconds


def in_child(arguments: list[str], place: Path, root: Path, limit: float) -> Ended:
    """Run a command of tribofmu in `place`, with temporary files below `root`, for at most `limit` seconds."""
    # Beside the sandbox: a command that removes the whole of it must not take these along.
    said = [root.with_name(f"{root.name}-{name}") for name in ("stdout", "stderr")]
    began = time.monotonic()
    pid = os.fork()
    if pid == 0:
        _become(arguments, place, root, said)
    code, hung = None, False
    while code is None:
        done, status = os.waitpid(pid, os.WNOHANG)
        if done:
            code = os.waitstatus_to_exitcode(status)
        elif time.monotonic() - began > limit:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
            code, hung = -signal.SIGKILL, True
        else:
            time.sleep(0.004)
    seconds = time.monotonic() - began
    left = _stop_group(pid)
    out, err = (path.read_text("utf-8", "replace") for path in said)
    return Ended(code, out, err, float("nan") if hung else seconds, left)


def _stop_group(group: int) -> str:
    """End what the child started and left; name what was there after a moment of grace."""
    for _ in range(100):
        if not (left := _alive(group)):
            return ""
        time.sleep(0.02)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)
    return ", ".join(left)


def _alive(group: int) -> list[str]:
    """Name the processes of a group, without those that have ended and wait to be counted."""
    found: list[str] = []
    try:
        os.killpg(group, 0)
    except (ProcessLookupError, PermissionError):
        return found
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            state, _, its_group = (folder / "stat").read_text().rpartition(")")[2].split()[:3]
            if int(its_group) == group and state not in "ZX":
                threads = sorted({(t / "wchan").read_text() for t in (folder / "task").iterdir()})
                found.append(f"{folder.name} ({state}, waits in {' and '.join(threads)})")
    return found


def _become(arguments: list[str], place: Path, root: Path, said: list[Path]) -> None:
    code = 70
    try:
        os.setsid()
        for number, path in enumerate(said, start=1):
            os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644), number)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        sys.stdin, sys.stdout, sys.stderr = map(os.fdopen, (0, 1, 2), ("r", "w", "w"))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (FILE, FILE))
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        os.chdir(place)
        os.environ |= {"TMPDIR": str(root / "tmp"), "COLUMNS": "100"}
        os.environ.pop("TRIBOFMU_TRACEBACK", None)
        tempfile.tempdir = str(root / "tmp")
        from orchestrator.cli.main import run

        code = run(arguments)
    except SystemExit as left:
        code = left.code if isinstance(left.code, int) else 1
    except BaseException:
        traceback.print_exc()
        code = 1
    finally:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(BaseException):
                stream.flush()
        os._exit(code & 0xFF)
