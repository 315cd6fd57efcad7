"""Jobs that form one press level with friction from an FMU; several studies and `compare` share them."""

from __future__ import annotations

import inspect
import math
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict

import numpy as np

from friction_models.common import InputError, unknown_name
from friction_models.loads import FloatArray

from ..force_curves.forces import ForceCurve
from ..jobs.job import Files, Inputs, Job, Needs
from .study_folder import RUN as RUN

if TYPE_CHECKING:
    from forming.press import PressLevel

    from ..cosim.run_folders import Run

#: Start values of a friction FMU, such as ``clamp_to_domain``.
StartValues = Mapping[str, bool | int | float | str]
#: CPU time of a run by millimetre of stroke [s], for estimates.
SECONDS_A_MM = {"fre": 0.25, "bce": 0.25}


class LevelNumbers(TypedDict):
    """What is kept of a run, step by step."""

    stroke: list[float]  # [mm]
    force: list[float]  # [kN]
    work: list[float]  # [J]
    tau_over_k: list[float]  # highest friction stress over shear yield stress
    outside: dict[str, float] | None  # `outside_domain`, None for a friction FMU that does not say
    steps: int
    timing: dict[str, float]


@dataclass(frozen=True)
class FormingLevel:
    """A factor level of the press, as a forming run needs it.

    Examples
    --------
    >>> level = FormingLevel("fre", T_tool=20.0, speed=50.0, stroke=10.0)
    >>> level.name, level.numbers["T_tool"]
    ('fre_50mms_20C', 20.0)
    """

    process: str  # "fre" or "bce"
    T_tool: float  # [degC]
    speed: float  # of the punch [mm/s]
    stroke: float  # of the punch [mm]
    parameters: Mapping[str, float | str] = field(default_factory=dict)  # others of the process

    @classmethod
    def of(cls, level: PressLevel, info: Mapping[str, object], stroke: float, step: float) -> FormingLevel:
        """Return the level of press curves, with a stroke that record and process allow, in whole steps [mm].

        `info` is that of the press curves: ``process`` and ``T_billet_degC`` say what differs from the default.
        """
        recorded = max(1, round(float(level.curves["stroke"].max()) / step)) * step
        values = info.get("process", {})
        if not isinstance(values, Mapping):
            raise InputError(f"press.json: process = {values!r:.60}; allowed: parameters by name")
        values = dict(values)
        if "T_billet_degC" in info:
            values["T_billet"] = info["T_billet_degC"]
        whole = cls(level.process, level.T_tool, level.speed, 0.0, values)
        try:
            farthest = whole.farthest(step)
        except InputError as error:
            raise InputError(f"press level {level.file}: {error}") from None
        return replace(whole, stroke=min(stroke, recorded, farthest))

    @property
    def name(self) -> str:
        """Name in files, ``fre_5mms_20C``."""
        return f"{self.process}_{self.speed:g}mms_{self.T_tool:g}C"

    @property
    def numbers(self) -> dict[str, Any]:
        """Parameters of the process, speed and tool temperature among them."""
        return {**self.parameters, "speed": self.speed, "T_tool": self.T_tool}

    def farthest(self, step: float) -> float:
        """Return how far the punch can go, in whole steps [mm]: a record holds the give of the press, too."""
        return math.floor(float(self.forming().max_stroke) / step + 1e-6) * step

    def forming(self) -> Any:
        """Return the forming process with these parameters, each of which it must have."""
        from forming.processes.names import PROCESSES

        solver: Any = PROCESSES[self.process]
        known = inspect.signature(solver).parameters
        for name in self.parameters:
            if name not in known:
                raise unknown_name(f"parameter of {solver.__name__}", str(name), known)
        return solver(**self.numbers)


def level_job(
    name: str,
    level: FormingLevel,
    friction: Path | str,
    *,
    mode: str = "gauss_seidel",
    step: float | None = None,
    tolerance: float | None = None,
    start: StartValues | None = None,
    names: Mapping[str, object] | None = None,
    keep: Literal["summary", "run"] = "summary",
    synthetic: bool = False,
    label: str = "",
) -> Job:
    """Return the job that forms a level.

    `friction` is a friction FMU, or the name of the job that made it (its value ``fmu`` is the file in its folder);
    `names` are its variables, where they have other names than the loads: `FrictionNames.to_dict`. The FMUs are coupled
    in a `mode` (that of `tolerance` is ``iterated``), a `step` [mm] is the stroke between two exchanges.

    With `keep` ``"run"`` the run folder stays as ``run`` in the folder of the result. Such a run says whether its friction
    model comes from a virtual laboratory (`synthetic`), and names it by its `label`, which decides nothing else.

    Examples
    --------
    >>> job = level_job("run", FormingLevel("fre", T_tool=20.0, speed=50.0, stroke=10.0), Path("law.fmu"))
    >>> job.function.rpartition(":")[2], job.inputs["mode"]
    ('run_level', 'gauss_seidel')
    """
    from ..cosim.ready_made import STEP

    inputs = level_inputs(level, mode, STEP if step is None else step, start) | {"keep": keep}
    if tolerance is not None:
        inputs["tolerance"] = tolerance
    if names is not None:
        inputs["names"] = dict(names)
    if keep == "run":
        inputs |= {"synthetic": synthetic, "label": label}
    files = {"friction": friction} if isinstance(friction, Path) else {}
    needs = (friction,) if isinstance(friction, str) else ()
    seconds = 1.0 + SECONDS_A_MM.get(level.process, 0.25) * level.stroke
    return Job(name, f"{__name__}:run_level", inputs, files, needs, seconds)


