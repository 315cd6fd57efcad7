"""Jobs that form a press level. A run that breaks off is a result, too: these studies show where forming fails."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

from fmus.runtime.errors import SimulationError
from friction_models.common import InputError, unknown_name

from ..comparison.level_runs import (
    RUN,
    SECONDS_A_MM,
    FormingLevel,
    StartValues,
    friction_file,
    level_inputs,
    simulate_level,
    summary,
)
from ..cosim.run_folders import Run
from ..jobs.graph import Job, JobResult
from ..jobs.job import Files, Inputs, Needs
from .measurements import FULL_PLAN, data_jobs
from .models import ADVANCED
from .study import PlanT, Study

#: Relative change at which repetitions agree: well above what the solver resolves, well below what matters.
TOLERANCE = 1e-5
#: Repetitions of a step in the mode ``iterated``, for estimates.
REPETITIONS = 4.5
#: What is said where the forming itself cannot go on: by the solver, by the repetitions of a step, by a component that
#: refuses a value. Anything else (memory, disk, a process that is gone) may not happen a second time.
REASONS = ("stopped at stroke", "did not converge in", "allowed:")
#: Middle levels of the press.
SPEED, T_TOOL = 50.0, 50.0


def coupled_job(
    name: str,
    level: FormingLevel,
    friction: str,
    mode: str = "gauss_seidel",
    step: float = 0.1,
    start: StartValues | None = None,
    label: str = "",
) -> Job:
    """Return the job that forms `level` with the FMU of the job `friction`, run folder kept; see `level_job`."""
    inputs = level_inputs(level, mode, step, start) | {"label": label, "tolerance": TOLERANCE}
    # The cost by millimetre is that of steps of 0.1 mm; the solver makes small ones of its own within a long one.
    cost = SECONDS_A_MM.get(level.process, 0.25) * level.stroke * max(0.5, min(2.0, 0.1 / step))
    return Job(
        name,
        f"{__name__}:run_coupled",
        inputs,
        needs=(friction,),
        seconds=1.5 + cost * (REPETITIONS if mode == "iterated" else 1.0),
    )


def run_coupled(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, object]:
    """Form a level and keep the run; the function of `coupled_job`.

    Beside what `level_runs.summary` returns ``failed`` says why the run broke off, and is empty for a complete one;
    ``repetitions`` are mean and largest number of a step, and the largest change left (mode ``iterated``). A component
    that fails for another reason than `REASONS` gives no result, so that the next start of the study tries again.
    """
    (model,) = needs.values()
    given = {**inputs, "synthetic": bool(model.values.get("synthetic", False))}
    try:
        run = simulate_level(given, friction_file(files, needs), folder / RUN)
    except SimulationError as error:
        if not any(reason in str(error) for reason in REASONS):
            raise
        if not (folder / RUN / "manifest.json").is_file():
            return {"failed": str(error), "steps": 0, "repetitions": None, "timing": {}}
        run = Run.load(folder / RUN, stopped=True)
    made = run.manifest.get("iterations")
    return {**summary(run), "failed": run.message, "repetitions": made}


def run_of(result: JobResult) -> Run | None:
    """Return the run that a job kept, None where not a single step was made."""
    if not result.values["steps"]:
        return None
    return Run.load(result.folder / RUN, stopped=True)


@dataclass(frozen=True)
class CoupledPlan:
    """What studies of coupled runs have in common.

    Examples
    --------
    >>> CoupledPlan(models=["liner"])
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown model 'liner'; allowed: ffnn, gradient_boosting, linear, polynomial, power_law; did you mean 'linear'?
    """

    models: Sequence[str] = ADVANCED  # families
    processes: Sequence[str] = ("fre", "bce")
    stroke: float | None = None  # punch travel [mm]; None: that of a usual run
    lubricant: str = "polymer"
    tests: str = FULL_PLAN  # plan of the compression tests of the virtual laboratory
    seed: int = 0  # of the virtual laboratory

    def __post_init__(self) -> None:
        for what, names, known in (
            ("model", self.models, ADVANCED),
            ("process", self.processes, tuple(SECONDS_A_MM)),
        ):
            for name in names:
                if name not in known:
                    raise unknown_name(what, name, known)

    def measured(self, data: Mapping[str, Path] | None) -> tuple[Self, list[Job]]:
        """Return the plan with the lubricant of one's own data, where there are any, and the jobs that measure it."""
        if data is not None and len(data) > 1:
            raise InputError(
                f"--data: {len(data)} data sets, allowed: one, as the study compares runs of one lubricant"
            )
        plan = replace(self, lubricant=next(iter(data or ()), self.lubricant))
        return plan, data_jobs(data, (plan.lubricant,), plan.tests, plan.seed)[plan.lubricant]


class CoupledStudy(Study[PlanT]):
    """A study of coupled runs with one lubricant."""

    def settings(self, results: Mapping[str, JobResult]) -> dict[str, object]:
        """Return what the manifest says of the study."""
        return {**super().settings(results), "synthetic": synthetic(results)}


def synthetic(results: Mapping[str, JobResult]) -> bool:
    """Return whether any result comes from synthetic measurements."""
    return any(bool(result.values.get("synthetic")) for result in results.values())


def chosen_level(
    process: str, stroke: float | None, step: float, speed: float, T_tool: float
) -> FormingLevel:
    """Return a level with the stroke wanted (or usual) as far as the process allows, in whole steps [mm].

    Examples
    --------
    >>> round(chosen_level("fre", stroke=5.04, step=0.1, speed=50.0, T_tool=20.0).stroke, 6)
    5.0
    """
    from ..cosim.ready_made import STROKE

    wanted = STROKE if stroke is None else stroke
    if not wanted >= step:
        raise InputError(f"stroke = {wanted:g} mm, allowed: at least one communication step of {step:g} mm")
    far = FormingLevel(process, T_tool, speed, 0.0).farthest(step)
    return FormingLevel(process, T_tool, speed, min(math.floor(wanted / step + 1e-6) * step, far))
