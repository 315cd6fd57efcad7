"""What every study has in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Generic, Protocol, TypeVar

from ..jobs.graph import Job, JobGraph, JobResult


class StudyPlan(Protocol):
    """What a study does; its seed and what it says for the manifest."""

    @property
    def seed(self) -> int: ...

    def to_dict(self) -> Mapping[str, object]: ...


PlanT = TypeVar("PlanT", bound=StudyPlan, covariant=True)


@dataclass(frozen=True)
class Study(Generic[PlanT]):
    """A study as jobs. Each lies in a folder of its own with the same modules.

    ``study`` plans the jobs, ``jobs`` holds their functions where the study has its own, ``result`` evaluates what
    they gave, ``words`` says it in sentences and tables, ``files`` writes and reads it where that takes more than a
    line.
    """

    name: ClassVar[str]  # of the command and in the manifest
    seeds: ClassVar[str] = "virtual_lab"  # what the seed of the study is the seed of, for the manifest
    plan: PlanT
    jobs: tuple[Job, ...]

    def graph(self, folder: Path) -> JobGraph:
        """Return the jobs as they are run and kept in a folder."""
        return JobGraph(folder, self.jobs)

    def settings(self, results: Mapping[str, JobResult]) -> dict[str, object]:
        """Return what the manifest says of the study."""
        return dict(self.plan.to_dict())
