"""Press levels of a study: curves of the virtual press or of the user, one job a level."""

from __future__ import annotations

import shutil
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from friction_models.common import InputError, unknown_name

from ..comparison.level_runs import FormingLevel
from ..force_curves.forces import ForceCurve, read_press_curve
from ..jobs.graph import Job, JobResult
from ..jobs.job import Files, Inputs, Needs

#: CPU time of the virtual press by millimetre of stroke of one solver run [s], for estimates.
SECONDS_A_MM = 0.45
#: Folder of press curves in the result of a job.
CURVES = "press"


@dataclass(frozen=True)
class StudyLevel:
    """A press level of a study."""

    lubricant: str
    level: FormingLevel
    file: Path | None = None  # of one's own curves
    synthetic: bool = False  # whether a virtual press made the curves, now or before

    @property
    def job(self) -> str:
        """Name of the job that presses it, or copies one's own curves."""
        return f"press-{self.lubricant}-{self.level.name}"

    def measured(self, results: Mapping[str, JobResult]) -> Sequence[ForceCurve] | None:
        """Return the measured curves; None where their job failed."""
        result = results.get(self.job)
        return None if result is None else read_press_curve(result.file("file"))


def virtual_levels(
    lubricants: Sequence[str],
    conditions: Sequence[tuple[float, float]],
    strokes: Mapping[str, float],
    repeats: int,
    seed: int,
) -> tuple[list[StudyLevel], list[Job]]:
    """Return the levels of the virtual press and the jobs that press them.

    `conditions` are tool temperature [degC] and punch speed [mm/s], `strokes` the punch travel [mm] by process,
    `repeats` the curves a level; the seed is that of the lubricants' laws and of scatter and noise.
    """
    from sct_twin.virtual_lab.press import VirtualPress

    levels: list[StudyLevel] = []
    jobs: list[Job] = []
    parameters = {"T_billet": VirtualPress().T_billet}
    for lubricant in lubricants:
        for process, stroke in strokes.items():
            for T_tool, speed in conditions:
                level = FormingLevel(process, T_tool, speed, stroke, parameters)
                levels.append(StudyLevel(lubricant, level, synthetic=True))
                inputs = {
                    "lubricant": lubricant,
                    "process": process,
                    "T_tool": T_tool,
                    "speed": speed,
                    "stroke": stroke,
                    "repeats": repeats,
                    "seed": seed,
                }
                seconds = 1.0 + (2 if repeats > 1 else 1) * SECONDS_A_MM * stroke
                jobs.append(Job(levels[-1].job, f"{__name__}:press_level", inputs, seconds=seconds))
    return levels, jobs


def press_level(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, object]:
    """Press one level in the virtual laboratory; the function of the jobs of `virtual_levels`."""
    from sct_twin.virtual_lab.law import TrueLaw
    from sct_twin.virtual_lab.press import press_curves

    seed, lubricant = int(inputs["seed"]), str(inputs["lubricant"])
    # Every level scatters in its own way, whichever other levels are pressed.
    scatter = zlib.crc32(
        "/".join(str(inputs[n]) for n in ("seed", "lubricant", "process", "T_tool", "speed")).encode()
    )
    curves = press_curves(
        TrueLaw.draw(None, seed, lubricant),
        [(float(inputs["T_tool"]), float(inputs["speed"]))],
        folder / CURVES,
        processes=[str(inputs["process"])],
        stroke=float(inputs["stroke"]),
        repeats=int(inputs["repeats"]),
        seed=scatter,
        jobs=1,
    )
    return {"file": f"{CURVES}/{curves.levels[0].file}", "synthetic": True}


def copied_level(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, object]:
    """Keep a copy of one's own press curves, so that the folder of the study is whole; the function of `own_levels`."""
    (file,) = files.values()
    (folder / CURVES).mkdir()
    shutil.copyfile(file, folder / CURVES / "level.csv")
    return {"file": f"{CURVES}/level.csv", "synthetic": bool(inputs["synthetic"])}


def chosen_press(texts: Iterable[str] | None) -> list[tuple[str, Path]]:
    """Read what ``--press`` names, ``LUBRICANT=FOLDER`` or a folder; the name is empty where levels.csv gives it."""
    chosen = []
    for text in texts or ():
        name, equals, place = text.partition("=")
        lubricant, path = (name, Path(place)) if equals and not Path(text).exists() else ("", Path(text))
        if not path.is_dir():
            raise InputError(f"--press {text!r}: no such folder {path}; allowed: FOLDER or LUBRICANT=FOLDER")
        chosen.append((lubricant, path))
    return chosen


def own_levels(
    folders: Iterable[tuple[str, Path]], lubricants: Sequence[str], strokes: Mapping[str, float]
) -> tuple[list[StudyLevel], list[Job]]:
    """Return the levels of one's own press curves and the jobs that copy them.

    `folders` hold ``levels.csv``; a name stands for the only lubricant in it. `lubricants` are those that friction
    models are trained for, each of which needs press curves, `strokes` the longest punch travel [mm] by process.
    """
    from forming.press import PressCurves

    from ..cosim.ready_made import STEP

    levels: list[StudyLevel] = []
    jobs: list[Job] = []
    for named, folder in folders:
        press = PressCurves.read(folder)
        inside = list(dict.fromkeys(each.lubricant for each in press.levels))
        if named and len(inside) > 1:
            raise InputError(
                f"--press {named}={folder}: levels.csv holds {', '.join(inside)}; allowed: a single lubricant, or no name"
            )
        for each in press.levels:
            lubricant = named or each.lubricant
            if lubricant not in lubricants:
                raise unknown_name("lubricant", lubricant, lubricants, f"--press {folder}: none of --data")
            level = FormingLevel.of(each, press.info, strokes[each.process], STEP)
            file = Path(folder) / each.file
            item = StudyLevel(lubricant, level, file, each.synthetic)
            if any(other.job == item.job for other in levels):
                raise InputError(
                    f"--press: {level.name} of {lubricant} stands twice; allowed: each level once"
                )
            levels.append(item)
            given = {"synthetic": each.synthetic}
            jobs.append(Job(item.job, f"{__name__}:copied_level", given, {"curves": file}, seconds=0.1))
    for lubricant in lubricants:
        if lubricant not in {item.lubricant for item in levels}:
            raise InputError(
                f"--press: no curves of {lubricant}; allowed: press curves of each lubricant in --data"
            )
    return levels, jobs
