"""Runs foreign machine code in a separate process, so that a crash does not end this program.

Requests are pickled. Answers are not: they come from a process whose memory may be damaged, so they are JSON or plain numbers
behind a mark of that process. Whatever else it sends ends it.
"""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import secrets
import signal
import socket
import struct
import sys
from collections.abc import Callable, Mapping
from multiprocessing import current_process, forkserver, get_context, resource_tracker
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.common.processes.child_processes import safe_start
from friction_models.common.processes.pool import detached_main, follow_parent, one_thread

#: How often a silent process is looked at whether it still lives [s], and how long one may take to end, or be silent in
#: the middle of an answer [s].
_LOOK, PATIENCE = 0.5, 5.0
#: Bytes of the mark before every answer, and of the longest answer (a hundred million numbers).
_MARK, _LONGEST = 16, 1 << 30
#: Kinds of answers: numbers, JSON, an error. Eight bytes, so that numbers stay aligned.
_NUMBERS, _JSON, _ERROR = b"numbers ", b"json    ", b"error   "
_SIGNALS = {
    "SIGSEGV": "its machine code reached for memory that is not its own",
    "SIGBUS": "its machine code reached for memory that does not exist",
    "SIGILL": "its machine code holds an instruction that this processor does not know",
    "SIGFPE": "its machine code made an arithmetic error",
    "SIGABRT": "its machine code gave up",
    "SIGKILL": "it was killed, most often for want of memory",
}
#: What the server imports once, so that the processes start at once; a name, as not all of it may be imported here.
_PRELOADED = ["fmus.runtime.evaluation", "fmus.runtime.isolated"]


class Died(RuntimeError):
    """The process ended; the message says how."""


class Apart:
    """An object that lives in a process of its own, where `make`, an importable function, makes it from `arguments`.

    Its methods may raise `errors`, which are raised here as they are; others become `RuntimeError`. `waiting` is called every
    now and then while an answer is awaited; what it raises ends the process.
    """

    def __init__(
        self,
        make: Callable[..., Any],
        *arguments: Any,
        errors: tuple[type[Exception], ...] = (),
        waiting: Callable[[], None] | None = None,
    ) -> None:
        allowed: tuple[type[Exception], ...] = (InputError, *errors)
        self._errors = {error.__name__: error for error in allowed}
        self._end = ""
        self.waiting = waiting
        if current_process().daemon:
            raise InputError(
                "an FMU that was not made here runs in a process of its own, which a worker of a multiprocessing pool may "
                "not start; allowed: isolate=False or TRIBOFMU_ISOLATE=0 where you trust it, or concurrent.futures"
            )
        context = get_context("spawn" if sys.platform == "win32" else "forkserver")
        if sys.platform != "win32":
            context.set_forkserver_preload(_PRELOADED)
        self._line, there = context.Pipe()
        ears, self._stop = context.Pipe(duplex=False)
        _bound_waiting(self._line)
        self._mark = secrets.token_bytes(_MARK)
        given = (there, ears, self._mark, dict(os.environ), make, arguments)
        self._process = context.Process(target=_serve, args=given, daemon=True)  # type: ignore[attr-defined]
        with safe_start(), detached_main(), one_thread():
            self._process.start()
        there.close()
        ears.close()

    def call(self, method: str, *arguments: Any) -> Any:
        """Call a method of the object; it may return nothing, an array of float64, or what JSON holds.

        Raises Died: the process is gone.
        """
        if self._end:
            raise Died(self._end)
        try:
            self._line.send_bytes(pickle.dumps((method, arguments), pickle.HIGHEST_PROTOCOL))
            while not self._line.poll(_LOOK):
                if not self._process.is_alive() and not self._line.poll(0):
                    raise EOFError
                if self.waiting is not None:
                    self.waiting()
            answer = self._line.recv_bytes(_LONGEST)
            if not answer.startswith(self._mark):
                raise OSError("no answer")
        except (EOFError, OSError) as error:
            self._end = self._how(PATIENCE if isinstance(error, EOFError | ConnectionError) else _LOOK)
            self._let_go()
            raise Died(self._end) from None
        except BaseException:  # an interrupt: the answer that is still to come belongs to nothing
            self._end = "its process was ended"
            self._let_go()
            raise
        kind, content = answer[_MARK : _MARK + 8], answer[_MARK + 8 :]
        if kind == _NUMBERS:
            return np.frombuffer(content)
        found = json.loads(content)
        if kind == _ERROR:
            raise self._errors.get(found[0], RuntimeError)(found[1])
        return found

    def _how(self, patience: float) -> str:
        self._process.join(patience)
        code = self._process.exitcode
        if code is None:
            return "its machine code wrote into files that are not its own, or closed them; its process was ended"
        if code < 0:
            with contextlib.suppress(ValueError):
                name = signal.Signals(-code).name
                return f"its process was ended by {name} ({_SIGNALS.get(name, 'a signal')})"
        return f"its process ended with exit code {code}"

    def _let_go(self) -> None:
        self._process.kill()
        self._process.join(PATIENCE)
        self._line.close()
        self._stop.close()

    def close(self) -> None:
        """End the process; the object is closed there, where it has a method for that."""
        if self._end:
            return
        self._end = "its process was closed"
        with contextlib.suppress(OSError, EOFError):
            self._line.send_bytes(b"")
            self._process.join(PATIENCE)
        self._let_go()

    def __del__(self) -> None:
        with contextlib.suppress(Exception):  # at the end of the program half of what is needed may be gone
            self.close()


def _bound_waiting(line: Connection) -> None:
    """Let a message that stops in the middle be an error: its length may be anything that was written into the line."""
    if sys.platform == "win32":  # pipes keep messages apart there
        return
    with socket.socket(fileno=os.dup(line.fileno())) as same:
        same.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", int(PATIENCE), 0))


def _let_go_of_servers() -> None:
    """Take the lines to the servers of `multiprocessing` from this process: what is written into them ends the servers.

    They lead nowhere from here on, and stay open, so that the numbers stay in use.
    """
    if sys.platform == "win32":
        return
    alive = getattr(forkserver._forkserver, "_forkserver_alive_fd", None)  # type: ignore[attr-defined]
    nowhere = os.open(os.devnull, os.O_RDWR)
    for line in (alive, resource_tracker.getfd()):
        if line is not None:
            os.dup2(nowhere, line, inheritable=False)
    os.close(nowhere)


def _serve(
    line: Connection,
    ears: Connection,
    mark: bytes,
    environment: Mapping[str, str],
    make: Callable[..., Any],
    arguments: tuple[Any, ...],
) -> None:
    """Make the object and call its methods until the line is closed."""
    follow_parent(ears)
    _let_go_of_servers()
    for name in set(os.environ) - set(environment):
        del os.environ[name]
    os.environ.update(environment)
    made: Any = None
    while True:
        try:
            request = line.recv_bytes()
        except (EOFError, OSError):
            return
        if not request:
            break
        method, given = pickle.loads(request)  # noqa: S301 - from the process that started this one
        try:
            made = made if made is not None else make(*arguments)
            result = getattr(made, method)(*given)
        except Exception as error:
            text = str(error) or type(error).__name__
            line.send_bytes(mark + _ERROR + json.dumps([type(error).__name__, text]).encode())
            continue
        if isinstance(result, np.ndarray):
            line.send_bytes(mark + _NUMBERS + np.ascontiguousarray(result, dtype=np.float64).tobytes())
        else:
            line.send_bytes(mark + _JSON + json.dumps(result).encode())
    if hasattr(made, "close"):
        with contextlib.suppress(Exception):
            made.close()
