"""Friction models on press curves: each one runs in the forming process of every level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fmus.runtime.errors import SimulationError

from ..cosim.ready_made import STEP, STROKE
from ..cosim.swapping import friction_fmu
from ..force_curves.forces import (
    ForceComparison,
    LevelsComparison,
    compare_force,
    read_press_curve,
)
from ..jobs.job import Progress
from .level_runs import FormingLevel, force_curve, level_job
from .study_folder import run_jobs, study_folder

if TYPE_CHECKING:
    from forming.press import PressCurves, PressLevel


@dataclass(frozen=True)
class FailedRun:
    """A run without a result: model, level (file name without ending), why, and the parameters of the process."""

    model: str
    level: str
    error: str
    inputs: Mapping[str, object]


@dataclass(frozen=True)
class PressResults:
    """Models that formed every level, and runs that failed.

    Models with `failed` runs are not among `models`: errors over different levels do not compare. `runs` counts all.

    Examples
    --------
    >>> results = PressResults([], [FailedRun("law", "fre_50mms_20C", "no convergence", {})], runs=4)
    >>> results.check(None)
    Traceback (most recent call last):
        ...
    fmus.runtime.errors.SimulationError: 1 of 4 runs failed: law at fre_50mms_20C: no convergence; --runs FOLDER keeps their inputs
    """

    models: list[LevelsComparison]
    failed: list[FailedRun]
    runs: int

    def check(self, kept: Path | None) -> None:
        """Raise an error that names the first failures, if any; `kept` is the folder of the runs, where there is one."""
        if not self.failed:
            return
        shown = "; ".join(f"{f.model} at {f.level}: {f.error[:300]}" for f in self.failed[:3])
        more = f" (and {len(self.failed) - 3} more)" if len(self.failed) > 3 else ""
        where = "--runs FOLDER keeps their inputs" if kept is None else f"inputs in {kept / 'failed.json'}"
        raise SimulationError(f"{len(self.failed)} of {self.runs} runs failed: {shown}{more}; {where}")


@dataclass(frozen=True)
class PressStudy:
    """A folder of press curves and the forming processes that are to reproduce them.

    ``press.json`` in the folder may hold parameters of the process under ``process`` and ``T_billet_degC``.
    """

    folder: Path
    press: PressCurves

    @classmethod
    def open(cls, folder: Path) -> PressStudy:
        """Read the press curves."""
        from forming.press import PressCurves

        return cls(folder, PressCurves.read(folder))

    @property
    def synthetic(self) -> bool:
        """Whether the press curves come from a virtual laboratory."""
        return bool(self.press.synthetic)

    def compare(
        self,
        models: Mapping[str, str],
        runs: Path | None = None,
        jobs: int | None = None,
        progress: Progress | None = None,
        names: Mapping[str, Mapping[str, object]] | None = None,
    ) -> PressResults:
        """Run every model on every level and compare the forces; a run that fails does not stop the others.

        `models` are by label what `friction_fmu` takes; `names`, by label, the variables of FMUs that call the loads
        otherwise (`FrictionNames.to_dict`). FMUs and runs are kept in the folder `runs` (a temporary one by default),
        where ``runs.json`` says which is which; runs of the same content are taken from there.
        """
        with study_folder(runs) as place:
            frictions = {
                label: friction_fmu(name, place / f"friction-{number}.fmu")
                for number, (label, name) in enumerate(models.items(), 1)
            }
            pairs = [(label, level) for label in models for level in self.press.levels]
            todo = [
                level_job(
                    _run_name(label, level),
                    FormingLevel.of(level, self.press.info, STROKE, STEP),
                    frictions[label],
                    names=(names or {}).get(label),
                    keep="summary" if runs is None else "run",
                    synthetic=self.synthetic,
                    label=label,
                )
                for label, level in pairs
            ]
            results, failures = run_jobs(place, todo, jobs, progress)
        failed = [
            FailedRun(label, Path(level.file).stem, failure.error, failure.job.inputs["level"])
            for label, level in pairs
            if (failure := failures.get(_run_name(label, level)))
        ]

        def compared(label: str, level: PressLevel) -> ForceComparison:
            curve = force_curve(results[_run_name(label, level)].values)
            return compare_force(curve, read_press_curve(self.folder / level.file), label)

        whole = [label for label in models if label not in {f.model for f in failed}]
        return PressResults(
            [LevelsComparison(x, tuple(compared(x, level) for level in self.press.levels)) for x in whole],
            failed,
            len(pairs),
        )


def _run_name(label: str, level: PressLevel) -> str:
    return f"{Path(level.file).stem}, {label}"