def level_inputs(level: FormingLevel, mode: str, step: float, start: StartValues | None) -> dict[str, object]:
    """Return what every job that forms a level gets: level, mode, step [mm] and start values of the friction FMU."""
    return {
        "level": asdict(level) | {"parameters": dict(level.parameters)},
        "mode": mode,
        "step": step,
        "start": dict(start or {}),
    }


def run_level(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> LevelNumbers:
    """Form a level; the function of `level_job`."""
    run = simulate_level(inputs, friction_file(files, needs), folder / RUN)
    values = summary(run)
    if inputs["keep"] != "run":
        shutil.rmtree(folder / RUN)
        forming_file(inputs, folder).unlink()
    return values


def friction_file(files: Files, needs: Needs) -> Path:
    """Return the friction FMU that a job was given: a file, or the result of another job."""
    if "friction" in files:
        return files["friction"]
    (result,) = needs.values()
    return result.file("fmu")


def forming_file(inputs: Inputs, folder: Path) -> Path:
    """Return where the forming FMU of a run lies: beside the run folder, so that it can be simulated again."""
    return folder / f"{inputs['level']['process']}.fmu"


def simulate_level(inputs: Inputs, friction: Path, folder: Path) -> Run:
    """Form the level of `inputs` (see `level_job`) into a run folder, with the forming FMU beside it; return the run."""
    from fmus import pack_forming
    from fmus.runtime.fmu_files import describe
    from fmus.runtime.friction_names import FrictionNames

    from ..cosim.iteration import TOLERANCE
    from ..cosim.master import Master
    from ..cosim.ready_made import extrusion_system

    level = FormingLevel(**inputs["level"])
    forming = forming_file(inputs, folder.parent)
    pack_forming(forming, process=level.process, **level.numbers)
    label, names = str(inputs.get("label", "")), inputs.get("names")
    system = extrusion_system(
        friction,
        forming,
        level.speed,
        level.stroke,
        f"{level.name}, {label}" if label else level.name,
        bool(inputs.get("synthetic", False)),
        {"friction": label} if label else {},
        step=float(inputs["step"]),
        start=inputs["start"],
        names=None if names is None else FrictionNames.from_dict(names),
    )
    if "domain_distance" not in describe(friction).arrays:
        system.record = [name for name in system.record or [] if name != "friction.domain_distance"]
    tolerance = float(inputs.get("tolerance", TOLERANCE))
    return Master(system, mode=str(inputs["mode"]), tolerance=tolerance).run(folder)


def outside_domain(distance: FloatArray) -> dict[str, float]:
    """Return the share of contact points outside the trained domain, and their median distance from it.

    Examples
    --------
    >>> outside_domain(np.array([0.0, 0.0, 0.0, 0.5]))
    {'share': 0.25, 'median_distance': 0.5}
    """
    beyond = distance[distance > 0.0]
    return {
        "share": len(beyond) / max(len(distance), 1),
        "median_distance": float(np.median(beyond)) if len(beyond) else 0.0,
    }


def summary(run: Run) -> LevelNumbers:
    """Return what `run_level` keeps of a run."""
    active = run["forming.active"] > 0.5
    outside: dict[str, float] | None = None
    if "friction.domain_distance" in run.values:
        outside = outside_domain(run["friction.domain_distance"][active])
    return {
        "stroke": run["forming.stroke"].tolist(),
        "force": run["forming.force"].tolist(),
        "work": run["forming.work"].tolist(),
        "tau_over_k": run["forming.max_tau_over_k"].tolist(),
        "outside": outside,
        "steps": int(run.manifest["steps"]),
        "timing": {name: float(seconds) for name, seconds in run.manifest["timing_s"].items()},
    }


def force_curve(values: Mapping[str, Sequence[float]]) -> ForceCurve:
    """Return the force over stroke of a run, from its `LevelNumbers`."""
    return ForceCurve(np.array(values["stroke"]), np.array(values["force"]))
