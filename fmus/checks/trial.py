"""The part of `check` that happens in a second process, so that a crash or an endless loop stays outside."""

from __future__ import annotations

import contextlib
import json
import os
import re
import sys
from pathlib import Path

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOADS, FloatArray

from ..archive.content import read_description
from ..runtime.running import FmuError, RunningFmu
from ..runtime.unpacked import UnpackedFmu

#: Largest file that it may write [bytes].
_FILE_LIMIT = 1024**3
_STEPS = 5
#: Problems of a description that are told, and variables up to which fmpy's validation ends in a minute or so, also
#: where its time grows with the square of their number because all of them are wrong.
_MAX_PROBLEMS, _MAX_VALIDATED = 20, 100_000


class Notes:
    """Findings are written one by one: what was found before a crash is kept."""

    def __init__(self, result: Path) -> None:
        self.result = result
        self.group = "archive"

    def add(self, good: bool, text: str) -> None:
        """Write what went well or not."""
        self.note("passed" if good else "failed", text)

    def note(self, outcome: str, text: str) -> None:
        """Write a finding with its outcome."""
        line = json.dumps([outcome, self.group, " ".join(text.split())[:600]])
        with self.result.open("a", encoding="utf-8") as stream:
            stream.write(line + "\n")


class Trial:
    """All trials of one FMU.

    Parameters
    ----------
    path, result : path-like
        The FMU, and the file that findings are written to.
    """

    def __init__(self, path: Path, result: Path) -> None:
        self.path = path
        self.notes = Notes(result)

    def run(self) -> None:
        """Run all trials."""
        from .trial_binaries import binaries
        from .trial_exchange import exchange
        from .trial_friction import friction
        from .trial_recorded import recorded
        from .trial_units import units

        self.notes.group = "model description"
        self._schema()
        try:
            fmu = UnpackedFmu(self.path)
        except InputError as error:
            self.notes.add(False, self._text(error))
            return
        units(fmu, self.notes)
        self.notes.group = "platforms"
        here = binaries(fmu, self.notes)
        if not here:
            return
        for group, trial in (
            ("co-simulation", self._run),
            ("friction", friction),
            ("model exchange", exchange),
            ("reference results", recorded),
        ):
            self.notes.group = group
            try:
                trial(fmu, self.notes)
            except (FmuError, InputError) as error:
                self.notes.add(False, self._text(error))

    def _text(self, error: BaseException) -> str:
        return str(error).replace(f"{self.path}: ", "")

    def _schema(self) -> None:
        count = sum(1 for _ in read_description(self.path).iterfind("ModelVariables/*"))
        if count > _MAX_VALIDATED:
            text = f"schema and semantics: {count} variables, at most {_MAX_VALIDATED} are validated"
            self.notes.note("skipped", text)
            return
        problems = problems_of(self.path)
        self.notes.add(not problems, "schema and semantics (fmpy)")
        for problem in problems[:_MAX_PROBLEMS]:
            self.notes.add(False, str(problem))
        if len(problems) > _MAX_PROBLEMS:
            self.notes.add(False, f"... and {len(problems) - _MAX_PROBLEMS} more problems")

    def _run(self, fmu: UnpackedFmu, notes: Notes) -> None:
        """Play a few steps, twice, and with the FMU state taken and set."""
        if fmu.description.coSimulation is None:
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
            self._state(first, play, notes)
        with RunningFmu(fmu, "again") as first:
            if alone:
                notes.add(
                    _equal(mine[:3], play.steps(first, count=3)), "a repeated run gives the same exactly"
                )
            else:
                play.steps(first, count=1)
            first.reset()
            notes.add(
                _equal(mine[:3], play.steps(first, count=3)), "a reset instance repeats the run exactly"
            )
        self._refusal(fmu, notes)

    def _state(self, fmu: RunningFmu, play: Play, notes: Notes) -> None:
        if not fmu.fmu.claims("canGetAndSetFMUstate"):
            notes.note("skipped", "FMU state: not claimed")
            return
        state = fmu.save()
        ahead = play.steps(fmu, count=2, first=_STEPS)
        fmu.restore(state)
        notes.add(_equal(ahead, play.steps(fmu, count=2, first=_STEPS)), "FMU state: exact replay")
        if fmu.fmu.claims("canSerializeFMUstate"):
            read = fmu.through_bytes(state)
            fmu.restore(read)
            replay = play.steps(fmu, count=2, first=_STEPS)
            notes.add(_equal(ahead, replay), "FMU state: exact replay after serialization")
            fmu.release(read)
        fmu.release(state)

    def _refusal(self, fmu: UnpackedFmu, notes: Notes) -> None:
        """NaN must be refused by our FMUs and friction FMUs; of others it is told."""
        names = [n for n, v in fmu.variables.items() if v.causality == "input" and v.type == fmu.real]
        if not names:
            return
        name = names[-1]
        ours = fmu.is_friction() or str(fmu.description.generationTool).startswith("tribofmu")
        with RunningFmu(fmu, "refusal") as running:
            try:
                running.set_real([name], np.full(running.count([name]), np.nan))
            except FmuError as error:
                notes.add(
                    not ours or name.partition("[")[0] in str(error),
                    f"NaN is refused with a message that names the variable ({error})",
                )
            else:
                notes.note("failed" if ours else "noted", f"NaN as {name!r} is accepted, better: an error")


