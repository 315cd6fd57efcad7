"""Folder in which a comparison keeps its FMUs and runs: the user's, or a temporary one."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from friction_models.common import grown, write_json
from friction_models.common.folders import STUDY

from ..jobs.graph import Failure, Job, JobGraph, JobResult
from ..jobs.job import Progress

#: Name of the run folder in the folder of a job's result.
RUN = "run"


@contextmanager
def study_folder(given: Path | None) -> Iterator[Path]:
    """Yield the folder of a study that the user names, or a temporary one that goes with the block."""
    place = given if given is not None else Path(tempfile.mkdtemp(prefix="tribofmu-study-"))
    try:
        yield grown(place, STUDY)
    finally:
        if given is None:
            shutil.rmtree(place, ignore_errors=True)


def run_jobs(
    place: Path, todo: Iterable[Job], jobs: int | None, progress: Progress | None
) -> tuple[dict[str, JobResult], dict[str, Failure]]:
    """Return results and failures; ``runs.json`` says which run folder is whose, as hashes name the folders."""
    graph = JobGraph(place, todo)
    results = graph.run(jobs, progress=progress)
    folders = {name: (r.folder / RUN).relative_to(place.resolve()) for name, r in results.items()}
    write_json(place / "runs.json", {name: folder.as_posix() for name, folder in folders.items()})
    return results, graph.failed
