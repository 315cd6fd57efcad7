"""Readers that use third-party libraries run in a separate process.

A damaged file can make such a library loop, fill the memory or crash. Then the process is ended, the caller gets an
InputError and goes on. One process serves all files until it has to be ended.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import queue
import subprocess
import tempfile
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import IO, NotRequired, TypedDict

import numpy as np
import pandas as pd

from friction_models.common import InputError
from friction_models.common.processes import timed
from friction_models.common.processes.child_processes import python_command
from friction_models.common.processes.timed import NotReady

from .table import RawTable

#: Memory a reader may use [bytes], where the system can limit it.
MEMORY = 6 * 1024**3
#: Time a reader may take [s] once its library is loaded: a start, and a rate that the slowest library (Excel) reaches.
PATIENCE = 60.0
BYTES_PER_SECOND = 2e5
#: The line by which the process says that the library is loaded.
READY = "ready"

_lock = threading.Lock()
_reader: _Process | None = None


class _Answer(TypedDict):
    """What the reading process answers: names, units, format and notes of a table; or an error alone."""

    names: list[str]
    units: dict[str, str]
    format: str
    notes: list[str]
    error: NotRequired[str]


class _Process:
    """A reading process and the thread that listens to it."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            python_command("sct_twin.readers._process"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            encoding="utf-8",
        )
        self.answers: queue.Queue[str] = queue.Queue()
        assert self.process.stdout is not None
        threading.Thread(target=self._listen, args=(self.process.stdout,), daemon=True).start()

    def _listen(self, stream: IO[str]) -> None:
        for line in stream:
            self.answers.put(line)
        self.answers.put("")

    def ask(self, question: Mapping[str, str], patience: float) -> _Answer | None:
        """Return the answer; None when the process ended.

        Raises TimeoutError: no answer within `patience` seconds after the library was loaded; NotReady: not even that
        was done in time.
        """
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(json.dumps(question) + "\n")
            self.process.stdin.flush()
        except OSError:
            return None
        ready = self._line(timed.START_LIMIT)
        if ready is None:
            raise NotReady(f"not ready after {timed.START_LIMIT:g} s")
        line = self._line(patience) if ready else ""
        if line is None:
            raise TimeoutError
        answer: _Answer | None = json.loads(line) if line else None
        return answer

    def _line(self, patience: float) -> str | None:
        """Return the next line, an empty one when the process ended, None when nothing came in time."""
        try:
            return self.answers.get(timeout=patience)
        except queue.Empty:
            return None

    def end(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()


def close() -> None:
    """End the reading process, if there is one."""
    with _lock:
        _end_locked()


def _end_locked() -> None:
    global _reader
    if _reader is not None:
        _reader.end()
        _reader = None


atexit.register(close)


def read_guarded(file: Path, kind: str, patience: float | None = None) -> RawTable:
    """Read a file of one of the kinds of `readers.formats` in the reading process.

    Raises InputError: what the reader says; or it took too long, too much memory, or crashed; or it did not even start.
    """
    global _reader
    limit = PATIENCE + file.stat().st_size / BYTES_PER_SECOND if patience is None else patience
    with _lock, tempfile.TemporaryDirectory(prefix="tribofmu-read-") as folder:
        if _reader is None or _reader.process.poll() is not None:
            _reader = _Process()
        try:
            answer = _reader.ask({"file": str(file), "kind": kind, "folder": folder}, limit)
        except TimeoutError:
            _end_locked()
            raise InputError(
                f"{file}: reading it as {kind} takes longer than {limit:.0f} s; the file looks damaged"
            ) from None
        except NotReady as late:
            _end_locked()
            raise InputError(
                f"{file}: the process that is to read it as {kind} is {late}; allowed: a machine with less other work"
            ) from None
        except BaseException:
            # An interrupt leaves an answer on its way: the next file must not get it.
            _end_locked()
            raise
        if answer is None:
            _end_locked()
            raise InputError(f"{file}: the {kind} library crashed on it; the file looks damaged")
        if "error" in answer:
            raise InputError(str(answer["error"]))
        return _load(Path(folder), answer, str(file))


def _load(folder: Path, answer: _Answer, where: str) -> RawTable:
    columns = {
        name: np.load(folder / f"{number}.npy", allow_pickle=False)
        for number, name in enumerate(answer["names"])
    }
    return RawTable(pd.DataFrame(columns), answer["units"], where, answer["format"], tuple(answer["notes"]))
