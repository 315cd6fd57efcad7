"""What the study ``extrapolation`` compares, as jobs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypedDict

from ...comparison.level_runs import Level
from ...jobs.campaign import Job, JobResult
from ..forming_jobs import check_names, chosen_level, coupled_job, synthetic
from ..measurements import FULL_PLAN, QUICK_PLAN, data_jobs, data_name, only_lubricant
from ..models import ADVANCED, model_job
from ..study import Study
from .jobs import REDUCED_BY

#: Training data: all training tests, or those with low pressure and temperature only.
DataKind = Literal["all", "reduced"]
DATA_KINDS: tuple[DataKind, ...] = ("all", "reduced")
Rule = Literal["clamp", "extrapolate"]
#: Value of the FMU's parameter ``clamp_to_domain``.
RULES: dict[Rule, bool] = {"clamp": True, "extrapolate": False}
STEP = 0.1


class ExtrapolationSettings(TypedDict):
    """A plan as plain data: what `ExtrapolationPlan.to_dict` returns; `stroke_mm` by level."""

    models: list[str]
    processes: list[str]
    levels: list[dict[str, float]]
    stroke_mm: dict[str, float]
    communication_step_mm: float
    lubricant: str
    reduced_by: list[str]


@dataclass(frozen=True)
class ExtrapolationPlan:
    """What is compared.

    Attributes
    ----------
    models : sequence of str
        Families.
    processes : sequence of str
    conditions : sequence of (float, float)
        Tool temperature [degC] and punch speed [mm/s].
    stroke : float or None
        Punch travel [mm]; None for that of a usual run.
    lubricant, tests : str
        Lubricant, and plan of the compression tests, of the virtual laboratory.
    seed : int
    """

    models: Sequence[str] = ADVANCED
    processes: Sequence[str] = ("fre", "bce")
    conditions: Sequence[tuple[float, float]] = ((20.0, 5.0), (100.0, 100.0))
    stroke: float | None = None
    lubricant: str = "polymer"
    tests: str = FULL_PLAN
    seed: int = 0

    def __post_init__(self) -> None:
        check_names(self.models, self.processes)

    @classmethod
    def quick(cls) -> ExtrapolationPlan:
        """Return the quick size: two models, one level, short strokes."""
        return cls(("linear", "polynomial"), ("fre", "bce"), ((20.0, 50.0),), 3.0, tests=QUICK_PLAN)

    def levels(self) -> list[Level]:
        """Return the press levels, process by process."""
        return [
            chosen_level(process, self.stroke, STEP, speed, T_tool)
            for process in self.processes
            for T_tool, speed in self.conditions
        ]

    def to_dict(self) -> ExtrapolationSettings:
        """Return plain data."""
        return {
            "models": list(self.models),
            "processes": list(self.processes),
            "levels": [{"T_tool_degC": t, "speed_mm_s": v} for t, v in self.conditions],
            "stroke_mm": {level.name: level.stroke for level in self.levels()},
            "communication_step_mm": STEP,
            "lubricant": self.lubricant,
            "reduced_by": list(REDUCED_BY),
        }


@dataclass(frozen=True)
class ExtrapolationStudy(Study):
    """The study as jobs.

    Attributes
    ----------
    plan : ExtrapolationPlan
    jobs : tuple of Job
    """

    plan: ExtrapolationPlan
    jobs: tuple[Job, ...] = ()
    name = "extrapolation"

    @classmethod
    def of(cls, plan: ExtrapolationPlan, data: Mapping[str, Path] | None = None) -> ExtrapolationStudy:
        """Plan the jobs: measurements, both training sets, models, runs; `data` holds one's own data set by lubricant.

        Raises
        ------
        InputError
            More than one data set, or one that cannot be used.
        """
        plan = replace(plan, lubricant=only_lubricant(data, plan.lubricant))
        jobs = list(data_jobs(data, (plan.lubricant,), plan.tests, plan.seed)[plan.lubricant])
        whole, reduced = (data_of(plan, kind) for kind in DATA_KINDS)
        jobs.append(
            Job(reduced, "orchestrator.studies.extrapolation.jobs:reduce", needs=(whole,), seconds=3.0)
        )
        for family in plan.models:
            for kind in DATA_KINDS:
                model = model_job(family, data_of(plan, kind))
                jobs.append(model)
                jobs += [
                    coupled_job(
                        run_name(level, family, kind, rule),
                        level,
                        model.name,
                        step=STEP,
                        start={"clamp_to_domain": clamped},
                        label=f"{family}, {kind}, {rule}",
                    )
                    for level in plan.levels()
                    for rule, clamped in RULES.items()
                ]
        return cls(plan, tuple(jobs))

    def settings(self, results: Mapping[str, JobResult]) -> dict[str, object]:
        """Return what the manifest says of the study."""
        return {**self.plan.to_dict(), "synthetic": synthetic(results)}


def data_of(plan: ExtrapolationPlan, kind: DataKind) -> str:
    """Return the name of the job that gives a training set."""
    return data_name(plan.lubricant) + ("-reduced" if kind == "reduced" else "")


def run_name(level: Level, family: str, kind: DataKind, rule: Rule) -> str:
    """Return the name of the job of a run."""
    return f"{level.name}-{family}-{kind}-{rule}"
