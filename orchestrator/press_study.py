"""Friction models on press curves: each one runs in the forming process of every level."""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .fmu_files import describe
from .forces import LevelsComparison, compare_force, read_press_curve
from .jobs import RunTask, run_all
from .processes import STEP, STROKE, extrusion_system
from .system import System

if TYPE_CHECKING:
    from forming.press import PressCurves, PressLevel

Progress = Callable[[int, int, str], None]


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
    ) -> list[LevelsComparison]:
        """Run every model on every level and compare the forces.

        Parameters
        ----------
        models : mapping of str to str
            Label and model folder, ``.fmu`` or ``.onnx`` file, or a number for constant mu.
        runs : Path, optional
            Where FMUs and run folders are kept; a temporary folder by default.
        """
        place = runs if runs is not None else Path(tempfile.mkdtemp(prefix="tribofmu-study-"))
        try:
            place.mkdir(parents=True, exist_ok=True)
            forming = [self._forming_fmu(level, place) for level in self.press.levels]
            # Processes differ in their number of markers: a friction FMU for each.
            nodes = [len(describe(fmu).resolve("mu")) for fmu in forming]
            frictions = {
                (label, count): friction_fmu(name, place / f"friction-{number}-{count}.fmu", count)
                for number, (label, name) in enumerate(models.items(), 1)
                for count in sorted(set(nodes))
            }
            tasks = [
                RunTask(self._system(frictions[label, count], fmu, level, label), place / f"{Path(level.file).stem}-{number}")
                for number, label in enumerate(models, 1)
                for level, fmu, count in zip(self.press.levels, forming, nodes)
            ]  # fmt: skip
            finished = iter(run_all(tasks, jobs, progress))
            return [
                LevelsComparison(
                    label,
                    tuple(
                        compare_force(next(finished).force_curve(), read_press_curve(self.folder / level.file), label)
                        for level in self.press.levels
                    ),
                )
                for label in models
            ]  # fmt: skip
        finally:
            if runs is None:
                shutil.rmtree(place, ignore_errors=True)

    def _forming_fmu(self, level: PressLevel, place: Path) -> Path:
        from fmus import pack_forming

        target = place / f"{Path(level.file).stem}.fmu"
        return pack_forming(target, process=level.process, **self._parameters(level))

    def _parameters(self, level: PressLevel) -> dict[str, Any]:
        values = dict(self.press.info.get("process", {}))
        if "T_billet_degC" in self.press.info:
            values["T_billet"] = float(self.press.info["T_billet_degC"])
        return values | {"speed": level.speed, "T_tool": level.T_tool}

    def _max_stroke(self, level: PressLevel) -> float:
        """Return how far the punch can go, in whole steps: the recorded travel holds the give of the press, too."""
        from forming import BackwardCupExtrusion, ForwardRodExtrusion

        solver = {"fre": ForwardRodExtrusion, "bce": BackwardCupExtrusion}[level.process]
        return math.floor(solver(**self._parameters(level)).max_stroke / STEP + 1e-6) * STEP

    def _system(self, friction: Path, forming: Path, level: PressLevel, label: str) -> System:
        recorded = max(1, round(float(level.curves["stroke"].max()) / STEP)) * STEP
        stroke = min(STROKE, recorded, self._max_stroke(level))
        name = f"{Path(level.file).stem}, {label}"
        remarks = {"friction": label, "level": level.file}
        return extrusion_system(friction, forming, level.speed, stroke, name, self.synthetic, remarks)


def friction_fmu(model: str, target: Path, nodes: int) -> Path:
    """Return the friction FMU of a model folder, an ONNX file or a number; an FMU is taken as it is."""
    import fmus

    if Path(model).suffix == ".fmu":
        describe(model)
        return Path(model)
    try:
        constant = float(model)
    except ValueError:
        return fmus.pack(Path(model), target, nodes=nodes)
    from friction_models import ConstantFriction

    return fmus.pack(ConstantFriction(constant), target, nodes=nodes)
