"""The trials of `check`. They run in a second process, which may crash or hang."""

from __future__ import annotations

import contextlib
import json
import os
import re
import sys
from pathlib import Path

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, FloatArray

from ..archive.content import read_description
from ..archive.limits import limit_memory
from ..runtime.fmu_files import UnpackedFmu
from ..runtime.running import FmuError, RunningFmu
from .report import Notes
from .trial_binaries import binaries
from .trial_exchange import exchange
from .trial_friction import friction, random_loads
from .trial_map import maps
from .trial_recorded import recorded
from .trial_units import units

#: Problems of a description that are told, and variables up to which fmpy's validation ends in a minute or so, also
#: where its time grows with the square of their number because all of them are wrong.
_MAX_PROBLEMS, _MAX_VALIDATED = 20, 100_000
#: Structured variable names as both versions of the standard define them.
_PART = r"(?:[A-Za-z_]\w*|'(?:[^'\\]|\\.)+')(?:\[\d+(?:,\d+)*\])?"
_NAME = re.compile(rf"{_PART}(?:\.{_PART})*|der\({_PART}(?:\.{_PART})*(?:,\d+)?\)", re.ASCII)
#: Steps of one run.
STEPS = 5


def run(path: Path, notes: Notes) -> None:
    """Run all trials of one FMU."""

    def failed(error: Exception) -> None:
        notes.add(False, str(error).replace(f"{path}: ", ""))

    notes.group = "model description"
    _schema(path, notes)
    try:
        fmu = UnpackedFmu.of(path)
    except InputError as error:
        failed(error)
        return
    units(fmu, notes)
    notes.group = "platforms"
    if not binaries(fmu, notes):
        return
    for group, trial in (
        ("co-simulation", _steps),
        ("friction", friction),
        ("model exchange", exchange),
        ("reference results", recorded),
        ("maps", maps),
    ):
        notes.group = group
        try:
            trial(fmu, notes)
        except (FmuError, InputError) as error:
            failed(error)


def problems_of(path: Path) -> list[str]:
    """Return what fmpy's validation finds; its check of names, 3 ms each, is made here."""
    from fmpy import read_model_description
    from fmpy.model_description import ValidationError

    try:
        description = read_model_description(
            str(path), validate=True, validate_variable_names=False, validate_model_structure=True
        )
    except ValidationError as error:
        return [str(problem) for problem in error.problems]
    except Exception as error:  # fmpy raises plain exceptions
        return [str(error) or type(error).__name__]
    structured = description.variableNamingConvention == "structured"
    return [
        f"variable name {v.name[:80]!r} is not allowed by the naming convention of the FMU"
        for v in description.modelVariables
        if (not _NAME.fullmatch(v.name) if structured else re.search(r"[\r\n\t]", v.name))
    ]


def _schema(path: Path, notes: Notes) -> None:
    count = sum(1 for _ in read_description(path).iterfind("ModelVariables/*"))
    if count > _MAX_VALIDATED:
        text = f"schema and semantics: {count} variables, at most {_MAX_VALIDATED} are validated"
        notes.note("skipped", text)
        return
    problems = problems_of(path)
    notes.add(not problems, "schema and semantics (fmpy)")
    for problem in problems[:_MAX_PROBLEMS]:
        notes.add(False, str(problem))
    if len(problems) > _MAX_PROBLEMS:
        notes.add(False, f"... and {len(problems) - _MAX_PROBLEMS} more problems")


