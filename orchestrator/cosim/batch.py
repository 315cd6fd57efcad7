"""Many runs at once, in a pool of processes. Runs that are already there are taken as they are.

This is for systems whose run folders the user names and looks at. Studies, whose jobs need each other, are graphs
(`jobs.graph`).
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from friction_models.common import InputError, check_folder
from friction_models.common.cached_results import is_kept, keep, path_digest
from friction_models.common.files import read_json
from friction_models.common.folders import RUN
from friction_models.common.processes.pool import map_unordered

from ..jobs.job import Progress
from ..jobs.keys import ResultKeys, running_code
from ..jobs.versions import versions
from .master import Master
from .run_folders import Run
from .system import System


@dataclass(frozen=True)
class RunTask:
    """A system to run into a folder."""

    system: System
    folder: Path
    mode: str = "gauss_seidel"
    #: Of a run in a cache (`cached_task`): the hash of all that decides it. Such a run is kept with a checksum; a folder
    #: in its place that does not fit is replaced, whatever is in it.
    key: str = ""


def cached_task(system: System, cache: Path, keys: ResultKeys, label: str) -> RunTask:
    """Return the task that runs a system into a folder of a cache, named by the hash of all that decides the run.

    `label` tells runs apart that have everything else in common.
    """
    content = system.to_dict({name: path_digest(system.fmu_path(name)) for name in system.components})
    key = keys.of({"system": content, "label": label})[:20]
    return RunTask(system, cache / key, key=key)


def run_all(tasks: Sequence[RunTask], jobs: int | None = None, progress: Progress | None = None) -> list[Run]:
    """Run all tasks, in parallel where there is more than one, and return their runs in order.

    A folder that already holds a complete run of the same system, with the same FMUs, start values,
    steps, versions and sources (an FMU of a process runs the solver that is installed), is not computed again.
    The first task that fails ends it; the finished ones stay.
    """
    tick = progress or (lambda done, total, name: None)
    waiting = [task for task in tasks if not _same_run(task)]
    for task in waiting:
        if task.key:
            shutil.rmtree(task.folder, ignore_errors=True)
        check_folder(task.folder, RUN)
    done = len(tasks) - len(waiting)
    tick(done, len(tasks), "")
    for index, _ in map_unordered(_run, [_portable(task) for task in waiting], jobs):
        done += 1
        tick(done, len(tasks), waiting[index].folder.name)
    return [Run.load(task.folder) for task in tasks]


def _portable(task: RunTask) -> tuple[dict[str, object], str, str, str]:
    """What a worker needs, as plain data: absolute FMU paths make the place of the YAML file irrelevant."""
    paths = {name: str(task.system.fmu_path(name)) for name in task.system.components}
    return task.system.to_dict(paths), str(task.folder), task.mode, task.key


def _run(content: dict[str, object], folder: str, mode: str, key: str) -> None:
    Master(System.from_dict(content, source=str(content["name"])), mode=mode).run(folder)
    if key:
        keep(Path(folder), key)


def _same_run(task: RunTask) -> bool:
    """Whether the folder holds a finished run of the same thing: by its key in a cache, else by its manifest."""
    if task.key:
        return is_kept(task.folder, task.key)
    system = task.system
    try:
        manifest = read_json(task.folder / "manifest.json")
        parts = manifest["components"]
        return bool(
            manifest["status"] == "ok"
            and manifest["mode"] == task.mode
            and manifest["steps"] == system.steps
            and manifest["communication_step"] == system.communication_step
            and manifest["versions"] == versions()
            and manifest["code"] == running_code(__package__)
            and manifest["provenance"] == system.provenance
            and parts.keys() == system.components.keys()
            and all(parts[n]["sha256"] == path_digest(system.fmu_path(n)) for n in parts)
            and all(parts[n]["start"] == system.components[n].start for n in parts)
            and manifest["results_sha256"] == path_digest(task.folder / "results.nc")
        )
    except (InputError, KeyError, TypeError, ValueError, OSError):
        return False
