"""Ctrl-C during a co-simulation: the run stops between two steps, or soon where the FMU has a process of its own.

An interrupt that is raised wherever the program happens to be may be raised inside an FMU: in a function that it calls back,
where it is lost, or in the Python code of a Python FMU, which then fails for no reason of its own.
"""

from __future__ import annotations

import signal
import threading
import time
from types import FrameType
from typing import Any

#: How long a step in another process may go on after Ctrl-C [s].
GRACE = 2.0


class Interrupts:
    """Notes Ctrl-C inside a ``with`` block; a second one is raised at once, as it would be without the block."""

    def __init__(self) -> None:
        #: Whether there was one.
        self.asked = False
        self._since = 0.0
        self._before: Any = None

    def check(self) -> None:
        """Raise the interrupt that was noted, as `KeyboardInterrupt`."""
        if self.asked:
            raise KeyboardInterrupt

    def check_waiting(self) -> None:
        """Raise the interrupt when it was noted `GRACE` ago: the step in hand may never end."""
        if self.asked and time.monotonic() - self._since > GRACE:
            raise KeyboardInterrupt

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self.asked:
            self._before(number, frame)
        self.asked, self._since = True, time.monotonic()

    def __enter__(self) -> Interrupts:
        # Signals belong to the main thread; a process that ignores them (a worker) goes on doing so.
        if threading.current_thread() is threading.main_thread():
            before = signal.getsignal(signal.SIGINT)
            if callable(before):
                self._before = before
                signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, *error: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
