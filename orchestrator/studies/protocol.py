"""What every study has: jobs that `Campaign` runs, and what its manifest says."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Protocol

from ..jobs.campaign import Campaign, JobResult


class Study(Protocol):
    """A study. Each lies in a folder of its own with the same modules.

    ``study`` plans the jobs, ``jobs`` holds their functions where the study has its own, ``result`` evaluates what
    they gave, ``words`` says it in sentences and tables, ``files`` writes it.
    """

    #: Name of the command and in the manifest.
    name: ClassVar[str]

    @property
    def seeds(self) -> dict[str, int]:
        """Seeds for the manifest."""

    def campaign(self, folder: Path) -> Campaign:
        """Return the campaign that does the jobs."""

    def settings(self, results: Mapping[str, JobResult]) -> dict[str, Any]:
        """Return what the manifest says of the study."""
