"""What the study ``lag`` compares, as jobs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypedDict

from friction_models.common import InputError

from ...comparison.level_runs import Level
from ...jobs.campaign import Job, JobResult
from ..forming_jobs import SPEED, T_TOOL, check_names, chosen_level, coupled_job, synthetic
from ..measurements import FULL_PLAN, QUICK_PLAN, data_jobs, data_name, only_lubricant
from ..models import model_job
from ..study import Study

Mode = Literal["jacobi", "gauss_seidel", "iterated"]
MODES: tuple[Mode, ...] = ("jacobi", "gauss_seidel", "iterated")


class LagSettings(TypedDict):
    """A plan as plain data: what `LagPlan.to_dict` returns; `stroke_mm` by process."""

    models: list[str]
    processes: list[str]
    steps_mm: list[float]
    stroke_mm: dict[str, float]
    speed_mm_s: float
    T_tool_degC: float
    lubricant: str
    compared_every_mm: float


@dataclass(frozen=True)
class LagPlan:
    """What is compared.

    Attributes
    ----------
    models : sequence of str
        Families.
    processes : sequence of str
    steps : sequence of float
        Communication steps [mm]; each divides the longest.
    stroke : float or None
        Punch travel [mm]; None for that of a usual run.
    speed, T_tool : float
        Level of the press: punch speed [mm/s], tool temperature [degC].
    lubricant, tests : str
        Lubricant, and plan of the compression tests, of the virtual laboratory.
    seed : int

    Examples
    --------
    >>> plan = LagPlan(models=("linear",), processes=("fre",), steps=(0.1, 0.2))
    >>> plan.level("fre").name
    'fre_50mms_50C'
    >>> LagPlan(steps=(0.3, 0.4))
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: communication step 0.3 mm does not divide the longest, 0.4 mm; allowed: steps that do, so that all runs can be compared at the same strokes
    """

    models: Sequence[str] = ("polynomial", "ffnn")
    processes: Sequence[str] = ("fre", "bce")
    steps: Sequence[float] = (0.05, 0.1, 0.2, 0.4, 0.8)
    stroke: float | None = None
    speed: float = SPEED
    T_tool: float = T_TOOL
    lubricant: str = "polymer"
    tests: str = FULL_PLAN
    seed: int = 0

    def __post_init__(self) -> None:
        check_names(self.models, self.processes)
        longest = max(self.steps)
        for step in self.steps:
            if not 0.001 <= step <= 5.0:
                raise InputError(f"communication step {step:g} mm, allowed: 0.001 to 5 mm")
            if abs(longest / step - round(longest / step)) > 1e-6:
                raise InputError(
                    f"communication step {step:g} mm does not divide the longest, {longest:g} mm; "
                    "allowed: steps that do, so that all runs can be compared at the same strokes"
                )

    @classmethod
    def quick(cls) -> LagPlan:
        """Return the quick size: one model, a short rod."""
        return cls(("polynomial",), ("fre",), (0.1, 0.4, 0.8), 4.0, tests=QUICK_PLAN)

    def level(self, process: str) -> Level:
        """Return the press level of a process."""
        return chosen_level(process, self.stroke, max(self.steps), self.speed, self.T_tool)

    def to_dict(self) -> LagSettings:
        """Return plain data."""
        return {
            "models": list(self.models),
            "processes": list(self.processes),
            "steps_mm": list(self.steps),
            "stroke_mm": {process: self.level(process).stroke for process in self.processes},
            "speed_mm_s": self.speed,
            "T_tool_degC": self.T_tool,
            "lubricant": self.lubricant,
            "compared_every_mm": max(self.steps),
        }


@dataclass(frozen=True)
class LagStudy(Study):
    """The study as jobs.

    Attributes
    ----------
    plan : LagPlan
    jobs : tuple of Job
    """

    plan: LagPlan
    jobs: tuple[Job, ...] = ()
    name = "lag"

    @classmethod
    def of(cls, plan: LagPlan, data: Mapping[str, Path] | None = None) -> LagStudy:
        """Plan the jobs: measurements, models, runs; `data` holds one's own data set by lubricant.

        Raises
        ------
        InputError
            More than one data set, or one that cannot be used.
        """
        plan = replace(plan, lubricant=only_lubricant(data, plan.lubricant))
        jobs = list(data_jobs(data, (plan.lubricant,), plan.tests, plan.seed)[plan.lubricant])
        for family in plan.models:
            model = model_job(family, data_name(plan.lubricant))
            jobs.append(model)
            for process in plan.processes:
                level = plan.level(process)
                jobs += [
                    coupled_job(
                        run_name(process, family, mode, step), level, model.name, mode, step, label=family
                    )
                    for step in plan.steps
                    for mode in MODES
                ]
        return cls(plan, tuple(jobs))

    def settings(self, results: Mapping[str, JobResult]) -> dict[str, object]:
        """Return what the manifest says of the study."""
        return {**self.plan.to_dict(), "synthetic": synthetic(results)}


def run_name(process: str, family: str, mode: Mode, step: float) -> str:
    """Return the name of the job of a run."""
    return f"{process}-{family}-{mode}-{step:g}mm"
