"""Execution of one job in a worker process. Its result folder is complete before it gets its final name."""

from __future__ import annotations

import importlib
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from friction_models.common import InputError
from friction_models.common.processes.pool import one_thread

from .job import Job
from .keys import Stamp, stamp
from .store import JobResult, Store


@dataclass(frozen=True)
class JobCall:
    """A job as a worker receives it."""

    job: Job  # with absolute paths
    key: str
    needs: dict[str, str]  # hashes of the jobs it needs by name
    store: str  # folder of the results
    work: str  # folder in it that is there while the jobs run
    code: tuple[str, ...]  # packages whose sources count
    stamp: Stamp  # of the one who asks


_my_stamp = cache(stamp)


def execute(call: JobCall) -> dict[str, str]:
    """Do a job; return nothing, or ``error`` and ``traceback``: not every exception survives a pickle."""
    try:
        _do(call)
    except InputError as error:
        return {"error": str(error), "traceback": ""}
    except Exception as error:
        text = " ".join(str(error).split())
        return {"error": f"{type(error).__name__}: {text}", "traceback": traceback.format_exc()}
    return {}


def resolve(function: str) -> Any:
    """Return the function behind ``package.module:function``.

    Examples
    --------
    >>> resolve("math:sqrt")(4.0)
    2.0
    >>> resolve("math:no_such_function")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: math:no_such_function: no such function ...
    """
    module, _, name = function.partition(":")
    try:
        found = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(
            f"{function}: no such function ({error}); allowed: package.module:function"
        ) from None
    return found


def _do(call: JobCall) -> None:
    _check(call)
    store = Store(Path(call.store))
    needs: dict[str, JobResult] = {}
    for name, key in call.needs.items():
        result = store.load(key, name)
        if result is None:
            raise InputError(
                f"{store.folder / key}: the result of {name} is not there; was it removed meanwhile?"
            )
        needs[name] = result
    # Beside the place of the result, so that relative paths in its files hold after the renaming.
    work = Path(tempfile.mkdtemp(prefix=f"{Path(call.work).name}-{call.key[:12]}-", dir=store.folder))
    work.chmod(0o755)
    job = call.job
    function = resolve(job.function)
    with _alone():
        began = time.perf_counter()
        values = function(job.inputs, job.files, needs, work)
        seconds = time.perf_counter() - began
    content = {
        "name": job.name,
        "function": job.function,
        "inputs": job.inputs,
        "needs": call.needs,
        **call.stamp,
        "seconds": round(seconds, 6),
        "values": values,
    }
    store.keep(call.key, work, content)


def _check(call: JobCall) -> None:
    """Refuse to compute with other sources than the hash says, or without the shared folder."""
    if not Path(call.work).is_dir():
        raise InputError(
            f"{call.store}: not seen by this worker; workers need the folder of the study under the same path"
        )
    mine = _my_stamp(call.code)
    if mine == call.stamp:
        return
    theirs = call.stamp["versions"]
    differ = [f"{n} {v} (asked: {theirs.get(n)})" for n, v in mine["versions"].items() if theirs.get(n) != v]
    what = ", ".join(differ) or "the sources"
    raise InputError(
        f"this worker differs from the study in {what}; start worker and study anew with the same installation"
    )


@contextmanager
def _alone() -> Iterator[None]:
    """One thread for linear algebra: numbers must not depend on where a job runs."""
    from threadpoolctl import threadpool_limits

    torch = sys.modules.get("torch")
    threads = None if torch is None else torch.get_num_threads()
    try:
        if torch is not None:
            torch.set_num_threads(1)
        with one_thread(), threadpool_limits(1):
            yield
    finally:
        if torch is not None:
            torch.set_num_threads(threads)
