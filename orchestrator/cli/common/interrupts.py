"""Ctrl-C, also where a library swallows it or reports it as an error of its own."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class _Noticed:
    """Whether there was an interrupt."""

    received = False


@contextmanager
def watched() -> Iterator[None]:
    """Notice interrupts in this block; they are raised as usual.

    One that hits where nothing can be raised, such as in a callback of the import system, is not printed: `received` tells of it.
    """
    _Noticed.received = False
    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN or threading.current_thread() is not threading.main_thread():
        yield  # a shell lets its background jobs ignore them
        return
    told = sys.unraisablehook
    signal.signal(signal.SIGINT, _notice)
    sys.unraisablehook = lambda lost: None if lost.exc_type is KeyboardInterrupt else told(lost)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        sys.unraisablehook = told
        # What runs later in this process was not interrupted.
        _Noticed.received = False


def _notice(number: int, frame: Any) -> None:
    _Noticed.received = True
    raise KeyboardInterrupt


def received() -> bool:
    """Return whether there was an interrupt in the block of `watched` that is running."""
    return _Noticed.received


def check() -> None:
    """Raise the interrupt that other code kept to itself."""
    if _Noticed.received:
        raise KeyboardInterrupt
