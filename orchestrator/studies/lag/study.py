"""What the study ``lag`` compares, as jobs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypedDict

from friction_models.common import InputError

from ...comparison.level_runs import FormingLevel
from ..forming_jobs import SPEED, T_TOOL, CoupledPlan, CoupledStudy, chosen_level, coupled_job
from ..measurements import QUICK_PLAN, data_name
from ..models import model_job

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
class LagPlan(CoupledPlan):
    """What is compared; see `CoupledPlan`.

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
    steps: Sequence[float] = (0.05, 0.1, 0.2, 0.4, 0.8)  # communication steps [mm]; each divides the longest
    speed: float = SPEED  # of the punch [mm/s]
    T_tool: float = T_TOOL  # [degC]

    def __post_init__(self) -> None:
        super().__post_init__()
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
        return cls(("polynomial",), ("fre",), 4.0, tests=QUICK_PLAN, steps=(0.1, 0.4, 0.8))

    def level(self, process: str) -> FormingLevel:
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


class LagStudy(CoupledStudy[LagPlan]):
    """The study as jobs."""

    name = "lag"

    @classmethod
    def of(cls, plan: LagPlan, data: Mapping[str, Path] | None = None) -> LagStudy:
        """Plan the jobs: measurements, models, runs; `data` holds one's own data set by lubricant."""
        plan, jobs = plan.measured(data)
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


def run_name(process: str, family: str, mode: Mode, step: float) -> str:
    """Return the name of the job of a run."""
    return f"{process}-{family}-{mode}-{step:g}mm"
