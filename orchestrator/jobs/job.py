"""One job of a graph, and one that failed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from friction_models.common.json_values import plain

from .store import JobResult

#: Called with (done, total, what was done and how long the rest will take).
Progress = Callable[[int, int, str], None]
#: What the function of a job gets by name: JSON-able inputs, paths of its files, results of the jobs it needs.
Inputs = Mapping[str, Any]
Files = Mapping[str, Path]
Needs = Mapping[str, JobResult]


@dataclass(frozen=True)
class Job:
    """A call whose result is kept.

    The function ``"package.module:function"`` is called with (inputs, files, needs, folder), the last a folder for files
    that are kept with the result. It returns a JSON-able dict; measured times go under the key ``"timing"``, which is no
    part of the number that two runs must agree in.

    Examples
    --------
    >>> job = Job("second", "json:dumps", {"seed": 1}, needs=("first",))
    >>> job.name, job.needs, job.seconds
    ('second', ('first',), 1.0)
    """

    name: str
    function: str
    inputs: Inputs = field(default_factory=dict)  # JSON-able; decide the result
    files: dict[str, Path] = field(default_factory=dict)  # their content decides the result, not their place
    needs: tuple[str, ...] = ()  # names of the jobs whose results it gets
    seconds: float = 1.0  # what it is expected to take; only for estimates


@dataclass(frozen=True)
class Failure:
    """A job without a result, and why."""

    job: Job
    error: str
    traceback: str = ""

    def to_dict(self) -> dict[str, object]:
        """Return plain data: the job with its inputs, and the reason."""
        content: dict[str, object] = plain(asdict(self.job)) | {
            "error": self.error,
            "traceback": self.traceback,
        }
        del content["seconds"]
        return content
