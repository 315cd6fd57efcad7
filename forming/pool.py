"""A pool of processes for runs and tests that are independent of each other."""

from __future__ import annotations

import os
import signal
import sys
import types
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any, TypeVar

from friction_models.loads import InputError

Result = TypeVar("Result")
#: Called with (done, total, what was done last).
Progress = Callable[[int, int, str], None]


def default_jobs() -> int:
    """Return the number of cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return max(1, os.cpu_count() or 1)


def map_unordered(
    function: Callable[..., Result], items: Sequence[tuple[Any, ...]], jobs: int | None = None
) -> Iterator[tuple[int, Result]]:
    """Call ``function(*item)`` for every item; yield (index, result) as they are ready.

    One job runs in this process. More run in spawned processes, so `function` must be importable. An
    error or an interrupt ends the pool and is raised here.

    Raises
    ------
    InputError
        Less than one job.
    """
    if jobs is not None and jobs < 1:
        raise InputError(f"jobs = {jobs}; allowed: at least 1 process")
    jobs = min(jobs or default_jobs(), len(items))
    if jobs <= 1:
        for index, item in enumerate(items):
            yield index, function(*item)
        return
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_quiet)
    try:
        with _detached_main(), _one_thread():
            futures: dict[Future[Result], int] = {
                pool.submit(function, *item): index for index, item in enumerate(items)
            }
        for future in as_completed(futures):
            yield futures[future], future.result()
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def _quiet() -> None:
    """Leave an interrupt from the keyboard to the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _detached_main() -> Iterator[None]:
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
def _one_thread() -> Iterator[None]:
    """Processes are the parallelism: keep linear algebra in each of them to one thread."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
