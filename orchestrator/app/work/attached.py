"""A command that ends with the server that started it, also when that was killed: it goes on from there later."""

from __future__ import annotations

import _thread
import importlib
import os
import signal
import sys
import threading
import time

#: How long an interrupted command may tidy up before it is killed [s].
GRACE = 8.0


def main() -> None:
    """Run ``main()`` of the module that is the first argument; standard input is a pipe that the server holds open as long as it lives."""
    module = sys.argv.pop(1)
    pipe = os.dup(0)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    threading.Thread(target=_watch, args=(pipe,), daemon=True, name="server").start()
    importlib.import_module(module).main()


def _watch(pipe: int) -> None:
    while os.read(pipe, 1024):
        pass
    if sys.platform == "win32":
        _thread.interrupt_main()
        time.sleep(GRACE)
        os._exit(130)
    # The command has a group of processes of its own.
    os.killpg(0, signal.SIGINT)
    time.sleep(GRACE)
    os.killpg(0, signal.SIGKILL)
