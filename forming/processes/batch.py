"""Many forming runs in parallel; a run that fails keeps its input and the reason."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict

from friction_models.common import InputError, check_folder, unknown_name
from friction_models.common.folders import FORMING
from friction_models.common.processes.pool import Progress, map_unordered

from ..materials.materials import MaterialSource
from ..results.result import FormingResult
from .friction_input import Friction
from .names import PROCESSES


class RunOptions(TypedDict, total=False):
    """Further arguments of `FormingProcess.run`."""

    communication_step: float
    snapshots: int | Sequence[float] | None
    eject: bool | str
    with_errors: bool


@dataclass(frozen=True)
class FormingTask:
    """Input of one run.

    Attributes
    ----------
    process : str
        ``"fre"``, ``"bce"``, ``"upsetting"`` or ``"ring"``.
    parameters : mapping
        Parameters of the process.
    friction : float or callable
        As in `FormingProcess.run`; a callable must be importable in another process (a function of a module, an
        object of a class of a module).
    stroke : float
        [mm].
    options : mapping
        Further arguments of `FormingProcess.run`: `communication_step`, `snapshots`, `eject`, `with_errors`.
    name : str
        Folder of the result, where results are kept; by default the number of the task.

    Examples
    --------
    Three runs that differ in friction only, for `run_batch`:

    >>> from forming import FormingTask
    >>> tasks = [FormingTask("ring", {"diameter": 20.0}, friction=mu, stroke=2.0) for mu in (0.05, 0.1, 0.2)]
    >>> [task.friction for task in tasks]
    [0.05, 0.1, 0.2]
    """

    process: str = "fre"
    parameters: Mapping[str, MaterialSource] = field(default_factory=dict)
    friction: Friction = 0.08
    stroke: float = 10.0
    options: RunOptions = field(default_factory=RunOptions)
    name: str = ""


@dataclass(frozen=True)
class FormingRun:
    """Input and result of one run.

    Attributes
    ----------
    task : FormingTask
    result : FormingResult or None
        The result; up to the failure where friction failed midway; None for a refused input.
    error : str
        Why the input was refused or the run failed; empty for a run that ended by itself, which may have stopped.

    Examples
    --------
    A refused input is no exception: the run says what was wrong.

    >>> from forming import FormingTask, run_batch
    >>> run = run_batch([FormingTask("ring", stroke=-1.0)], jobs=1)[0]
    >>> run.ok, run.result
    (False, None)
    >>> print(run.error)
    ring compression: stroke = -1.0 mm; allowed: 0.001 to 3.2 mm
    """

    task: FormingTask
    result: FormingResult | None
    error: str = ""

    @property
    def ok(self) -> bool:
        """Whether the run has reached its stroke."""
        return not self.error and self.result is not None and self.result.status == "ok"


def run_batch(
    tasks: Sequence[FormingTask],
    jobs: int | None = None,
    progress: Progress | None = None,
    out: str | Path | None = None,
) -> list[FormingRun]:
    """Run all tasks, in parallel if there is more than one job; return the runs in the order of the tasks.

    The numbers are those of runs one by one, bit for bit.

    Parameters
    ----------
    tasks : sequence of FormingTask
    jobs : int, optional
        Processes; by default as many as there are cores.
    progress : callable, optional
        Called with (done, total, name of the finished run).
    out : path-like, optional
        Save each result as a folder of its own in here.

    Raises
    ------
    InputError
        Less than one job, two tasks of one name, a folder that holds something else than a forming result, or a friction law that cannot be sent to another process.

    Examples
    --------
    >>> from forming import FormingTask, run_batch
    >>> run = run_batch([FormingTask("rings")], jobs=1)[0]
    >>> print(run.error)
    unknown forming process 'rings'; allowed: bce, fre, ring, upsetting; did you mean 'ring'?
    """
    named = [task.name or f"{k + 1:04d}" for k, task in enumerate(tasks)]
    for name in named:
        if named.count(name) > 1 or not name.strip(".") or set(name) & set("/\\:\0"):
            raise InputError(f"batch: name = {name!r}; allowed: one folder name for each task, each its own")
    for name in named if out is not None else ():
        check_folder(Path(out or "") / name, FORMING)
    if jobs != 1 and len(tasks) > 1:
        for name, task in zip(named, tasks):
            _check_portable(name, task)
    runs: list[FormingRun | None] = [None] * len(tasks)
    results = map_unordered(_run, [(task,) for task in tasks], jobs)
    for done, (k, (result, error)) in enumerate(results, start=1):
        runs[k] = FormingRun(tasks[k], result, error)
        if out is not None and result is not None:
            result.save(Path(out) / named[k], named[k])
        if progress is not None:
            progress(done, len(tasks), named[k])
    return [run for run in runs if run is not None]


def _check_portable(name: str, task: FormingTask) -> None:
    try:
        pickle.dumps(task)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InputError(
            f"batch: task {name} cannot be sent to another process ({error}); allowed: numbers, texts and "
            "functions of modules, or jobs = 1"
        ) from None


def _run(task: FormingTask) -> tuple[FormingResult | None, str]:
    """Run one task; return its result and the error that ended it."""
    process = None
    try:
        if task.process not in PROCESSES:
            raise unknown_name("forming process", task.process, PROCESSES)
        kind: Any = PROCESSES[task.process]
        process = kind(**task.parameters)
        return process.run(task.friction, task.stroke, **task.options), ""
    except Exception as error:
        kept = None if process is None else process.result
        return kept, f"{'' if isinstance(error, InputError) else type(error).__name__ + ': '}{error}"
