"""The solvers behind the solver FMUs, without FMI: variables in one array, start, step, save, restore."""

from __future__ import annotations

import hashlib
import json
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple, TypedDict

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.loads import FloatArray

from .protocol import package_version
from .state_bytes import from_bytes, to_bytes


class SolverFacts(TypedDict, total=False):
    """What a solver itself needs; each takes its own part."""

    process: str
    #: Arguments of the process, and the names of its numbers that may be left out.
    fixed: Mapping[str, object]
    optional: list[str]
    material: Mapping[str, object]
    T_specimen: float | None
    #: Times at which signals change [s], and the values in between, one row a signal.
    edges: list[float]
    means: list[list[float]]


class SolverConfig(SolverFacts):
    """Content of `interface.json`: what a solver is made from, as `fmus.interface.solver_interface` writes it."""

    #: Names of the Real variables and their start values; places of the first input and the first parameter.
    names: list[str]
    start: list[float]
    first_input: int
    first_parameter: int
    #: How many of the outputs before the first input are numbered after all other variables.
    further: int
    #: Number of Boolean outputs.
    flags: int


class Saved(NamedTuple):
    """State of a solver: its variables, what its process was started with, the process and its snapshot."""

    values: FloatArray
    flags: npt.NDArray[np.bool_]
    started: FloatArray
    process: Any
    snapshot: Any


class Solver(ABC):
    """A solver whose Real variables are one array: outputs first, then inputs, then parameters.

    Two hosts drive it: the PythonFMU slave in the simulator's interpreter, and `fmus.slaves.server` in a
    process of its own. A solver sets `process`, an object with `snapshot` and `restore`.
    """

    process: Any = None
    #: Classes that a snapshot of the process is made of.
    snapshot_classes: ClassVar[tuple[type, ...]] = ()

    def __init__(self, config: SolverConfig) -> None:
        self.config = config
        self.names = config["names"]
        self.first_input = config["first_input"]
        self.first_parameter = config["first_parameter"]
        self.further = config.get("further", 0)
        #: All Real variables, and the Boolean outputs.
        self.values: FloatArray = np.array(config["start"], dtype=np.float64)
        self.flags = np.zeros(config["flags"], dtype=bool)
        #: Inputs and parameters with which the process was started.
        self.started: FloatArray = np.empty(0)

    @abstractmethod
    def start(self) -> None:
        """Build the process from `parameters()` and publish its outputs."""

    @abstractmethod
    def advance(self, elapsed: float, step: float) -> None:
        """Advance from `elapsed` [s] since the start by `step` [s] and publish; raise to refuse the step."""

    def remarks(self) -> Sequence[str]:
        """Return what a user should know of the run so far; the hosts pass it on as warnings when the run ends."""
        return ()

    def places(self, references: Sequence[int]) -> npt.NDArray[np.int64]:
        """Return where the Real variables of some value references are in `values`.

        Raises ValueError: there is none.
        """
        wanted = np.array(references, dtype=np.int64)
        head, last = self.first_input - self.further, len(self.values) - self.further
        after = last + len(self.flags)
        known = (wanted >= 0) & (wanted < last) | (after <= wanted) & (wanted < after + self.further)
        if not known.all():
            raise ValueError(f"there is no Real variable with value reference {wanted[~known][0]}")
        shift = np.where(wanted < head, 0, np.where(wanted < last, self.further, head - after))
        return np.asarray(wanted + shift)

    def flag_places(self, references: Sequence[int]) -> npt.NDArray[np.int64]:
        """Return where the Boolean variables of some value references are in `flags`.

        Raises ValueError: there is none.
        """
        wanted = np.array(references, dtype=np.int64)
        place = wanted - (len(self.values) - self.further)
        known = (place >= 0) & (place < len(self.flags))
        if not known.all():
            raise ValueError(f"there is no Boolean variable with value reference {wanted[~known][0]}")
        return np.asarray(place)

    def parameters(self) -> dict[str, float]:
        """Return the parameters by name."""
        return dict(zip(self.names[self.first_parameter :], self.values[self.first_parameter :].tolist()))

    def inputs(self) -> FloatArray:
        """Return the inputs in order of their value references."""
        return self.values[self.first_input : self.first_parameter]

    def launch(self) -> None:
        """Start the process with the present inputs and parameters."""
        started = self.values[self.first_input :].copy()
        self.start()
        self.started = started

    def save(self) -> Saved:
        """Return a copy of the whole state; `restore` continues from it exactly."""
        # The process is part of it: another one, with other parameters, may run when the state comes back.
        values, flags, snapshot = self.values.copy(), self.flags.copy(), self.process.snapshot()
        return Saved(values, flags, self.started, self.process, snapshot)

    def restore(self, saved: Saved) -> None:
        """Go back to what `save` returned, exactly; it can be used again."""
        self.values[:], self.flags[:] = saved.values, saved.flags
        self.started, self.process = saved.started, saved.process
        self.process.restore(saved.snapshot)

    def to_bytes(self, saved: Saved, more: list[Any]) -> bytes:
        """Return a state as bytes, together with what the host has to remember (numbers and texts)."""
        content = [saved.values, saved.flags, saved.started, saved.snapshot, more]
        return to_bytes(content, self.identity(), self.snapshot_classes)

    def from_bytes(self, content: bytes) -> tuple[Saved, list[Any]]:
        """Return the state and what the host had to remember; the solver stays as it is.

        Raises InputError: not a state of this FMU and this version of tribofmu, or a damaged one.
        """
        found = from_bytes(content, self.identity(), self.snapshot_classes)
        if not isinstance(found, list) or len(found) != 5:
            raise InputError("the serialized state cannot be read (it has other parts)")
        values, flags, started, snapshot, more = found
        if np.shape(values) != self.values.shape or np.shape(flags) != self.flags.shape:
            raise InputError("the serialized state cannot be read (it has other variables)")
        if self.process is not None and np.array_equal(started, self.started):
            return Saved(values, flags, started, self.process, snapshot), more
        # What does not change during a run is not in the snapshot: the process is built again.
        other = type(self)(self.config)
        other.values[other.first_input :] = started
        other.launch()
        return Saved(values, flags, started, other.process, snapshot), more

    def identity(self) -> str:
        """Return a text that differs between FMUs and versions of the package."""
        package = package_version() or ""
        shown = {k: v for k, v in self.config.items() if k != "names"}
        text = json.dumps([type(self).__name__, package, shown], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()
