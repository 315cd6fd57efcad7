"""A child process whose time limit begins when it says that it is ready, not while Python and libraries load.

On a busy machine, or from a slow network drive, loading alone takes longer than the work is allowed to.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Sequence

#: Longest time that a child may take before it is ready [s]: it runs our code and libraries alone until then.
START_LIMIT = 900.0


class NotReady(RuntimeError):
    """A child did not get ready; the message says how long was waited."""


def run_timed(command: Sequence[str], limit: float) -> int:
    """Run a child that calls `say_ready`; return its exit code, also where it ended before it was ready.

    It is ended with NotReady where it is not ready within `START_LIMIT`, and with TimeoutError where it does not end within
    `limit` seconds from then on.
    """
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as process:
        try:
            assert process.stdout is not None
            # A pipe cannot be waited for with a limit on every system; a thread can.
            listener = threading.Thread(target=process.stdout.readline, daemon=True)
            listener.start()
            listener.join(START_LIMIT)
            if listener.is_alive():
                raise NotReady(f"not ready after {START_LIMIT:g} s")
            return process.wait(limit)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"not at its end after {limit:g} s") from None
        finally:
            # Also after an interrupt.
            if process.poll() is None:
                process.kill()
                process.wait()


def say_ready() -> None:
    """Tell the process that started this one by `run_timed` that everything is loaded; what is printed later is dropped."""
    out = sys.stdout.fileno()
    os.write(out, b"ready\n")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, out)
    os.close(nowhere)