class Play:
    """A few steps of an FMU, with random loads where it is a friction FMU."""

    def __init__(self, fmu: UnpackedFmu) -> None:
        self.outputs = [n for n, v in fmu.variables.items() if v.causality == "output" and v.is_float64]
        experiment = fmu.raw.defaultExperiment
        self.size = 0.01
        with contextlib.suppress(TypeError, ValueError):
            if experiment is not None and float(experiment.stepSize) > 0.0:
                self.size = float(experiment.stepSize)
        self.inputs: list[str] = []
        self.series: FloatArray = np.empty((0, 0))
        if fmu.is_friction:
            points = fmu.contact_points()
            self.inputs = list(LOAD_NAMES)
            rng = np.random.default_rng(2)
            self.series = np.array([random_loads(rng, points).T.ravel() for _ in range(STEPS + 2)])

    def steps(self, fmu: RunningFmu, count: int = STEPS, first: int = 0) -> FloatArray:
        """Make `count` steps from step `first` on, return the outputs, shape (count, outputs)."""
        seen = []
        for k in range(first, first + count):
            if self.inputs:
                fmu.set_real(self.inputs, self.series[k])
            fmu.step(k * self.size, self.size)
            seen.append(fmu.get_real(self.outputs))
        return np.array(seen)


def _steps(fmu: UnpackedFmu, notes: Notes) -> None:
    """Play a few steps, twice, and with the FMU state taken and set."""
    if fmu.raw.coSimulation is None:
        notes.note("skipped", "not offered")
        return
    alone = fmu.claims("canBeInstantiatedOnlyOncePerProcess")
    play = Play(fmu)
    with RunningFmu(fmu, "first") as first:
        notes.add(True, "loads and starts in a second process")
        mine = play.steps(first)
        if not alone:
            with RunningFmu(fmu, "second") as second:
                again = play.steps(second, count=3)
            notes.add(_equal(mine[:3], again), "a second instance repeats the first exactly")
        _state(first, play, notes)
    with RunningFmu(fmu, "again") as first:
        if alone:
            repeated = _equal(mine[:3], play.steps(first, count=3))
            notes.add(repeated, "a repeated run gives the same exactly")
        else:
            play.steps(first, count=1)
        first.reset()
        repeated = _equal(mine[:3], play.steps(first, count=3))
        notes.add(repeated, "a reset instance repeats the run exactly")
    _refusal(fmu, notes)


def _state(fmu: RunningFmu, play: Play, notes: Notes) -> None:
    if not fmu.fmu.claims("canGetAndSetFMUstate"):
        notes.note("skipped", "FMU state: not claimed")
        return
    state = fmu.save_state()
    ahead = play.steps(fmu, count=2, first=STEPS)
    fmu.restore_state(state)
    notes.add(_equal(ahead, play.steps(fmu, count=2, first=STEPS)), "FMU state: exact replay")
    if fmu.fmu.claims("canSerializeFMUstate"):
        read = fmu.deserialize(fmu.serialize(state))
        fmu.restore_state(read)
        replay = play.steps(fmu, count=2, first=STEPS)
        notes.add(_equal(ahead, replay), "FMU state: exact replay after serialization")
        fmu.free_state(read)
    fmu.free_state(state)


def _refusal(fmu: UnpackedFmu, notes: Notes) -> None:
    """NaN must be refused by our FMUs and friction FMUs; for other FMUs the answer is only noted."""
    names = [v.own for v in fmu.variables.values() if v.causality == "input" and v.is_float64]
    if not names:
        return
    name = names[-1]
    ours = fmu.is_friction or str(fmu.raw.generationTool).startswith("tribofmu")
    with RunningFmu(fmu, "refusal") as running:
        try:
            running.set({name: np.nan})
        except FmuError as error:
            notes.add(
                not ours or name.partition("[")[0] in str(error),
                f"NaN is refused with a message that names the variable ({error})",
            )
        else:
            notes.note("failed" if ours else "noted", f"NaN as {name!r} is accepted, better: an error")


def _equal(a: FloatArray, b: FloatArray) -> bool:
    return np.array_equal(a, b, equal_nan=True)


def record(path: Path, result: Path) -> None:
    """Run all trials of one FMU; the findings go to the file `result`, which says at its end that it is whole."""
    run(path, Notes(result))
    with result.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(["end", "", ""]) + "\n")


def main() -> None:
    """Check the FMU of the first argument; findings go to the file of the second; memory of the third."""
    limit_memory(int(sys.argv[3]))
    record(Path(sys.argv[1]), Path(sys.argv[2]))
    # The libraries of the FMU are unloaded: how Python and those of the check itself end says nothing of it.
    os._exit(0)
