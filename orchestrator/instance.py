"""One running FMU with preallocated buffers: what is exchanged every step costs no Python lists."""

from __future__ import annotations

import re
import time
from collections.abc import Iterable
from ctypes import POINTER, c_double, c_int, c_uint
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from friction_models.loads import FloatArray, InputError

from .errors import SimulationError
from .fmu_files import FmuDescription, Variable

#: FMI 2.0 base type by the type of the variable; enumerations are exchanged as integers.
_BASE = {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"}


class Port:
    """A set of variables of one FMU, read or written in one call a type.

    Parameters
    ----------
    variables : iterable of Variable
        Numeric variables; `values` holds them as float64 in this order.
    """

    def __init__(self, variables: Iterable[Variable]) -> None:
        self.variables = list(variables)
        self.values: FloatArray = np.zeros(len(self.variables))
        self._groups: list[tuple[str, slice | Any, Any, Any, Any]] = []
        for base in ("Real", "Integer", "Boolean"):
            rows = np.array([i for i, v in enumerate(self.variables) if _BASE[v.type] == base], dtype=int)
            if not len(rows):
                continue
            references = (c_uint * len(rows))(*[self.variables[i].reference for i in rows])
            if base == "Real" and len(rows) == len(self.variables):
                buffer = self.values  # no copy: the FMU reads and writes the array itself
            else:
                buffer = np.zeros(len(rows), dtype=np.float64 if base == "Real" else np.intc)
            kind = c_double if base == "Real" else c_int
            self._groups.append((base, rows, references, buffer, buffer.ctypes.data_as(POINTER(kind))))
        self.index = {v.name: i for i, v in enumerate(self.variables)}

    def read(self, slave: Any) -> None:
        """Fetch all values from the FMU."""
        for base, rows, references, buffer, pointer in self._groups:
            getattr(slave, f"fmi2Get{base}")(slave.component, references, len(references), pointer)
            if buffer is not self.values:
                self.values[rows] = buffer

    def write(self, slave: Any) -> None:
        """Send all values to the FMU."""
        for base, rows, references, buffer, pointer in self._groups:
            if buffer is not self.values:
                buffer[:] = self.values[rows]
            getattr(slave, f"fmi2Set{base}")(slave.component, references, len(references), pointer)


class Instance:
    """A loaded FMI 2.0 co-simulation FMU between instantiation and `close`.

    Parameters
    ----------
    name : str
        Name of the component.
    description : FmuDescription
        From `describe`.
    unpacked : Path
        Folder of the unpacked archive; removed by its owner.
    log : list of str, optional
        Receives what the FMU logs.
    """

    def __init__(
        self, name: str, description: FmuDescription, unpacked: Path, log: list[str] | None = None
    ) -> None:
        from fmpy.fmi2 import FMU2Slave

        self.name = name
        self.description = description
        self.log = log if log is not None else []
        #: Time spent in steps, exchange of values included [s].
        self.seconds = 0.0
        raw = description.raw
        self._callbacks = self._make_callbacks()
        try:
            self._slave: Any = FMU2Slave(
                guid=raw.guid,
                unzipDirectory=str(unpacked),
                modelIdentifier=raw.coSimulation.modelIdentifier,
                instanceName=name,
            )
        except Exception as error:
            raise InputError(
                f"{description.path}: the binary cannot be loaded ({' '.join(str(error).split())})"
            ) from None
        try:
            self._slave.instantiate(callbacks=self._callbacks, loggingOn=True)
        except Exception as error:
            self._slave.freeLibrary()
            raise self._failure("instantiate", 0.0, error) from None

    def _make_callbacks(self) -> Any:
        from ctypes import byref

        from fmpy import calloc, fmi2, free

        def logger(_env: Any, _name: bytes, status: int, _category: bytes, message: bytes) -> None:
            text = (message or b"").decode("utf-8", "replace").strip()
            self.log.append(f"{self.name}: {text}" if status < 3 else f"{self.name}: error: {text}")

        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(logger)
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        try:
            from fmpy.logging import addLoggerProxy

            addLoggerProxy(byref(callbacks))
        except Exception:
            self.log.append(f"{self.name}: messages of the FMU come unformatted on this platform")
        return callbacks

    def _failure(self, call: str, at: float, error: BaseException) -> SimulationError:
        own = [line for line in self.log if line.startswith(f"{self.name}: error: ")]
        cause = own[-1].removeprefix(f"{self.name}: error: ") if own else " ".join(str(error).split())
        # PythonFMU wraps what was said into a line of its own.
        python = re.search(r"PyObject_CallMethod\s+\w+\((['\"])(?P<said>.*)\1\)$", cause)
        cause = python["said"] if python else cause
        return SimulationError(f"component {self.name!r} failed at t = {at:g} s in {call}: {cause}")

    def initialize(
        self, starts: Iterable[tuple[Variable, bool | int | float | str]], stop_time: float
    ) -> None:
        """Set start values and go through initialization mode."""
        slave = self._slave
        try:
            slave.setupExperiment(startTime=0.0, stopTime=stop_time)
            for variable, value in starts:
                if variable.type == "String":
                    slave.setString([variable.reference], [str(value)])
                else:
                    setter = getattr(slave, f"set{_BASE[variable.type]}")
                    setter([variable.reference], [float(value) if variable.type == "Real" else int(value)])
            slave.enterInitializationMode()
            slave.exitInitializationMode()
        except Exception as error:
            raise self._failure("initialization", 0.0, error) from None

    def step(self, inputs: Port, outputs: Port, now: float, size: float) -> None:
        """Write the inputs, advance from `now` by `size` seconds, read the outputs."""
        began = time.perf_counter()
        try:
            if inputs.variables:
                inputs.write(self._slave)
            self._slave.doStep(now, size)
            if outputs.variables:
                outputs.read(self._slave)
        except Exception as error:
            raise self._failure("a step", now, error) from None
        self.seconds += time.perf_counter() - began

    def write(self, inputs: Port, now: float = 0.0) -> None:
        """Write inputs outside a step."""
        try:
            inputs.write(self._slave)
        except Exception as error:
            raise self._failure("setting inputs", now, error) from None

    def read(self, outputs: Port, now: float = 0.0) -> None:
        """Read outputs outside a step."""
        try:
            outputs.read(self._slave)
        except Exception as error:
            raise self._failure("reading outputs", now, error) from None

    def save_state(self) -> Any:
        """Return a handle to the FMU's complete state; give it to `free_state` in the end."""
        return self._slave.getFMUState()

    def restore_state(self, state: Any) -> None:
        """Go back to a saved state."""
        self._slave.setFMUState(state)

    def free_state(self, state: Any) -> None:
        """Give up a saved state."""
        self._slave.freeFMUState(state)

    def reset(self) -> None:
        """Bring the FMU back to where instantiation left it."""
        try:
            self._slave.reset()
        except Exception as error:
            raise self._failure("reset", 0.0, error) from None

    def close(self) -> None:
        """Terminate and unload; safe after a failure."""
        slave, self._slave = self._slave, None
        if slave is None:
            return
        try:
            slave.terminate()
        except Exception as error:
            self.log.append(f"{self.name}: terminate: {error}")
        slave.freeInstance()

    def __enter__(self) -> Instance:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
