"""Jobs of a campaign, and failed ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

#: Called with (done, total, what was done and how long the rest will take).
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Job:
    """A call whose result is kept.

    Attributes
    ----------
    name : str
        Its name in the campaign.
    function : str
        ``"package.module:function"``, called with (inputs, files, needs, folder): the next three and a folder for
        files that are kept with the result. It returns a JSON-able dict; measured times go under the
        key ``"timing"``, which is no part of the number that two runs must agree in.
    inputs : dict
        JSON-able; decide the result.
    files : dict of str to Path
        Files or folders; their content decides the result, not their place.
    needs : tuple of str
        Names of the jobs whose results it gets.
    seconds : float
        What it is expected to take [s]; only for estimates.

    Examples
    --------
    >>> job = Job("second", "json:dumps", {"seed": 1}, needs=("first",))
    >>> job.name, job.needs, job.seconds
    ('second', ('first',), 1.0)
    """

    name: str
    function: str
    inputs: Mapping[str, Any] = field(default_factory=dict)
    files: dict[str, Path] = field(default_factory=dict)
    needs: tuple[str, ...] = ()
    seconds: float = 1.0


@dataclass(frozen=True)
class Failure:
    """A job without a result, and why.

    Examples
    --------
    >>> Failure(Job("first", "json:dumps"), "ValueError: no such seed").to_dict()["error"]
    'ValueError: no such seed'
    """

    job: Job
    error: str
    traceback: str = ""

    def to_dict(self) -> dict[str, object]:
        """Return plain data: the job with its inputs, and the reason."""
        return {
            "name": self.job.name,
            "function": self.job.function,
            "inputs": self.job.inputs,
            "files": {name: str(path) for name, path in self.job.files.items()},
            "needs": list(self.job.needs),
            "error": self.error,
            "traceback": self.traceback,
        }
