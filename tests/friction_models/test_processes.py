"""Processes that take calls end without what libraries do when a program exits."""

from __future__ import annotations

import ctypes
import os
import sys

import pytest

from friction_models.common.processes.pool import Workers


def spoil_the_end() -> int:
    """Let the C library abort this process as it exits, as a library does whose memory another one spoiled."""
    c = ctypes.CDLL(None)
    c.__cxa_atexit(c.abort, None, None)
    return os.getpid()


@pytest.mark.skipif(sys.platform != "linux", reason="the name of the function is that of glibc")
def test_a_library_that_fails_at_the_end_of_a_process_is_not_asked() -> None:
    workers = Workers(1)
    number = workers.submit(spoil_the_end).result()
    (process,) = workers._pool._processes.values()
    workers.close()
    assert process.pid == number and process.exitcode == 0
