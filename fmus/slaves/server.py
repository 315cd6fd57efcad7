"""Solver process behind the native front of a solver FMU.

The front starts an interpreter, which calls `main` with what it was told: the descriptor of the connection
(POSIX) or a handle (Windows). Standard output goes to standard error, which the front reads for its
messages: nothing that a library prints can get into the connection. The process ends when the front has
gone, also in the middle of a step.
"""

from __future__ import annotations

import contextlib
import faulthandler
import importlib
import json
import os
import select
import signal
import struct
import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from . import protocol
from .core import Solver
from .protocol import Channel

#: What a front may ask for: module and class beside this file.
SOLVERS = {"forming": ("forming_solver", "FormingSolver"), "twin": ("twin_solver", "TwinSolver")}
#: Most states that a front may keep.
MOST_STATES = 10_000


class Server:
    """Answers requests about one solver."""

    def __init__(self, channel: Channel) -> None:
        self.channel = channel
        self.solver: Solver | None = None
        self.states: dict[int, Any] = {}
        self.next_state = 1
        self.answers: dict[int, Callable[[bytes], bytes]] = {
            protocol.HELLO: self.hello,
            protocol.CONFIGURE: self.configure,
            protocol.START: self.start,
            protocol.STEP: self.step,
            protocol.SAVE: self.save,
            protocol.RESTORE: self.restore,
            protocol.FREE: self.free,
            protocol.SERIALIZE: self.serialize,
            protocol.DESERIALIZE: self.deserialize,
            protocol.REMARKS: self.remarks,
        }

    def run(self) -> None:
        """Answer until the front says so or has gone."""
        while True:
            request = self.channel.read()
            if request is None or request[0] == protocol.QUIT:
                return
            status, content = self.answer(request[0], request[1:])
            self.channel.write(status, content)

    def answer(self, code: int, content: bytes) -> tuple[int, bytes]:
        """Return status and content of the reply."""
        try:
            if code not in self.answers:
                raise ValueError(f"request {code} is not known to version {protocol.VERSION} of the protocol")
            return protocol.OK, self.answers[code](content)
        except (InputError, ArithmeticError, RuntimeError) as error:
            # A step that the solver refuses can be tried again, shorter or with other inputs.
            status = protocol.DISCARD if code == protocol.STEP else protocol.ERROR
            return status, str(error).encode()
        except ModuleNotFoundError as error:
            text = f"the Python environment {sys.executable} lacks {error.name}; install it: pip install tribofmu"
            return protocol.ERROR, text.encode()
        except Exception as error:
            traceback.print_exc()
            return protocol.ERROR, f"{type(error).__name__}: {error}".encode()

    def hello(self, content: bytes) -> bytes:
        if content[:4] != protocol.MAGIC:
            raise ValueError("the first message is not one of a solver FMU")
        package = protocol.package_version() or "of unknown version"
        return protocol.MAGIC + struct.pack("<I", protocol.VERSION) + package.encode()

    def configure(self, content: bytes) -> bytes:
        length = content[0]
        name = content[1 : 1 + length].decode()
        if name not in SOLVERS:
            raise InputError(f"solver {name!r}, allowed: {', '.join(sorted(SOLVERS))}")
        module, kind = SOLVERS[name]
        solver_type = getattr(importlib.import_module(f"fmus.slaves.{module}"), kind)
        self.solver = solver_type(json.loads(content[1 + length :]))
        return b""

    def start(self, content: bytes) -> bytes:
        solver = self._configured()
        solver.values[solver.first_input :] = _numbers(content, len(solver.values) - solver.first_input)
        solver.launch()
        return self._published()

    def step(self, content: bytes) -> bytes:
        solver = self._configured()
        numbers = _numbers(content, 2 + solver.first_parameter - solver.first_input)
        solver.inputs()[:] = numbers[2:]
        solver.advance(float(numbers[0]), float(numbers[1]))
        return self._published()

    def save(self, _: bytes) -> bytes:
        return self._keep(self._configured().save())

    def _keep(self, state: Any) -> bytes:
        if len(self.states) >= MOST_STATES:
            raise InputError(f"{len(self.states)} states are kept, allowed: at most {MOST_STATES}; free some")
        number, self.next_state = self.next_state, self.next_state + 1
        self.states[number] = state
        return struct.pack("<Q", number)

    def restore(self, content: bytes) -> bytes:
        self._configured().restore(self.states[self._state(content)])
        return b""

    def free(self, content: bytes) -> bytes:
        del self.states[self._state(content)]
        return b""

    def serialize(self, content: bytes) -> bytes:
        state = self.states[self._state(content[:8])]
        return self._configured().to_bytes(state, [content[8:].hex()])

    def deserialize(self, content: bytes) -> bytes:
        state, more = self._configured().from_bytes(content)
        if len(more) != 1 or not isinstance(more[0], str):
            raise InputError("the serialized state is one of the Python form of this FMU")
        return self._keep(state) + bytes.fromhex(more[0])

    def remarks(self, _: bytes) -> bytes:
        return "\n".join(self._configured().remarks()).encode()

    def _configured(self) -> Solver:
        if self.solver is None:
            raise ValueError("no solver is configured")
        return self.solver

    def _state(self, content: bytes) -> int:
        (number,) = struct.unpack("<Q", content)
        if number not in self.states:
            raise ValueError(f"there is no state {number}")
        return int(number)

    def _published(self) -> bytes:
        solver = self._configured()
        outputs = solver.values[: solver.first_input]
        return outputs.astype("<f8").tobytes() + solver.flags.astype(np.uint8).tobytes()


