"""Processes for runs and tests that are independent of each other."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
import types
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar

from ..errors import InputError
from .child_processes import environment, safe_start

Result = TypeVar("Result")
#: Called with (done, total, what was done last).
Progress = Callable[[int, int, str], None]


def default_jobs() -> int:
    """Return the number of cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return max(1, os.cpu_count() or 1)


def process_count(jobs: int | None) -> int:
    """Return how many processes `jobs` asks for; all cores for None.

    Raises InputError: less than one.

    Examples
    --------
    >>> process_count(3), process_count(None) >= 1
    (3, True)
    >>> process_count(0)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: jobs = 0; allowed: at least 1 process
    """
    if jobs is not None and jobs < 1:
        raise InputError(f"jobs = {jobs}; allowed: at least 1 process")
    return jobs or default_jobs()


class Workers:
    """Spawned processes that take calls; they end with `close`, and when the process that started them dies.

    At most `count` of them start, when calls come.
    """

    def __init__(self, count: int) -> None:
        self._ears, self._stop = get_context("spawn").Pipe(duplex=False)
        with safe_start():  # of the process that looks after semaphores
            self._pool = ProcessPoolExecutor(
                count, mp_context=get_context("spawn"), initializer=_begin, initargs=(self._ears,)
            )

    def submit(self, function: Callable[..., Result], *arguments: Any) -> Future[Result]:
        """Call an importable function in one of the processes; to be used from the main thread."""
        with safe_start(), detached_main(), one_thread():
            return self._pool.submit(function, *arguments)

    def close(self, now: bool = False) -> None:
        """End the processes, after the calls that are in hand or `now`."""
        if now:
            self._stop.close()
        self._pool.shutdown(wait=True, cancel_futures=now)
        self._stop.close()
        self._ears.close()


def map_unordered(
    function: Callable[..., Result], items: Sequence[tuple[Any, ...]], jobs: int | None = None
) -> Iterator[tuple[int, Result]]:
    """Call ``function(*item)`` for every item; yield (index, result) as they are ready.

    One job runs in this process. More run in spawned processes, so `function` must be importable. An
    error or an interrupt ends the pool and is raised here.

    Raises InputError: less than one job.

    Examples
    --------
    >>> sorted(map_unordered(pow, [(2, 3), (3, 2)], jobs=1))
    [(0, 8), (1, 9)]
    """
    jobs = min(process_count(jobs), len(items))
    if jobs <= 1:
        for index, item in enumerate(items):
            yield index, function(*item)
        return
    workers = Workers(jobs)
    try:
        futures = {workers.submit(function, *item): index for index, item in enumerate(items)}
        for future in as_completed(futures):
            yield futures[future], future.result()
    except BaseException:
        workers.close(now=True)
        raise
    workers.close()


def _begin(ears: Connection) -> None:
    """Prepare a process of `Workers`. Its end skips what libraries do when a program exits.

    The results are with the parent by then, and libraries that meet in one process, of co-simulations for example, now and then
    spoil the memory of each other as they end.
    """
    atexit.register(os._exit, 0)  # what is registered first comes last
    follow_parent(ears)


def follow_parent(ears: Connection) -> None:
    """Leave an interrupt from the keyboard to the parent; end when it says so or is gone, killed for example."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    ends: list[Any] = [ears] if parent is None else [ears, parent.sentinel]

    def listen() -> None:
        wait(ends)
        os._exit(1)

    threading.Thread(target=listen, daemon=True).start()


@contextmanager
def detached_main() -> Iterator[None]:
    """Hide the main module while processes start.

    A spawned process runs the main module again, which would start an unguarded script twice. The
    functions that run in the pool live in importable modules and do not need it.
    """
    main = sys.modules["__main__"]
    sys.modules["__main__"] = types.ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep linear algebra that starts now, here or in a new process, to one thread: processes are the parallelism.

    Examples
    --------
    >>> with one_thread():
    ...     os.environ["OMP_NUM_THREADS"]
    '1'
    """
    with environment(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1"):
        yield
