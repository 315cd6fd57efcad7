"""Friction models on press curves: each one runs in the forming process of every level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.runtime.errors import SimulationError

from ..cosim.ready_made import STEP, STROKE
from ..cosim.swapping import friction_fmu
from ..force_curves.forces import (
    ForceComparison,
    ForceCurve,
    LevelsComparison,
    compare_force,
    read_press_curve,
)
from ..jobs.campaign import Campaign
from ..jobs.job import Progress
from .level_runs import Level, level_job
from .study_folder import study_folder, write_runs_table

if TYPE_CHECKING:
    from forming.press import PressCurves, PressLevel


@dataclass(frozen=True)
class FailedRun:
    """A run without a result: model, level (file name without ending), process parameters, and why.

    Examples
    --------
    >>> FailedRun("law", "fre_50mms_20C", "component 'forming' failed", {"speed": 50.0}).to_dict()["level"]
    'fre_50mms_20C'
    """

    model: str
    level: str
    error: str
    inputs: Mapping[str, Any]

    def to_dict(self) -> dict[str, object]:
        """Return JSON-able data."""
        return {"model": self.model, "level": self.level, "error": self.error, "inputs": dict(self.inputs)}


@dataclass(frozen=True)
class PressResults:
    """Models that formed every level, and runs that failed.

    Attributes
    ----------
    models : list of LevelsComparison
    failed : list of FailedRun
        Their models are not among `models`: errors over different levels do not compare.
    runs : int
        All runs.

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
        """Raise when a run failed; `kept` is the folder of the runs, where there is one.

        Raises
        ------
        SimulationError
            Names the first failures.
        """
        if not self.failed:
            return
        shown = "; ".join(f"{f.model} at {f.level}: {f.error[:300]}" for f in self.failed[:3])
        more = f" (and {len(self.failed) - 3} more)" if len(self.failed) > 3 else ""
        where = "--runs FOLDER keeps their inputs" if kept is None else f"inputs in {kept / 'failed.json'}"
        raise SimulationError(f"{len(self.failed)} of {self.runs} runs failed: {shown}{more}; {where}")


@dataclass(frozen=True)
class PressStudy:
    """A folder of press curves and the forming processes that are to reproduce them.

    Attributes
    ----------
    folder : Path
        Folder with ``levels.csv``.
    press : PressCurves
        Its content; ``press.json`` may hold parameters of the process under ``process`` and ``T_billet_degC``.
    """

    folder: Path
    press: PressCurves

    @classmethod
    def open(cls, folder: Path) -> PressStudy:
        """Read the press curves.

        Raises
        ------
        InputError
            What the reader refuses.
        """
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
        names: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> PressResults:
        """Run every model on every level and compare the forces; a run that fails does not stop the others.

        Parameters
        ----------
        models : mapping of str to str
            Label and model folder, ``.fmu`` or ``.onnx`` file, or a number for constant mu.
        runs : Path, optional
            Where FMUs and runs are kept, with ``runs.json`` that says which is which; runs of the same content
            are taken from there. A temporary folder by default.
        jobs : int, optional
            Processes; all cores by default.
        progress : callable, optional
            Called with (done, total, what).
        names : mapping, optional
            By label, the variables of FMUs that call the loads otherwise (`FrictionNames.to_dict`).

        Raises
        ------
        InputError
            A model that cannot be packed or read.
        """
        with study_folder(runs) as place:
            frictions = {
                label: friction_fmu(name, place / f"friction-{number}.fmu")
                for number, (label, name) in enumerate(models.items(), 1)
            }
            pairs = [(label, level) for label in models for level in self.press.levels]
            campaign = Campaign(
                place,
                [
                    level_job(
                        _run_name(label, level),
                        Level.of(level, self.press.info, STROKE, STEP),
                        frictions[label],
                        names=(names or {}).get(label),
                        keep="summary" if runs is None else "run",
                        synthetic=self.synthetic,
                        label=label,
                    )
                    for label, level in pairs
                ],
            )
            results = campaign.run(jobs, progress=progress)
            if runs is not None:
                write_runs_table(place, results)
        failed = [
            FailedRun(label, Path(level.file).stem, failure.error, failure.job.inputs["level"])
            for label, level in pairs
            if (failure := campaign.failed.get(_run_name(label, level)))
        ]

        def compared(label: str, level: PressLevel) -> ForceComparison:
            values = results[_run_name(label, level)].values
            curve = ForceCurve(np.array(values["stroke"]), np.array(values["force"]))
            return compare_force(curve, read_press_curve(self.folder / level.file), label)

        whole = [label for label in models if label not in {f.model for f in failed}]
        return PressResults(
            [LevelsComparison(x, tuple(compared(x, level) for level in self.press.levels)) for x in whole],
            failed,
            len(pairs),
        )


def _run_name(label: str, level: PressLevel) -> str:
    return f"{Path(level.file).stem}, {label}"
