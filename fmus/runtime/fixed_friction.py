"""A friction FMU as a fixed friction model: `predict` through the FMU itself, ours or that of another generator."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, MU, FloatArray, TriboLoads, require_loads
from friction_models.loads.time_steps import rests, time_steps
from friction_models.models.domain import Domain

from ..archive.made_here import runs_apart
from ..interface.friction_source import FrictionSource, parse_source
from ..interface.quantities import load_conversion
from .fmu_files import UnpackedFmu
from .friction_names import FrictionNames
from .running import FmuError, RunningFmu, Value
from .separate_process import Apart, Died

if TYPE_CHECKING:  # co-simulation names FMUs of others without pandas
    import pandas as pd

#: Most points of one evaluation of an FMU whose size can be chosen.
_BLOCK = 1024
#: Two ordinary contact states that differ in all loads: an FMU that answers both alike at once may answer after a step.
_PROBES = ((5.0, 50.0, 500.0, 2.0, 1.1), (200.0, 150.0, 1500.0, 20.0, 3.0))
#: Step that lets such an FMU answer [s], where it names none.
_SHORT = 1e-3
#: Where our own friction FMUs hold their law.
MODEL = "resources/model.onnx"


class Evaluation:
    """Outputs of a friction FMU at loads; `folder` holds it where it is unpacked already.

    Without names it is one with the variables of the contract. Of one with names, units and habits of its own the points
    of a data set without time are each evaluated from the start state where the FMU can save it, and where outputs
    follow inputs only after a step, it is given a short one.
    Raises InputError: variables that do not fit, no co-simulation, or no contact point.
    """

    def __init__(self, path: Path, names: FrictionNames | None = None, folder: Path | None = None) -> None:
        self.fmu = fmu = UnpackedFmu.of(path, folder)
        self.names = FrictionNames() if names is None else names
        loads = self.names.loads
        self.inputs, self.outputs = [name for name, _ in loads.values()], [self.names.mu]
        if names is None:
            fmu.contact_points()
        for name in (*self.inputs, *self.outputs):
            fmu.check_float64(fmu.resolve(name))
        if fmu.raw.coSimulation is None:
            raise InputError(f"{fmu.path}: the FMU offers no co-simulation, allowed: an FMU that does")
        self.nodes = len(fmu.resolve(self.names.mu))
        if self.nodes < 1:
            raise InputError(f"{fmu.path}: the FMU has no contact point, allowed: at least one")
        #: The parameter that gives the arrays their length; those under other names keep theirs.
        ours = set(loads) == set(LOAD_NAMES) and all(name == load for load, (name, _) in loads.items())
        self.sizing = fmu.sizing(LOAD_NAMES[0]) if ours else None
        self._sized: dict[int, UnpackedFmu] = {}
        self._columns = [LOAD_NAMES.index(load) for load in loads]
        units = [load_conversion(q, u, str(path)) if u else (1.0, 0.0) for q, (_, u) in loads.items()]
        self._factors, self._offsets = np.array([f for f, _ in units]), np.array([o for _, o in units])
        self._saves = names is not None and fmu.claims("canGetAndSetFMUState")
        self._short = _short_step(fmu)
        #: Whether mu follows the loads only after a step; None: not known yet.
        self._late = None if names is not None else False

    def values(
        self,
        array: FloatArray,
        times: tuple[FloatArray, FloatArray] | None,
        start: dict[str, float],
        outputs: list[str],
    ) -> FloatArray:
        """Return an output at points of a test, with their times and pauses, or at points without time.

        Without points it only finds out whether the FMU answers after a step.
        """
        if self._late is None:
            try:
                self._late = self._answers_late()
            except FmuError as error:
                raise InputError(f"{self.fmu.path}: the FMU refuses ordinary loads ({error})") from None
        if not len(array):
            return np.empty(0)
        if times is None:
            return self.at_once(array, start, outputs)
        return self.in_steps(array, *times, start, outputs)

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

    def at_once(self, array: FloatArray, start: dict[str, float], outputs: list[str]) -> FloatArray:
        """Return an output at points that do not follow each other in time."""
        mu = np.empty(len(array))
        width = self._width(len(array))
        with self._run(width, start) as fmu:
            fresh = fmu.save_state() if self._saves else None
            time = 0.0
            for first in range(0, len(array), width):
                if fresh is not None:
                    fmu.restore_state(fresh)
                    time = 0.0
                rows = np.minimum(np.arange(first, first + width), len(array) - 1)
                values = self._evaluate(fmu, array[rows], outputs)
                if self._late:
                    fmu.step(time, self._short)
                    time += self._short
                    values = fmu.get_real(outputs)
                count = min(width, len(array) - first)
                mu[first : first + count] = values[:count]
            if fresh is not None:
                fmu.free_state(fresh)
        return mu

    def in_steps(
        self,
        array: FloatArray,
        t: FloatArray,
        pause: FloatArray,
        start: dict[str, float],
        outputs: list[str],
    ) -> FloatArray:
        """Return an output all through one test; its memory starts fresh. Before a point the contact stood still for `pause` [s]."""
        mu = np.empty(len(array))
        width = self._width(1)
        with self._run(width, start) as fmu:
            for row in range(len(array)):
                # The loads of a point act over the interval that ends there, then mu is read.
                rows = np.tile(array[row], (width, 1))
                if row:
                    time = float(t[row - 1] - t[0])
                    if pause[row] > 0.0:
                        still = rows.copy()
                        still[:, LOAD_NAMES.index("v_rel")] = 0.0
                        self._write(fmu, still)
                        fmu.step(time, float(pause[row]))
                        time += float(pause[row])
                    self._write(fmu, rows)
                    fmu.step(time, float(t[row] - t[0]) - time)
                mu[row] = self._evaluate(fmu, rows, outputs)[0]
        if self._late:  # the first point is read before any step
            mu[:1] = self.at_once(array[:1], start, outputs)
        return mu

    def _width(self, count: int) -> int:
        """Return how many points are evaluated at once: what fits best where the FMU lets us choose."""
        if self.sizing is None:
            return self.nodes
        lower, upper = self.fmu.limits(self.sizing)
        return max(lower, 1, min(count, _BLOCK if upper is None else upper, _BLOCK))

    def _run(self, width: int, start: Mapping[str, Value]) -> RunningFmu:
        if self.sizing is not None and width not in self._sized:
            self._sized[width] = self.fmu.sized({self.sizing: width})
        return RunningFmu(self._sized.get(width, self.fmu), start={**self.names.start, **start})

    def _write(self, fmu: RunningFmu, rows: FloatArray) -> None:
        values = rows[:, self._columns] * self._factors + self._offsets
        fmu.set_real(self.inputs, values.T)

    def _evaluate(self, fmu: RunningFmu, rows: FloatArray, outputs: list[str]) -> FloatArray:
        self._write(fmu, rows)
        return fmu.get_real(outputs)


class Elsewhere:
    """The same evaluation in a process of its own, which starts with the first question and again after a crash.

    The folder is that of this process: one that crashes cannot tidy up.
    """

    def __init__(self, path: Path, names: FrictionNames | None, folder: Path) -> None:
        self._path = path
        self._arguments = (path, names, folder)
        self._apart: Apart | None = None

    def values(self, *arguments: Any) -> FloatArray:
        """Return what `Evaluation.values` returns there.

        Raises FmuError: the FMU refuses a value, or ends its process.
        """
        if self._apart is None:
            self._apart = Apart(Evaluation, *self._arguments, errors=(FmuError,))
        try:
            return np.asarray(self._apart.call("values", *arguments), dtype=float)
        except Died as end:
            self._apart = None
            raise FmuError(f"{self._path}: {end}") from None


class FmuModel:
    """The law inside a friction FMU, ours or a foreign one with the same variables.

    It cannot be refitted. Loads with time are stepped through test by test from a fresh state, so
    that memory acts; without time a foreign FMU is evaluated at its start state. System variables
    that the tests record are set for each test.

    Parameters
    ----------
    path : path-like
        FMU for co-simulation (FMI 2.0 or 3.0) with the inputs ``v_rel T sigma_n sd psi`` and the output
        ``mu``: scalars, scalars named ``v_rel[1]`` ..., or arrays.
    isolate : bool, optional
        Run it in a process of its own, where a crash does no harm; by default where it was not made here (`made_here`).
    names : FrictionNames, optional
        Variables of an FMU that others made; see `Evaluation`.

    Raises
    ------
    InputError
        Not an FMU, or not one with these variables and units; with the nearest name. With `names` an FMU that does not
        answer ordinary loads.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     model = FmuModel(pack(ConstantFriction(mu=0.1), Path(place) / "friction.fmu", target="python"))
    ...     model.predict([[20.0, 80.0, 600.0, 0.0, 1.0], [40.0, 80.0, 600.0, 0.0, 1.0]])
    array([0.1, 0.1])
    """

    family = "fmu"
    is_fitted = True

    def __init__(
        self, path: str | os.PathLike[str], isolate: bool | None = None, names: FrictionNames | None = None
    ) -> None:
        self.path = Path(path)
        apart = runs_apart(self.path, isolate)
        self._evaluation = Evaluation(self.path, names)
        self._fmu = self._evaluation.fmu
        self._elsewhere = Elsewhere(self.path, names, self._fmu.folder) if apart else None
        self.names = names
        self.nodes = self._evaluation.nodes
        packed = _packed_model(self._fmu.folder / MODEL, self.path, names)
        # With names of its own the variables of the FMU need not be those of a model inside it.
        self.source = packed if names is None else None
        #: The trained domain that a model of ours in the FMU records; the physical limits without one.
        self.domain = Domain.physical() if packed is None else packed.box
        self._bounds = [n for n in ("mu_low", "mu_high") if n in self._fmu.arrays]
        if names is not None:
            self._values(np.empty((0, len(LOAD_NAMES))), None, {}, self._evaluation.outputs)

    @property
    def card(self) -> dict[str, object]:
        """The model card inside the FMU; empty without one."""
        return {} if self.source is None else self.source.card

    @property
    def needed_loads(self) -> tuple[str, ...]:
        """The loads without which the FMU cannot be evaluated: all that enter it, but those its model was not given in training."""
        if self.names is not None:
            return tuple(n for n in LOAD_NAMES if n in self.names.loads)
        if self.source is None:
            return LOAD_NAMES
        return () if self.source.family == "constant" else self.source.box.measured

    def formula_text(self) -> str:
        """Return the law as the packed model states it, or the name of the FMU."""
        if self.source is not None and self.source.formula:
            return self.source.formula
        return f"{self._fmu.raw.modelName} ({self.path.name})"

    def remark(self) -> str:
        """Return which loads do not enter and which inputs stay as they are; empty where all loads enter."""
        missing = [] if self.names is None else [n for n in LOAD_NAMES if n not in self.names.loads]
        if self.names is None or not missing:
            return ""
        inputs = {n for n, elements in self._fmu.arrays.items() if elements[0].causality == "input"}
        free = [f"{n} stays at {v}" for n, v in self.names.start.items() if n in inputs]
        verb = "does" if len(missing) == 1 else "do"
        return "; ".join([f"{self.path}: {', '.join(missing)} {verb} not enter it", *free])

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> pd.Series[float]:
        """Return mu for a table with the columns of the contract: its rows, its index."""
        import pandas as pd

        return pd.Series(self.predict(TriboLoads.from_frame(data, tests)), index=data.index, name=MU.name)

    def predict(self, loads: TriboLoads | npt.ArrayLike) -> FloatArray:
        """Return mu at `loads` (`TriboLoads` or array of shape (n, 5)), shape (n,).

        Raises
        ------
        InputError
            Loads that are not finite or outside the physical limits.
        FmuError
            The FMU refuses a value.
        """
        return self._read(loads, self._evaluation.outputs)

    @property
    def interval_level(self) -> float | None:
        """Level of the prediction interval that the FMU gives out, None without one."""
        return self.source.interval if self.source is not None and len(self._bounds) == 2 else None

    def predict_interval_frame(
        self, data: pd.DataFrame, tests: pd.DataFrame | None = None, level: float | None = None
    ) -> tuple[pd.Series[float], pd.Series[float]]:
        """Return the bounds `mu_low` and `mu_high` for a table with the columns of the contract: its rows, its index.

        Raises
        ------
        InputError
            The FMU has no such outputs, or another level is asked for.
        """
        import pandas as pd

        if self.interval_level is None:
            raise InputError(f"{self.path}: no prediction interval; allowed: an FMU packed with one")
        if level is not None and level != self.interval_level:
            raise InputError(
                f"{self.path}: level {level:g}; allowed: {self.interval_level:g}, which the FMU was packed with"
            )
        loads = TriboLoads.from_frame(data, tests)
        low, high = (pd.Series(self._read(loads, [n]), index=data.index, name=n) for n in self._bounds)
        return low, high

    def _read(self, loads: TriboLoads | npt.ArrayLike, outputs: list[str]) -> FloatArray:
        """Return one output of every contact point at loads, shape (n,)."""
        points = loads if isinstance(loads, TriboLoads) else TriboLoads.from_array(loads)
        require_loads(points, self.needed_loads, str(self.path))
        # What has no memory is evaluated at once: a step for each point would give the same. Without time a law that
        # is known to remember takes it from distance and speed, as the model itself does.
        if self.source is None:
            stepped = points.t is not None
        else:
            stepped = bool(self.source.states) and (points.t is not None or points.test_id is not None)
        points, order = points.in_order(memory=stepped)
        array = points.as_array()
        mu = np.empty(len(array))
        system = self.source.system_values(points) if self.source is not None else {}
        parts = points.segments() if stepped or system else [slice(0, len(array))]
        dt = time_steps(points, [p.start for p in parts if p.stop > p.start])
        pause = rests(points, dt)
        time = np.cumsum(dt) if points.t is None else points.t
        for part in parts:
            # System variables are the same all through a test.
            start = {name: float(values[part.start]) for name, values in system.items() if len(array)}
            times = (time[part], pause[part]) if stepped else None
            mu[order[part]] = self._values(array[part], times, start, outputs)
        return mu

    def _values(self, *arguments: Any) -> FloatArray:
        """Return what `Evaluation.values` returns, here or in another process."""
        return (self._elsewhere or self._evaluation).values(*arguments)


def _packed_model(model: Path, path: Path, names: FrictionNames | None) -> FrictionSource | None:
    """Return the model in an FMU; in one of other generators the file may be of another kind."""
    if not model.is_file():
        return None
    try:
        return parse_source(model.read_bytes(), str(path))
    except InputError:
        if names is None:
            raise
        return None


def _short_step(fmu: UnpackedFmu) -> float:
    """Return a step that lets an FMU answer [s]."""
    try:
        step = float(fmu.raw.defaultExperiment.stepSize)
    except (AttributeError, TypeError, ValueError):
        return _SHORT
    return step if 0.0 < step < 1.0 else _SHORT


def read_friction_fmu(path: str | os.PathLike[str]) -> FmuModel:
    """Open a friction FMU as a fixed model; see `FmuModel`.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     model = read_friction_fmu(pack(ConstantFriction(mu=0.1), Path(place) / "friction.fmu", target="python"))
    ...     model.nodes, model.card.get("family")
    (1, 'constant')
    """
    return FmuModel(path)
