"""What the study ``extrapolation`` compares, as jobs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypedDict

from ...comparison.level_runs import FormingLevel
from ...jobs.graph import Job
from ..forming_jobs import CoupledPlan, CoupledStudy, chosen_level, coupled_job
from ..measurements import QUICK_PLAN, data_name
from ..models import model_job
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
class ExtrapolationPlan(CoupledPlan):
    """What is compared; see `CoupledPlan`.

    `conditions`: tool temperature [degC] and punch speed [mm/s] of each press level.
    """

    conditions: Sequence[tuple[float, float]] = ((20.0, 5.0), (100.0, 100.0))

    @classmethod
    def quick(cls) -> ExtrapolationPlan:
        """Return the quick size: two models, one level, short strokes."""
        return cls(("linear", "polynomial"), stroke=3.0, tests=QUICK_PLAN, conditions=((20.0, 50.0),))

    def levels(self) -> list[FormingLevel]:
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


class ExtrapolationStudy(CoupledStudy[ExtrapolationPlan]):
    """The study as jobs."""

    name = "extrapolation"

    @classmethod
    def of(cls, plan: ExtrapolationPlan, data: Mapping[str, Path] | None = None) -> ExtrapolationStudy:
        """Plan the jobs: measurements, both training sets, models, runs; `data`: one's own data set by lubricant."""
        plan, jobs = plan.measured(data)
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


def data_of(plan: ExtrapolationPlan, kind: DataKind) -> str:
    """Return the name of the job that gives a training set."""
    return data_name(plan.lubricant) + ("-reduced" if kind == "reduced" else "")


def run_name(level: FormingLevel, family: str, kind: DataKind, rule: Rule) -> str:
    """Return the name of the job of a run."""
    return f"{level.name}-{family}-{kind}-{rule}"
