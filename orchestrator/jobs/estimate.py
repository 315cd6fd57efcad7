"""Estimate of the time that the jobs take, from the times of its finished jobs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from .job import Job
from .store import JobResult


@dataclass(frozen=True)
class DryRun:
    """What a run would do.

    Examples
    --------
    >>> DryRun(jobs=10, kept=4, to_do=6, seconds=250.0, processes=2).report()
    '10 jobs: 4 kept, 6 to do, about 4 min on 2 processes of this machine'
    """

    jobs: int  # all of them
    kept: int  # those whose result is there
    to_do: int  # computations; jobs that are the same count once
    seconds: float  # estimate of the time that takes
    processes: int  # that the estimate is for
    cluster: bool = False  # whether they are those of a cluster, now

    def report(self) -> str:
        """Return one line of text."""
        same = self.jobs - self.kept - self.to_do
        twins = f", {same} the same as others" if same else ""
        where = "the cluster" if self.cluster else "this machine"
        return (
            f"{self.jobs} jobs: {self.kept} kept, {self.to_do} to do{twins}, "
            f"about {duration(self.seconds)} on {self.processes} processes of {where}"
        )


class TimeEstimate:
    """Scales the expected times of jobs by what jobs of the same function took.

    `results` are those that are there already.

    Examples
    --------
    The first job took twice what was expected, so the second one probably will:

    >>> jobs = [Job(name, "json:dumps", seconds=10.0) for name in ("first", "second")]
    >>> estimate = TimeEstimate(jobs, {})
    >>> estimate.add(jobs[0], 20.0)
    >>> estimate.text(["second"], workers=1)
    'about 20 s left'
    """

    def __init__(self, jobs: Iterable[Job], results: Mapping[str, JobResult]) -> None:
        self._jobs = {job.name: job for job in jobs}
        self._taken: dict[str, tuple[float, float]] = {}
        for name, result in results.items():
            self.add(self._jobs[name], result.seconds)

    def add(self, job: Job, seconds: float) -> None:
        """Note what a job took."""
        taken, expected = self._taken.get(job.function, (0.0, 0.0))
        self._taken[job.function] = (taken + seconds, expected + job.seconds)

    def left(self, names: Sequence[str], workers: int) -> float:
        """Return the time for jobs in the given order on a number of workers [s], a little too short at best."""
        each = [self._expected(self._jobs[name]) for name in names]
        return max([sum(each) / max(workers, 1), *each], default=0.0)

    def text(self, names: Sequence[str], workers: int) -> str:
        """Return the time left for readers."""
        return f"about {duration(self.left(names, workers))} left"

    def _expected(self, job: Job) -> float:
        taken, expected = self._taken.get(job.function, (0.0, 0.0))
        if expected <= 0.0:
            taken = sum(t for t, _ in self._taken.values())
            expected = sum(e for _, e in self._taken.values())
        return job.seconds * (taken / expected if expected > 0.0 else 1.0)


def duration(seconds: float) -> str:
    """Return a time as text.

    Examples
    --------
    >>> duration(42.0), duration(600.0), duration(9000.0)
    ('42 s', '10 min', '2.5 h')
    """
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"
