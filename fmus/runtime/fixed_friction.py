"""A friction FMU as a fixed friction model: `predict` through the FMU itself, ours or that of another generator."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, MU, FloatArray, TriboLoads, require_loads
from friction_models.loads.time_steps import rests, time_steps
from friction_models.models.domain import Domain
from friction_models.models.intervals.prediction_interval import BOUNDS, as_columns, check_only_level

from ..archive.made_here import runs_apart
from ..interface.friction_source import FrictionSource, parse_source
from .evaluation import Elsewhere, Evaluation
from .friction_names import FrictionNames
from .running import FmuError

if TYPE_CHECKING:  # co-simulation names FMUs of others without pandas
    import pandas as pd

#: Where our own friction FMUs hold their law.
MODEL = "resources/model.onnx"


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
        self._bounds = [n for n in BOUNDS if n in self._fmu.arrays]
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
        check_only_level(str(self.path), "an FMU packed", self.interval_level, level)
        loads = TriboLoads.from_frame(data, tests)
        low, high = (self._read(loads, [name]) for name in self._bounds)
        return as_columns(low, high, data.index)

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
        try:
            return (self._elsewhere or self._evaluation).values(*arguments)
        except FmuError as error:
            raise FmuError(f"{self.path}: {error}") from None


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
