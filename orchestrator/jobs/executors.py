"""Executors of jobs: this process, several processes of this machine, or a dask.distributed cluster."""

from __future__ import annotations

import contextlib
import logging
import math
import time
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from types import TracebackType
from typing import Any, Self

from friction_models.common import InputError
from friction_models.common.processes.pool import Workers

from .work import JobCall, execute

Outcome = dict[str, str]
#: How long a cluster is waited for [s], and how often it is asked for its workers [s].
PATIENCE, ASK_AGAIN = 30.0, 5.0


class Executor:
    """Runs one job after the other in this process, and returns futures of their outcomes; others run several."""

    @property
    def workers(self) -> int:
        """Number of jobs that run at a time, for estimates."""
        return 1

    @property
    def capacity(self) -> int:
        """Number of jobs that may be submitted at a time."""
        return self.workers

    def submit(self, call: JobCall) -> Future[Outcome]:
        """Start a job."""
        future: Future[Outcome] = Future()
        future.set_result(execute(call))
        return future

    def died(self, error: BaseException) -> bool:
        """Whether the error says that the worker was killed, so that the job is worth another try."""
        return False

    def close(self, now: bool) -> None:
        """End; `now` gives up jobs that are still running."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(now=kind is not None)


class ProcessExecutor(Executor):
    """Processes of this machine. Each is a pool of its own, so that a killed one does not take the others with it."""

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._idle: list[Workers] = []
        self._busy: dict[Future[Outcome], Workers] = {}

    @property
    def workers(self) -> int:
        return self._jobs

    def submit(self, call: JobCall) -> Future[Outcome]:
        for future in [f for f in self._busy if f.done()]:
            worker = self._busy.pop(future)
            if future.exception() is None:
                self._idle.append(worker)
            else:
                worker.close()
        while True:
            worker = self._idle.pop() if self._idle else Workers(1)
            try:
                future = worker.submit(execute, call)
            except BrokenProcessPool:  # killed while it had nothing to do
                worker.close()
                continue
            self._busy[future] = worker
            return future

    def died(self, error: BaseException) -> bool:
        return isinstance(error, BrokenProcessPool)

    def close(self, now: bool) -> None:
        for worker in [*self._idle, *self._busy.values()]:
            worker.close(now)


def check_address(address: str) -> None:
    """Raise InputError for what is no address of a scheduler."""
    if not address.startswith(("tcp://", "tls://")):
        raise InputError(
            f"--scheduler {address}: not an address; allowed: tcp://HOST:PORT of a dask scheduler"
        )


class Cluster(Executor):
    """A dask.distributed cluster, which repeats the jobs of killed workers by itself; workers may join and leave.

    `address` is ``tcp://host:port`` or ``tls://host:port`` of its scheduler. Scheduler and first worker are waited for,
    at most `patience` seconds: the job script of a queue starts all at once.
    """

    def __init__(self, address: str, patience: float = PATIENCE) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise InputError(
                "--scheduler: the package distributed is missing; install it: pip install 'tribofmu[cluster]'"
            ) from None
        check_address(address)
        # What goes wrong is said in one sentence, not by tracebacks of the package beside it.
        for name in ("distributed", "distributed.client"):  # each has a level of its own
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            self._client: Any = Client(address, timeout=patience)
        except (OSError, ValueError, TimeoutError) as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(f"--scheduler {address}: no scheduler answers there ({reason})") from None
        try:
            self._client.wait_for_workers(1, timeout=patience)
        except TimeoutError:
            self._client.close()
            raise InputError(
                f"--scheduler {address}: it has no workers; start some: dask worker {address} --nthreads 1"
            ) from None
        self._executor = self._client.get_executor()
        self._workers, self._asked = 1, -math.inf

    @property
    def workers(self) -> int:
        now = time.monotonic()
        if now > self._asked + ASK_AGAIN:
            self._asked = now
            # With none left, dask keeps what it has for workers to come. A scheduler that is gone shows in the futures.
            with contextlib.suppress(OSError):
                self._workers = sum(self._client.ncores().values()) or 1
        return self._workers

    @property
    def capacity(self) -> int:
        # One waits at each worker, so that none is idle while the next job travels.
        return 2 * self.workers

    def submit(self, call: JobCall) -> Future[Outcome]:
        future: Future[Outcome] = self._executor.submit(execute, call)
        return future

    def close(self, now: bool) -> None:
        self._executor.shutdown(wait=not now)
        self._client.close()
