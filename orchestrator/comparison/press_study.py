"""Friction models on press curves: each one runs in the forming process of every level."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.runtime.errors import SimulationError
from friction_models.common import grown, write_json
from friction_models.common.folders import STUDY

from ..cosim.ready_made import STEP, STROKE
from ..cosim.swapping import friction_fmu
from ..force_curves.forces import ForceCurve, LevelsComparison, compare_force, read_press_curve
from ..jobs.campaign import Campaign
from .level_runs import RUN, Level, level_job

if TYPE_CHECKING:
    from forming.press import PressCurves

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class FailedRun:
    """A run without a result: model, level (file name without ending), process parameters, and why."""

    model: str
    level: str
    error: str
    inputs: Mapping[str, Any]

    def to_dict(self) -> dict[str, Any]:
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
        place = runs if runs is not None else Path(tempfile.mkdtemp(prefix="tribofmu-study-"))
        try:
            grown(place, STUDY)
            frictions = {
                label: friction_fmu(name, place / f"friction-{number}.fmu")
                for number, (label, name) in enumerate(models.items(), 1)
            }
            pairs = [(label, level) for label in models for level in self.press.levels]
            jobs_of = [
                level_job(
                    f"{Path(level.file).stem}, {label}",
                    Level.of(level, self.press.info, STROKE, STEP),
                    frictions[label],
                    names=(names or {}).get(label),
                    keep="summary" if runs is None else "run",
                    synthetic=self.synthetic,
                    label=label,
                )
                for label, level in pairs
            ]
            campaign = Campaign(place, jobs_of)
            results = campaign.run(jobs, progress=progress)
            if runs is not None:
                # Folders are named by hashes; the table says which is which.
                folders = {
                    name: (result.folder / RUN).relative_to(place.resolve())
                    for name, result in results.items()
                }
                write_json(place / "runs.json", {name: folder.as_posix() for name, folder in folders.items()})
            curves = {
                name: ForceCurve(np.array(result.values["stroke"]), np.array(result.values["force"]))
                for name, result in results.items()
            }
            failed = [
                FailedRun(label, Path(level.file).stem, failure.error, failure.job.inputs["level"])
                for label, level in pairs
                if (failure := campaign.failed.get(f"{Path(level.file).stem}, {label}"))
            ]
            return PressResults(
                [
                    LevelsComparison(
                        label,
                        tuple(
                            compare_force(
                                curves[f"{Path(level.file).stem}, {label}"],
                                read_press_curve(self.folder / level.file),
                                label,
                            )
                            for level in self.press.levels
                        ),
                    )
                    for label in models
                    if label not in {f.model for f in failed}
                ],
                failed,
                len(pairs),
            )
        finally:
            if runs is None:
                shutil.rmtree(place, ignore_errors=True)
