"""What the solver FMUs share: real variables in one array, guarded errors, state of the whole slave."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import json
import math
import sys
from abc import abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from friction_models.loads import FloatArray, InputError


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
    """Slave whose Real variables are one array: outputs first, then inputs, then parameters.

    A solver implements `start` (build the process from the parameters and publish), `advance` (one
    communication step with the present inputs, then publish), `save` and `restore`.
    The file `interface.json` beside the script names the variables and holds their start values.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        with contextlib.suppress(ValueError):
            sys.path.remove(str(self.resources))  # PythonFMU has put it in front; everything is imported now
        text = (Path(str(self.resources)) / "interface.json").read_text(encoding="utf-8")
        self.config: dict[str, Any] = json.loads(text)
        self.names: list[str] = self.config["names"]
        self.first_input: int = self.config["first_input"]
        self.first_parameter: int = self.config["first_parameter"]
        self.values: FloatArray = np.array(self.config["start"], dtype=np.float64)
        self.flags = np.zeros(self.config["flags"], dtype=bool)
        self.running = False
        self.initialized = False
        self.begin = self.now = 0.0

    @abstractmethod
    def start(self) -> None:
        """Build the process from `parameters()` and publish its outputs."""

    @abstractmethod
    def advance(self, elapsed: float, step: float) -> None:
        """Advance from `elapsed` [s] since the start by `step` [s] and publish; raise to refuse the step."""

    @abstractmethod
    def save(self) -> Any:
        """Return a copy of the process state."""

    @abstractmethod
    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned, exactly."""

    def parameters(self) -> dict[str, float]:
        """Return the parameters by name."""
        return dict(zip(self.names[self.first_parameter :], self.values[self.first_parameter :].tolist()))

    def inputs(self) -> FloatArray:
        """Return the inputs in order of their value references."""
        return self.values[self.first_input : self.first_parameter]

    def ensure_started(self) -> None:
        """Build the process on first use, when all parameters are set."""
        if not self.running:
            self.start()
            self.running = True

    # --- FMI ------------------------------------------------------------------------------------------

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
            self.advance(current_time - self.begin, step_size)
        except (InputError, ArithmeticError, RuntimeError) as error:
            self.log(str(error), Fmi2Status.error)
            return False
        self.now = current_time + step_size
        return True

    @guarded
    def get_real(self, vrs: list[int]) -> list[float]:
        index = np.array(vrs, dtype=np.int64)
        if not self.running and (index < self.first_input).any():
            self.ensure_started()
        result: list[float] = self.values[index].tolist()
        return result

    @guarded
    def set_real(self, vrs: list[int], values: list[float]) -> None:
        index, given = np.array(vrs, dtype=np.int64), np.array(values)
        if not np.isfinite(given).all():
            k = int(np.argmin(np.isfinite(given)))
            raise ValueError(f"{self.names[vrs[k]]} = {values[k]} is not a finite number")
        if (index < self.first_input).any():
            name = self.names[vrs[int(np.argmax(index < self.first_input))]]
            raise ValueError(f"{name} is an output and cannot be set")
        if (index >= self.first_parameter).any():
            if self.initialized:
                name = self.names[vrs[int(np.argmax(index >= self.first_parameter))]]
                raise ValueError(f"parameter {name} cannot be set after initialization")
            self.running = False
        self.values[index] = given

    @guarded
    def get_boolean(self, vrs: list[int]) -> list[bool]:
        self.ensure_started()
        result: list[bool] = self.flags[np.array(vrs, dtype=np.int64)].tolist()
        return result

    @guarded
    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        raise ValueError("Boolean variables of this FMU are outputs and cannot be set")

    @guarded
    def _get_fmu_state(self) -> dict[str, Any]:
        self.ensure_started()
        return {
            "values": self.values.copy(),
            "flags": self.flags.copy(),
            "times": (self.begin, self.now),
            "initialized": self.initialized,
            "process": self.save(),
        }

    @guarded
    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self.values[:] = state["values"]
        if not self.running:
            self.ensure_started()
            self.values[:] = state["values"]
        self.flags[:] = state["flags"]
        self.begin, self.now = state["times"]
        self.initialized = state["initialized"]
        self.restore(state["process"])