def _numbers(content: bytes, count: int) -> FloatArray:
    if len(content) != 8 * count:
        raise ValueError(f"{len(content)} bytes of numbers, allowed: {8 * count}")
    return np.frombuffer(content, dtype="<f8").astype(np.float64)


def main(connection: str) -> None:
    """Serve one front; `connection` is ``fd:3``, the number of a descriptor, or ``handle:123``, that of a Windows handle."""
    kind, _, number = connection.partition(":")
    descriptor = _from_handle(int(number)) if kind == "handle" else int(number)
    os.set_inheritable(descriptor, False)
    if kind == "fd":
        _close_others(descriptor)
        threading.Thread(target=_watch, args=(descriptor, os.getppid()), daemon=True).start()
    sys.stdout.flush()
    os.dup2(2, 1)
    if hasattr(sys.stderr, "reconfigure"):
        sys.stderr.reconfigure(encoding="utf-8", errors="backslashreplace", line_buffering=True)
    sys.stdout = sys.stderr
    faulthandler.enable()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt at the terminal is the simulator's affair
    with contextlib.suppress(OSError):
        Server(Channel(descriptor)).run()
    # No clean-up of the interpreter: nothing is left to be written, and the simulator waits for the end.
    os._exit(0)


def _from_handle(handle: int) -> int:
    if sys.platform != "win32":
        raise InputError("a handle is the connection on Windows only")
    import msvcrt

    return msvcrt.open_osfhandle(handle, os.O_RDWR | os.O_BINARY)


def _close_others(descriptor: int) -> None:
    """Close what the simulator left open for its child: files and connections that are none of ours."""
    with contextlib.suppress(OSError):
        for name in os.listdir("/dev/fd"):
            if int(name) > 2 and int(name) != descriptor:
                with contextlib.suppress(OSError):
                    os.close(int(name))


def _watch(descriptor: int, parent: int) -> None:
    """End the process when the front has gone; between two messages `Channel.read` sees it, too."""
    poller = select.poll()
    poller.register(descriptor, 0)  # no events but the end of the connection
    while os.getppid() == parent:
        try:
            ended = poller.poll(1000)
        except OSError:
            ended = []
        if ended:
            os._exit(0)
    os._exit(0)
