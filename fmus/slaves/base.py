"""Solvers as PythonFMU slaves, which run in the simulator's own interpreter."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, TypedDict

import numpy as np
from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from friction_models.common import InputError

from .core import Saved, Solver


class State(TypedDict, total=False):
    """An FMU state: the solver with what it saved and what the host remembers, or the bytes of all that."""

    solver: Solver
    saved: Saved
    more: list[Any]
    bytes: bytes


def guarded(method: Callable[..., Any]) -> Callable[..., Any]:
    """Let an error leave a method without taking the objects behind it along.

    PythonFMU 0.7 gives back a reference to the slave, its class and its messages at every error and
    goes on using them: the next call would crash the simulator. It gets the references here.
    """

    @functools.wraps(method)
    def call(self: Any, *arguments: Any) -> Any:
        try:
            return method(self, *arguments)
        except BaseException:
            for thing in (self, type(self), self.log_queue):
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))
            raise

    return call


class SolverSlave(Fmi2Slave):
    """Slave around a `Solver`; value references are numbered as `fmus.interface.solver_interface` says.

    The file `interface.json` beside the script names the variables and holds their start values.
    What is allowed when, and the messages, are those of the native front (`fmus/native/front_fmi2.c`).
    """

    solver_type: ClassVar[type[Solver]]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        with contextlib.suppress(ValueError):
            sys.path.remove(str(self.resources))  # PythonFMU has put it in front; everything is imported now
        text = (Path(str(self.resources)) / "interface.json").read_text(encoding="utf-8")
        self.solver = self.solver_type(json.loads(text))
        self.running = False
        self.initialized = False
        self.begin = self.now = 0.0

    def ensure_started(self) -> None:
        """Build the process on first use, when all parameters are set."""
        if not self.running:
            self.solver.launch()
            self.running = True

    @guarded
    def setup_experiment(self, start_time: float, *_: Any) -> None:
        self.begin = self.now = start_time

    @guarded
    def exit_initialization_mode(self) -> None:
        self.ensure_started()
        self.initialized = True

    @guarded
    def do_step(self, current_time: float, step_size: float) -> bool:
        """Return False, with a logged message, for a step that the solver refuses (fmi2Discard)."""
        try:
            if not math.isfinite(step_size) or step_size < 0.0:
                raise InputError(f"communication step {step_size!r} s is negative or not a finite number")
            self.ensure_started()
            self.solver.advance(current_time - self.begin, step_size)
        except (InputError, ArithmeticError, RuntimeError) as error:
            self.log(str(error), Fmi2Status.error)
            return False
        self.now = current_time + step_size
        return True

    @guarded
    def terminate(self) -> None:
        """Log what there is to say of the run."""
        for text in self.solver.remarks() if self.running else ():
            self.log(text, Fmi2Status.warning)

    @guarded
    def get_real(self, vrs: list[int]) -> list[float]:
        index = self.solver.places(vrs)
        if not self.running and (index < self.solver.first_input).any():
            self.ensure_started()
        result: list[float] = self.solver.values[index].tolist()
        return result

    @guarded
    def set_real(self, vrs: list[int], values: list[float]) -> None:
        index, given, solver = self.solver.places(vrs), np.array(values), self.solver
        if not np.isfinite(given).all():
            k = int(np.argmin(np.isfinite(given)))
            raise ValueError(f"{solver.names[index[k]]} = {values[k]} is not a finite number")
        if (index < solver.first_input).any():
            name = solver.names[index[int(np.argmax(index < solver.first_input))]]
            raise ValueError(f"{name} is an output and cannot be set")
        if (index >= solver.first_parameter).any():
            if self.initialized:
                name = solver.names[index[int(np.argmax(index >= solver.first_parameter))]]
                raise ValueError(f"parameter {name} cannot be set after initialization")
            self.running = False
        solver.values[index] = given

    @guarded
    def get_boolean(self, vrs: list[int]) -> list[bool]:
        self.ensure_started()
        result: list[bool] = self.solver.flags[self.solver.flag_places(vrs)].tolist()
        return result

    @guarded
    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        raise ValueError("Boolean variables of this FMU are outputs and cannot be set")

    @guarded
    def _get_fmu_state(self) -> State:
        self.ensure_started()
        more = [self.begin, self.now, self.initialized]
        return {"solver": self.solver, "saved": self.solver.save(), "more": more}

    @guarded
    def _set_fmu_state(self, state: State) -> None:
        saved, more = state.get("saved"), state.get("more")
        if saved is None or more is None:  # PythonFMU reads bytes where no instance is at hand
            saved, more = self.solver.from_bytes(state["bytes"])
        if len(more) != 3 or not all(math.isfinite(number) for number in more):
            raise InputError("the serialized state cannot be read (its times are not finite numbers)")
        self.solver.restore(saved)
        self.begin, self.now, self.initialized = more[0], more[1], bool(more[2])
        self.running = True

    @staticmethod
    def _fmu_state_to_bytes(state: State) -> bytes:
        if "bytes" in state:
            return bytes(state["bytes"])
        return state["solver"].to_bytes(state["saved"], state["more"])

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> State:
        return {"bytes": state}
