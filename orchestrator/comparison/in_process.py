"""Several friction models in a forming process of ours, at one level of speed and tool temperature or at several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fmus import pack_forming
from fmus.runtime.errors import SimulationError
from fmus.runtime.friction_names import FrictionNames
from forming.processes.names import PROCESSES
from forming.processes.parameters import declared
from friction_models.common import InputError
from friction_models.common.ranges import check_range, is_number

from ..cosim.ready_made import STEP, STROKE, extrusion_system
from ..force_curves.forces import ForceCurve
from ..jobs.job import Progress
from .in_one_system import RunsComparison, compare_in_system
from .study_folder import study_folder

#: What a level may set; everything else is the same at all levels.
LEVEL = ("speed", "T_tool", "T_billet")


@dataclass(frozen=True)
class FormingPlan:
    """A forming process and its levels.

    Examples
    --------
    >>> plan = FormingPlan("fre", {"half_angle": 30.0}, [{"speed": 5.0}, {"speed": 50.0, "T_tool": 100.0}])
    >>> [plan.name(level) for level in plan.levels]
    ['fre-speed-5', 'fre-speed-50-T_tool-100']
    >>> FormingPlan("fre", {}, [{"half_angle": 30.0}])
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: --level 'half_angle=30.0': unknown ...
    """

    process: str  # "fre", "bce", "upsetting" or "ring"
    parameters: Mapping[str, Any] = field(default_factory=dict)  # those that differ from its defaults
    levels: Sequence[Mapping[str, float]] = ({},)  # parameters of `LEVEL` that differ from level to level
    stroke: float | None = None  # punch travel [mm]; None: 20 mm, or what the process allows

    def __post_init__(self) -> None:
        for level in self.levels:
            for name, value in level.items():
                if name not in LEVEL:
                    raise InputError(
                        f"--level '{name}={value}': unknown parameter of a level; allowed: {', '.join(LEVEL)}"
                    )
                if not is_number(value):
                    raise InputError(f"--level: {name} = {value!r:.60}; allowed: a number")
        names = [self.name(level) for level in self.levels]
        twice = next((n for n in names if names.count(n) > 1), None)
        if twice is not None:
            raise InputError(f"--level: {twice} is given twice; allowed: each level once")

    def name(self, level: Mapping[str, float]) -> str:
        """Return the name of a level in files and pages."""
        return "-".join([self.process, *(f"{name}-{value:g}" for name, value in level.items())])

    def forming(self, level: Mapping[str, float]) -> Any:
        """Return the forming process at a level, whose parameters it must have."""
        values = {**self.parameters, **level}
        declared(self.process, values)  # says what is wrong with names and values
        return PROCESSES[self.process](**values)

    def longest(self, level: Mapping[str, float]) -> float:
        """Return the stroke of a level in whole steps [mm]; one that the process does not allow is refused."""
        forming = self.forming(level)
        if self.stroke is None:
            return float(np.floor(min(STROKE, forming.max_stroke) / STEP + 1e-6) * STEP)
        check_range(forming.name, "stroke", self.stroke, STEP, forming.max_stroke, "mm")
        return self.stroke


@dataclass(frozen=True)
class LevelsOfProcess:
    """Runs of several friction models at each level of a process, by the name of the level."""

    levels: Mapping[str, RunsComparison]
    #: By the name of a level: why none of its runs came to an end.
    failed: Mapping[str, str] = field(default_factory=dict)

    @property
    def synthetic(self) -> bool:
        """Whether something in the runs came from a virtual laboratory."""
        return any(runs.synthetic for runs in self.levels.values())

    @property
    def failures(self) -> dict[str, str]:
        """Return why runs failed, by level and model."""
        single = {f"{n}, {m}": error for n, runs in self.levels.items() for m, error in runs.failed.items()}
        return {**dict(self.failed), **single}

    def against(self, measured: Sequence[ForceCurve]) -> LevelsOfProcess:
        """Return the runs of every level held against the repeats of a press curve; see `RunsComparison.against`."""
        return LevelsOfProcess({n: runs.against(measured) for n, runs in self.levels.items()}, self.failed)

    def to_dict(self) -> dict[str, object]:
        """Return JSON-able data: the runs of every level."""
        return {
            "synthetic": self.synthetic,
            "levels": [{"level": name, **runs.to_dict()} for name, runs in self.levels.items()],
            "failed": [{"level": name, "error": error} for name, error in self.failed.items()],
        }

    def report(self) -> str:
        """Return the tables."""
        lost = [f"{name}: {error}" for name, error in self.failed.items()]
        return "\n\n".join([*(runs.report() for runs in self.levels.values()), *lost])


def compare_in_process(
    plan: FormingPlan,
    models: Mapping[str, str],
    runs: Path | None = None,
    names: Mapping[str, FrictionNames] | None = None,
    mode: str = "gauss_seidel",
    jobs: int | None = None,
    progress: Progress | None = None,
    local_errors: bool = False,
) -> LevelsOfProcess:
    """Form every level with each friction model, and once without friction; see `compare_in_system`.

    The folder `runs` keeps the forming FMU of each level and a folder with its runs; `progress` counts over all levels.
    A level none of whose runs came to an end does not stop the others.
    """
    strokes = {plan.name(level): plan.longest(level) for level in plan.levels}
    found: dict[str, RunsComparison] = {}
    failed: dict[str, str] = {}
    with study_folder(runs) as place:
        for number, level in enumerate(plan.levels):
            name = plan.name(level)
            values = {**plan.parameters, **level}
            packed = pack_forming(place / f"{name}.fmu", process=plan.process, stroke=strokes[name], **values)
            speed = float(plan.forming(level).speed)
            system = extrusion_system(place / "friction.fmu", packed, speed, strokes[name], name)
            # Not every friction FMU has it; it is recorded where a model is swapped in that does.
            system.record = [label for label in system.record or [] if not label.startswith("friction.")]
            try:
                found[name] = compare_in_system(
                    system, models, place / name, names, mode, jobs,
                    _share(progress, number, len(plan.levels), name), local_errors,
                )  # fmt: skip
            except SimulationError as error:
                failed[name] = str(error)
    if not found:
        raise SimulationError(next(iter(failed.values())))
    return LevelsOfProcess(found, failed)


def _share(progress: Progress | None, number: int, levels: int, name: str) -> Progress | None:
    """Return what counts the runs of one level among those of all."""
    if progress is None or levels == 1:
        return progress

    def tick(done: int, total: int, what: str) -> None:
        progress(number * total + done, levels * total, f"{name}: {what}")

    return tick
