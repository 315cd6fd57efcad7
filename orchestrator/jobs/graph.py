"""Jobs that need each other, run in parallel, each result kept under the hash of everything that decides it."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import replace
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from fmus.runtime.errors import SimulationError
from friction_models.common import InputError, check_folder, grown, unknown_name, write_json
from friction_models.common.cached_results import digest, path_digest
from friction_models.common.folders import STUDY
from friction_models.common.processes.pool import process_count

from .estimate import DryRun, TimeEstimate
from .executors import Cluster, Executor, ProcessExecutor, check_address
from .job import Failure, Job, Progress
from .keys import PACKAGES, deciding_code, stamp
from .store import JobResult, Store
from .work import JobCall

__all__ = ["DryRun", "Failure", "Job", "JobGraph", "JobResult"]

#: How often a job is started whose worker gets killed.
TRIES = 2


class JobGraph:
    """Jobs and the folder of their results.

    A result lies in ``jobs/<hash>`` of the folder. The hash covers function, inputs, file contents, the hashes of the
    needed jobs, versions and sources. So a second run computes only what changed, and a killed one continues. `code` are
    packages and modules whose sources count besides those that follow from the function of a job (`deciding_code`).

    `failed` are the jobs of the last `run` without a result, by name; ``failed.json`` in the folder holds them with their
    inputs.

    Raises InputError: two jobs of one name, an unknown need, needs in a circle, inputs that JSON does not hold.

    Examples
    --------
    >>> jobs = [Job(name, "json:dumps", {"seed": 1}) for name in ("first", "second")]
    >>> print(JobGraph(Path("no-such-study"), jobs, code=()).dry_run(jobs=1).report())
    2 jobs: 0 kept, 1 to do, 1 the same as others, about 1 s on 1 processes of this machine
    """

    def __init__(self, folder: Path, jobs: Iterable[Job], code: Sequence[str] = PACKAGES) -> None:
        self.folder = Path(folder)
        self.store = Store(self.folder / "jobs")
        self.jobs: dict[str, Job] = {}
        for job in jobs:
            if job.name in self.jobs:
                raise InputError(f"two jobs are called {job.name!r}; allowed: each name once")
            self.jobs[job.name] = job
        self.code = tuple(code)
        self.failed: dict[str, Failure] = {}
        # The sources as they are now: they may change before the next graph.
        self._deciding_code, self._stamp = cache(deciding_code), cache(stamp)
        self.keys = self._keys(self._sorted())

    def run(
        self, jobs: int | None = None, scheduler: str | None = None, progress: Progress | None = None
    ) -> dict[str, JobResult]:
        """Run the jobs without a kept result; return all results by name. `failed` holds the jobs without one.

        `jobs` are processes, all cores by default; one job at a time runs in this process. `scheduler` is the address of
        a dask.distributed scheduler, ``tcp://host:port``, whose workers see the folder under the same path.

        Raises InputError: the folder holds something else, another run is at work in it, less than one process, a
        scheduler that does not answer.
        """
        if scheduler is not None:
            check_address(scheduler)
        self.failed = {}
        grown(self.folder, STUDY)
        with self.store.opened() as work:
            results = self._kept()
            todo = [name for name in self.jobs if name not in results]
            if todo:
                count = min(process_count(jobs), len({self.keys[n] for n in todo}))
                executor: Executor
                if scheduler is not None:
                    executor = Cluster(scheduler)
                else:
                    executor = Executor() if count == 1 else ProcessExecutor(count)
                with executor:
                    self._work(executor, work, todo, results, progress or (lambda done, total, what: None))
            elif progress is not None:
                progress(len(self.jobs), len(self.jobs), "all kept from before")
            if self.failed:
                write_json(self.folder / "failed.json", [f.to_dict() for f in self.failed.values()])
            else:
                (self.folder / "failed.json").unlink(missing_ok=True)
        return {name: results[name] for name in self.jobs if name in results}

    def dry_run(self, jobs: int | None = None, scheduler: str | None = None) -> DryRun:
        """Count the jobs (all, kept, to do) and estimate the time, from kept results where there are any.

        `jobs` and `scheduler` are as for `run`; a cluster counts with the workers that it has now.
        """
        check_folder(self.folder, STUDY)
        kept = self._kept()
        clock = TimeEstimate(self.jobs.values(), kept)
        count = process_count(jobs)
        if scheduler is not None:
            with Cluster(scheduler) as executor:
                count = executor.workers
        todo = [names[0] for names in self._twins(name for name in self.jobs if name not in kept)]
        return DryRun(
            len(self.jobs), len(kept), len(todo), clock.left(todo, count), count, scheduler is not None
        )

    def check(self) -> None:
        """Raise a `SimulationError` that names the first failures, if a job of the last run failed."""
        if not self.failed:
            return
        own = [f for f in self.failed.values() if not f.error.startswith(_NOT_RUN)]
        shown = "; ".join(f"{f.job.name}: {f.error[:300]}" for f in own[:3])
        more = f" (and {len(own) - 3} more)" if len(own) > 3 else ""
        waiting = len(self.failed) - len(own)
        blocked = f", {waiting} that need them were not run" if waiting else ""
        raise SimulationError(
            f"{len(own)} of {len(self.jobs)} jobs failed{blocked}: {shown}{more}; inputs in {self.folder / 'failed.json'}"
        )

    def manifest(
        self,
        results: Mapping[str, JobResult],
        settings: Mapping[str, object] | None = None,
        seeds: Mapping[str, int] | None = None,
    ) -> dict[str, object]:
        """Return versions, seeds and hashes; equal manifests mean equal numbers.

        `results` are what `run` returned; `settings` and `seeds` those of the study.
        """
        values = {n: {k: v for k, v in r.values.items() if k != "timing"} for n, r in results.items()}
        code = tuple(
            dict.fromkeys([*self.code, *(n for job in self.jobs.values() for n in self._code_of(job))])
        )
        mark = self._stamp(code)
        return {
            "settings": dict(settings or {}),
            "seeds": dict(seeds or {}),
            "versions": mark["versions"],
            "sources": {"packages": list(code), "sha256": mark["code"]},
            "platform": platform.platform(terse=True),
            "jobs": {n: {"job": self.keys[n], "values": digest(v)} for n, v in values.items()},
            "failed": sorted(self.failed),
        }

    # --- the plan ---------------------------------------------------------------------------------

    def _sorted(self) -> list[str]:
        """Return the names so that every job comes after those it needs."""
        for job in self.jobs.values():
            for need in job.needs:
                if need not in self.jobs:
                    raise unknown_name("job", need, self.jobs, f"jobs: needs of {job.name}")
        try:
            return list(TopologicalSorter({n: j.needs for n, j in self.jobs.items()}).static_order())
        except CycleError as error:
            circle = " -> ".join(error.args[1])
            raise InputError(f"jobs need each other ({circle}); allowed: needs without a circle") from None

    def _code_of(self, job: Job) -> tuple[str, ...]:
        module = job.function.partition(":")[0]
        return tuple(dict.fromkeys((*self.code, *self._deciding_code(module))))

    def _keys(self, order: Sequence[str]) -> dict[str, str]:
        keys: dict[str, str] = {}
        digest_of = cache(path_digest)
        for name in order:
            job = self.jobs[name]
            content = {
                "function": job.function,
                "inputs": job.inputs,
                "files": {n: digest_of(p) for n, p in job.files.items()},
                "needs": {n: keys[n] for n in job.needs},
                **self._stamp(self._code_of(job)),
            }
            try:
                keys[name] = digest(content)[:40]
            except (TypeError, ValueError) as error:
                raise InputError(
                    f"jobs: inputs of {name}: {error}; allowed: numbers, texts, lists and dicts"
                ) from None
        return keys

    def _kept(self) -> dict[str, JobResult]:
        found = {name: self.store.load(key, name) for name, key in self.keys.items()}
        return {name: result for name, result in found.items() if result is not None}

    def _twins(self, names: Iterable[str]) -> list[list[str]]:
        """Return the names in groups of one result."""
        groups: dict[str, list[str]] = {}
        for name in names:
            groups.setdefault(self.keys[name], []).append(name)
        return list(groups.values())

    # --- the work ---------------------------------------------------------------------------------

    def _work(
        self,
        executor: Executor,
        work: Path,
        todo: Sequence[str],
        results: dict[str, JobResult],
        progress: Progress,
    ) -> None:
        twins = {names[0]: names for names in self._twins(todo)}
        waiting = list(twins)
        running: dict[Future[dict[str, str]], str] = {}
        tries = dict.fromkeys(waiting, 0)
        clock = TimeEstimate(self.jobs.values(), results)

        def tell(what: str) -> None:
            done = len(results) + len(self.failed)
            rest = [*waiting, *running.values()]
            left = clock.text(rest, executor.workers) if rest else ""
            progress(done, len(self.jobs), f"{what}{', ' if what and left else ''}{left}")

        tell("")
        while waiting or running:
            for name in list(waiting):
                job = self.jobs[name]
                missing = [need for need in job.needs if need in self.failed]
                if missing:
                    waiting.remove(name)
                    self._fail(twins[name], f"{_NOT_RUN} {', '.join(missing)} failed")
                elif len(running) < executor.capacity and all(need in results for need in job.needs):
                    waiting.remove(name)
                    tries[name] += 1
                    running[executor.submit(self._call(job, work))] = name
            if not running:
                continue
            finished, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in finished:
                name = running.pop(future)
                names = twins[name]
                if future.cancelled():
                    raise SimulationError(
                        "the scheduler is gone; finished jobs are kept, start the study again"
                    )
                error = future.exception()
                if error is not None and executor.died(error):
                    if tries[name] < TRIES:
                        waiting.insert(0, name)
                    else:
                        self._fail(names, f"its worker was killed {tries[name]} times (out of memory?)")
                elif error is not None:
                    self._fail(names, f"{type(error).__name__}: {error}")
                elif outcome := future.result():
                    self._fail(names, outcome["error"], outcome["traceback"])
                else:
                    for twin in names:
                        if result := self.store.load(self.keys[twin], twin):
                            results[twin] = result
                        else:
                            shared = "is the folder shared by all workers?"
                            self._fail([twin], f"its result is not in {self.store.folder}; {shared}")
                    if name in results:
                        clock.add(self.jobs[name], results[name].seconds)
                tell(name)

    def _call(self, job: Job, work: Path) -> JobCall:
        code = self._code_of(job)
        given = replace(job, files={n: p.resolve() for n, p in job.files.items()})
        needs = {n: self.keys[n] for n in job.needs}
        return JobCall(
            given, self.keys[job.name], needs, str(self.store.folder), str(work), code, self._stamp(code)
        )

    def _fail(self, names: Iterable[str], error: str, trace: str = "") -> None:
        for name in names:
            self.failed[name] = Failure(self.jobs[name], error, trace)


_NOT_RUN = "not run, because"
