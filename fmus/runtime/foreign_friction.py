"""Friction FMUs of other generators as friction models: other names and units, one or many points, with or without delay."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, FloatArray
from friction_models.models.domain import Domain

from ..archive.content import read_archive
from ..interface.friction_source import FrictionSource, parse_source
from ..interface.quantities import load_conversion
from .fixed_friction import Evaluation, FmuModel
from .fmu_files import UnpackedFmu, describe
from .friction_names import Entry, FrictionNames, entries_by_model
from .running import FmuError, RunningFmu, Value

#: Two ordinary contact states that differ in all loads: an FMU that answers both alike at once may answer after a step.
_PROBES = ((5.0, 50.0, 500.0, 2.0, 1.1), (200.0, 150.0, 1500.0, 20.0, 3.0))
#: Step that lets such an FMU answer [s], where it names none.
_SHORT = 1e-3
#: Where our own friction FMUs hold their law.
MODEL = "resources/model.onnx"


def friction_model(
    path: str | os.PathLike[str], entry: Entry | None = None, isolate: bool | None = None
) -> FmuModel:
    """Open any friction FMU as a model.

    Parameters
    ----------
    entry : mapping, optional
        Its entry in a file of names (`read_names`).
    isolate : bool, optional
        As of `FmuModel`.

    Raises
    ------
    InputError
        Not an FMU, or one whose variables are neither those of the contract nor named by `entry`.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     model = friction_model(pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python"))
    ...     model.predict([[20.0, 80.0, 600.0, 0.0, 1.0]])
    array([0.1])
    """
    if entry is None:
        with _hinted():
            model = FmuModel(path, isolate)
        if model.source is not None:
            return model
    return ForeignFmu(path, FrictionNames.of(describe(path), entry or {}), isolate)


@contextmanager
def _hinted() -> Iterator[None]:
    """Let an error about variables say what helps."""
    try:
        yield
    except InputError as error:
        if not any(word in str(error) for word in ("variable", "output for")):
            raise
        raise InputError(
            f"{error}; for an FMU with other variables --names FILE.yaml says which takes which load"
        ) from None


@dataclass(frozen=True)
class GivenNames:
    """What a file of names says of the models of a command line.

    Attributes
    ----------
    file : Path or None
        None where there is no such file.
    entries : mapping
        By model (`friction_names.entries_by_model`).
    """

    file: Path | None = None
    entries: Mapping[str, Entry] = field(default_factory=dict)

    @classmethod
    def read(cls, models: Sequence[str], file: Path | None) -> GivenNames:
        """Read the file, if there is one.

        Raises
        ------
        InputError
            What `entries_by_model` refuses.
        """
        return cls() if file is None else cls(file, entries_by_model(models, file))

    def open(self, model: str) -> FmuModel:
        """Return the friction FMU of that name as `friction_model` does; errors in an entry name the file."""
        with self._blamed(model):
            return friction_model(model, self.entries.get(model))

    def foreign(self, model: str) -> FrictionNames | None:
        """Return what `foreign_names` returns; errors in an entry name the file."""
        with self._blamed(model):
            return foreign_names(model, self.entries.get(model))

    @contextmanager
    def _blamed(self, model: str) -> Iterator[None]:
        try:
            yield
        except InputError as error:
            if model not in self.entries:
                raise
            raise InputError(f"{self.file}: {error}") from None


def foreign_names(path: str | os.PathLike[str], entry: Entry | None = None) -> FrictionNames | None:
    """Return the variables of a friction FMU that others made; None for one of ours, which needs no care.

    Raises
    ------
    InputError
        What `FrictionNames.of` refuses.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     foreign_names(pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python")) is None
    True
    """
    described = describe(path)
    if entry is None and MODEL in read_archive(path):
        return None
    with _hinted() if entry is None else nullcontext():
        return FrictionNames.of(described, entry or {})


class ForeignEvaluation(Evaluation):
    """Outputs of a friction FMU with names, units and habits of its own; `folder` holds it where it is unpacked already.

    Points of a data set without time are each evaluated from the start state where the FMU can save it. An FMU whose
    outputs follow its inputs only after a step is given a short one.
    """

    def __init__(self, path: Path, names: FrictionNames, folder: Path | None = None) -> None:
        fmu = UnpackedFmu.of(path, folder)
        inputs = [name for name, _ in names.loads.values()]
        for name in (*inputs, names.mu):
            fmu.check_float64(fmu.resolve(name))
        super().__init__(fmu, inputs, names.mu)
        self.names = names
        if set(LOAD_NAMES) != set(names.loads) or any(
            name != load for load, (name, _) in names.loads.items()
        ):
            self.sizing = None  # arrays under other names keep their length
        self._columns = [LOAD_NAMES.index(load) for load in names.loads]
        units = [load_conversion(q, u, str(path)) if u else (1.0, 0.0) for q, (_, u) in names.loads.items()]
        self._factors, self._offsets = np.array([f for f, _ in units]), np.array([o for _, o in units])
        self._saves = fmu.claims("canGetAndSetFMUState")
        self._short = _short_step(fmu)
        self._late: bool | None = None

    def values(
        self,
        array: FloatArray,
        times: tuple[FloatArray, FloatArray] | None,
        start: dict[str, float],
        outputs: list[str],
    ) -> FloatArray:
        """Return an output as `Evaluation` does; without points only find out whether the FMU answers after a step."""
        if self._late is None:
            try:
                self._late = self._answers_late()
            except FmuError as error:
                raise InputError(f"{self.fmu.path}: the FMU refuses ordinary loads ({error})") from None
        return super().values(array, times, start, outputs) if len(array) else np.empty(0)

    def _answers_late(self) -> bool:
        """Return whether mu follows the loads only after a step."""
        first, second = (np.tile(p, (max(self._width(1), 1), 1)) for p in _PROBES)
        with self._run(self._width(1), {}) as fmu:
            before = self._evaluate(fmu, first, self.outputs)
            now = self._evaluate(fmu, second, self.outputs)
            if not np.array_equal(before, now):
                return False
            fmu.step(0.0, self._short)
            return not np.array_equal(now, fmu.get_real(self.outputs))

    @contextmanager
    def _answering(self, fmu: RunningFmu, outputs: list[str]) -> Iterator[Callable[[FloatArray], FloatArray]]:
        fresh = fmu.save_state() if self._saves else None
        clock = itertools.count()

        def answer(rows: FloatArray) -> FloatArray:
            time = 0.0 if fresh is not None else next(clock) * self._short
            if fresh is not None:
                fmu.restore_state(fresh)
            values = self._evaluate(fmu, rows, outputs)
            if not self._late:
                return values
            fmu.step(time, self._short)
            return fmu.get_real(outputs)

        yield answer
        if fresh is not None:
            fmu.free_state(fresh)

    def in_steps(
        self, array: FloatArray, t: FloatArray, pause: FloatArray, start: dict[str, float], outputs: list[str]
    ) -> FloatArray:
        mu = super().in_steps(array, t, pause, start, outputs)
        if self._late and len(mu):  # the first point is read before any step
            mu[:1] = self.at_once(array[:1], start, outputs)
        return mu

    def _run(self, width: int, start: Mapping[str, Value]) -> RunningFmu:
        return super()._run(width, {**self.names.start, **start})

    def _write(self, fmu: RunningFmu, rows: FloatArray) -> None:
        values = rows[:, self._columns] * self._factors + self._offsets
        fmu.set_real(self.inputs, values.T.ravel())


class ForeignFmu(FmuModel):
    """A friction FMU of another generator with the variables `names`; see `ForeignEvaluation`.

    Raises
    ------
    InputError
        No co-simulation, no binary for this platform, variables of another type, no contact point, or an FMU that
        does not answer ordinary loads.
    """

    def __init__(
        self, path: str | os.PathLike[str], names: FrictionNames, isolate: bool | None = None
    ) -> None:
        super().__init__(path, isolate, ForeignEvaluation, names)
        self.names = names
        self._domain = _recorded_domain(self._fmu.folder / MODEL)
        self._bounds = [[], []]
        self._values(np.empty((0, len(LOAD_NAMES))), None, {}, self._evaluation.outputs)

    def _packed(self, file: Path) -> FrictionSource | None:
        """Return nothing: the variables of the FMU need not be those of a model inside it."""
        return None

    @property
    def domain(self) -> Domain:
        """The trained domain where the FMU holds a model of ours; another generator does not say: the physical limits."""
        return self._domain

    @property
    def needed_loads(self) -> tuple[str, ...]:
        """The loads that enter the FMU."""
        return tuple(n for n in LOAD_NAMES if n in self.names.loads)

    def remark(self) -> str:
        """Return which loads do not enter and which inputs stay as they are; empty where all loads enter."""
        missing = [load for load in LOAD_NAMES if load not in self.names.loads]
        if not missing:
            return ""
        arrays = self._fmu.arrays
        free = [
            f"{n} stays at {v}"
            for n, v in self.names.start.items()
            if n in arrays and arrays[n][0].causality == "input"
        ]
        verb = "does" if len(missing) == 1 else "do"
        return "; ".join([f"{self.path}: {', '.join(missing)} {verb} not enter it", *free])


def _short_step(fmu: UnpackedFmu) -> float:
    """Return a step that lets an FMU answer [s]."""
    try:
        step = float(fmu.raw.defaultExperiment.stepSize)
    except (AttributeError, TypeError, ValueError):
        return _SHORT
    return step if 0.0 < step < 1.0 else _SHORT


def _recorded_domain(model: Path) -> Domain:
    """Return the trained domain that an ONNX file in an FMU records; the physical limits without one."""
    try:
        source = parse_source(model.read_bytes(), str(model)) if model.is_file() else None
    except InputError:
        source = None  # a file of another kind
    return Domain.physical() if source is None else source.box