#: Structured variable names as both versions of the standard define them.
_PART = r"(?:[A-Za-z_]\w*|'(?:[^'\\]|\\.)+')(?:\[\d+(?:,\d+)*\])?"
_NAME = re.compile(rf"{_PART}(?:\.{_PART})*|der\({_PART}(?:\.{_PART})*(?:,\d+)?\)", re.ASCII)


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


class Play:
    """A few steps of an FMU, with random loads where it is a friction FMU."""

    def __init__(self, fmu: UnpackedFmu) -> None:
        self.outputs = [n for n, v in fmu.variables.items() if v.causality == "output" and v.type == fmu.real]
        experiment = fmu.description.defaultExperiment
        self.size = 0.01
        with contextlib.suppress(TypeError, ValueError):
            if experiment is not None and float(experiment.stepSize) > 0.0:
                self.size = float(experiment.stepSize)
        self.inputs: list[str] = []
        self.series: FloatArray = np.empty((0, 0))
        if fmu.is_friction():
            names = fmu.friction()
            self.inputs = [n for q in LOADS for n in names[q.name]]
            points = sum(fmu.length(n) for n in names["mu"])
            rng = np.random.default_rng(2)
            self.series = np.array([random_loads(rng, points).T.ravel() for _ in range(_STEPS + 2)])

    def steps(self, fmu: RunningFmu, count: int = _STEPS, first: int = 0) -> FloatArray:
        """Make `count` steps from step `first` on, return the outputs, shape (count, outputs)."""
        seen = []
        for k in range(first, first + count):
            if self.inputs:
                fmu.set_real(self.inputs, self.series[k])
            fmu.step(k * self.size, self.size)
            seen.append(fmu.get_real(self.outputs))
        return np.array(seen)


def random_loads(rng: np.random.Generator, count: int) -> FloatArray:
    """Return loads between slow, cold, light and fast, hot, heavy contact, shape (count, 5)."""
    lower, upper = [0.0, 20.0, 100.0, 0.0, 0.8], [600.0, 500.0, 3000.0, 80.0, 25.0]
    return rng.uniform(lower, upper, size=(count, 5))


def _equal(a: FloatArray, b: FloatArray) -> bool:
    return np.array_equal(a, b, equal_nan=True)


def limit_memory(most: int) -> None:
    """Bound what this process may take [bytes], where the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    with contextlib.suppress(ValueError, OSError):
        most = min(most, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") * 3 // 4)
    # RLIMIT_DATA counts what is written to, not what libraries reserve without using it.
    for kind, value in (
        (resource.RLIMIT_DATA, most),
        (resource.RLIMIT_FSIZE, _FILE_LIMIT),
        (resource.RLIMIT_CORE, 0),
    ):
        with contextlib.suppress(ValueError, OSError):
            _, hard = resource.getrlimit(kind)
            value = value if hard == resource.RLIM_INFINITY else min(value, hard)
            resource.setrlimit(kind, (value, value))


def main() -> None:
    """Check the FMU of the first argument; findings go to the file of the second; memory of the third."""
    limit_memory(int(sys.argv[3]))
    path, result = Path(sys.argv[1]), Path(sys.argv[2])
    Trial(path, result).run()
    with result.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(["end", "", ""]) + "\n")
