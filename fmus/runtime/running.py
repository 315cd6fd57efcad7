"""One co-simulation FMU (FMI 2.0 or 3.0) loaded through fmpy, with its messages; for checks and for reading friction."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from types import TracebackType
from typing import Any

import numpy as np

from friction_models.common import InputError, unknown_name
from friction_models.loads import FloatArray

from .unpacked import UnpackedFmu

__all__ = ["FmuError", "RunningFmu", "UnpackedFmu"]


class FmuError(RuntimeError):
    """An FMU refused a call; the message is the one it logged."""


def offer_interpreter() -> None:
    """Let solver FMUs that start Python as a process find this interpreter, unless the user chose one."""
    os.environ.setdefault("TRIBOFMU_PYTHON", sys.executable)


class RunningFmu:
    """An instance in step mode. Use it as a context manager.

    Parameters
    ----------
    fmu : UnpackedFmu
    name : str
        Instance name.
    start : dict, optional
        Values set before initialization; a structural parameter of FMI 3.0 is set in configuration mode.
    points : int, optional
        Number of contact points of a friction FMU whose arrays have the length of a structural
        parameter; its own start value by default.

    Raises
    ------
    InputError
        No binary for this platform, or one that cannot be loaded; a number of points that cannot be set.
    FmuError
        The FMU refuses to start.
    """

    def __init__(
        self,
        fmu: UnpackedFmu,
        name: str = "friction",
        start: dict[str, Any] | None = None,
        points: int | None = None,
    ) -> None:
        self.fmu = fmu
        self.log: list[str] = []
        values = dict(start or {})
        if points is not None:
            if fmu.sizing is None:
                raise InputError(
                    f"{fmu.path}: the number of contact points is fixed, allowed: none to be set"
                )
            values[fmu.sizing] = points
        self.sizes = {n: int(v) for n, v in values.items() if fmu.is_structural(n)}
        self._three = fmu.version == "3.0"
        description = fmu.description
        if description.coSimulation is None:
            raise InputError(f"{fmu.path}: the FMU offers no co-simulation, allowed: an FMU that does")
        offer_interpreter()
        try:
            self.slave: Any = _slave(fmu, name)
        except Exception as error:
            reason = " ".join(str(error).replace(str(fmu.folder), "").split())[:200]
            raise InputError(
                f"{fmu.path}: no binary for this platform that can be loaded ({reason})"
            ) from None
        try:
            self._start(values)
        except BaseException:
            self._unload()
            raise

    def _start(self, values: dict[str, Any]) -> None:
        structure = {n: v for n, v in values.items() if n in self.sizes}
        others = {n: v for n, v in values.items() if n not in self.sizes}
        # PythonFMU passes messages on only with logging switched on.
        if self._three:
            self._call(self.slave.instantiate, logMessage=self._logger3(), loggingOn=True)
            if structure:
                self._call(self.slave.enterConfigurationMode)
                self.set(structure)
                self._call(self.slave.exitConfigurationMode)
            self.set(others)
            self._call(self.slave.enterInitializationMode, startTime=0.0)
        else:
            self._call(self.slave.instantiate, callbacks=self._callbacks2(), loggingOn=True)
            self._call(self.slave.setupExperiment, startTime=0.0)
            self.set(others)
            self._call(self.slave.enterInitializationMode)
        self._call(self.slave.exitInitializationMode)

    # Not through fmpy's formatting proxy: it has one receiver a process, the instance created last.
    def _callbacks2(self) -> Any:
        from fmpy import calloc, fmi2, free

        def logger(_env: Any, _name: bytes, _status: int, _category: bytes, message: bytes) -> None:
            self._note(message)

        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(logger)
        self._callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        self._callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        return self._callbacks

    def _logger3(self) -> Any:
        def logger(_env: Any, _status: int, _category: bytes, message: bytes) -> None:
            self._note(message)

        return logger

    def _note(self, message: bytes | None) -> None:
        # An FMU that logs without end must not fill the memory.
        if len(self.log) < 10_000:
            self.log.append((message or b"")[:2000].decode("utf-8", "replace").strip())

    def _call(self, function: Any, *arguments: Any, **named: Any) -> Any:
        seen = len(self.log)
        try:
            return function(*arguments, **named)
        except Exception as error:
            own = [_plain(line) for line in self.log[seen:] if line]
            raise FmuError(own[-1] if own else " ".join(str(error).split())) from None

    def count(self, names: Sequence[str]) -> int:
        """Return how many values the variables hold together, arrays at their present size."""
        return sum(self.fmu.length(n, self.sizes) for n in names)

    def set(self, values: dict[str, Any]) -> None:
        """Set variables by name, arrays element by element."""
        for name, value in values.items():
            variable = self.fmu.variables.get(name)
            if variable is None:
                raise unknown_name("variable", name, self.fmu.variables, str(self.fmu.path))
            setter = getattr(self.slave, f"set{variable.type}", None)
            if setter is None:
                raise InputError(
                    f"{self.fmu.path}: variable {name!r} of type {variable.type} cannot be set here"
                )
            convert = float if variable.type in _REAL else bool if variable.type == "Boolean" else int
            items = np.ravel(value).tolist() if np.ndim(value) else [value]
            self._call(setter, [variable.valueReference], [convert(v) for v in items])

    def set_real(self, names: Sequence[str], values: FloatArray) -> None:
        """Set floating-point variables; the values of an array follow each other."""
        if not names:
            return
        setter = self.slave.setFloat64 if self._three else self.slave.setReal
        self._call(setter, self._references(names), np.asarray(values, dtype=float).ravel().tolist())

    def get_real(self, names: Sequence[str]) -> FloatArray:
        """Return floating-point variables; the values of an array follow each other."""
        if not names:
            return np.empty(0)
        references = self._references(names)
        if not self._three:
            return np.array(self._call(self.slave.getReal, references))
        return np.array(self._call(self.slave.getFloat64, references, self.count(names)))

    def get_boolean(self, name: str) -> bool:
        """Return a Boolean variable."""
        return bool(self._call(self.slave.getBoolean, self._references([name]))[0])

    def derivative(self, unknowns: Sequence[str], knowns: Sequence[str], seed: FloatArray) -> FloatArray:
        """Return the directional derivatives of `unknowns` along `seed`, one number a value of `knowns`."""
        arguments = (self._references(unknowns), self._references(knowns), np.ravel(seed).tolist())
        if self._three:
            return np.array(self._call(self.slave.getDirectionalDerivative, *arguments, self.count(unknowns)))
        return np.array(self._call(self.slave.getDirectionalDerivative, *arguments))

    def adjoint(self, unknowns: Sequence[str], knowns: Sequence[str], seed: FloatArray) -> FloatArray:
        """Return the adjoint derivatives (FMI 3.0) for `seed`, one number a value of `unknowns`."""
        arguments = (self._references(unknowns), self._references(knowns), np.ravel(seed).tolist())
        return np.array(self._call(self.slave.getAdjointDerivative, *arguments, self.count(knowns)))

    def step(self, time: float, size: float) -> None:
        """Make a communication step."""
        if not self._three:
            self._call(self.slave.doStep, time, size)
            return
        _, terminate, early, reached = self._call(self.slave.doStep, time, size, False)
        if terminate or (early and reached < time + size):
            raise FmuError(f"the step of {size:g} s ended at {reached:g} s instead of {time + size:g} s")

    def save(self) -> Any:
        """Return the FMU state."""
        return self._call(self.slave.getFMUState if self._three else self.slave.getFMUstate)

    def restore(self, state: Any) -> None:
        """Set the FMU state."""
        self._call(self.slave.setFMUState if self._three else self.slave.setFMUstate, state)

    def release(self, state: Any) -> None:
        """Free the FMU state."""
        self._call(self.slave.freeFMUState if self._three else self.slave.freeFMUstate, state)

    def through_bytes(self, state: Any) -> Any:
        """Return the state after serializing and reading it back."""
        if self._three:
            return self._call(self.slave.deserializeFMUState, self._call(self.slave.serializeFMUState, state))
        return self._call(self.slave.deSerializeFMUstate, self._call(self.slave.serializeFMUstate, state))

    def reset(self) -> None:
        """Go back to the state after instantiation and initialize again with the start values."""
        self._call(self.slave.reset)
        if self._three:
            self._call(self.slave.enterInitializationMode, startTime=0.0)
        else:
            self._call(self.slave.setupExperiment, startTime=0.0)
            self._call(self.slave.enterInitializationMode)
        self._call(self.slave.exitInitializationMode)

    def _references(self, names: Sequence[str]) -> list[int]:
        return [self.fmu.variables[n].valueReference for n in names]

    def close(self) -> None:
        """Free the instance; the library is unloaded."""
        slave, self.slave = self.slave, None
        if slave is not None:
            slave.freeInstance()

    def _unload(self) -> None:
        """Let go of an instance that did not start."""
        slave, self.slave = self.slave, None
        if getattr(slave, "component", None):
            slave.freeInstance()
        elif slave is not None:
            slave.freeLibrary()

    def __enter__(self) -> RunningFmu:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


_REAL = {"Real", "Float64", "Float32"}


def _slave(fmu: UnpackedFmu, name: str) -> Any:
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    arguments = {
        "guid": fmu.description.guid,
        "unzipDirectory": str(fmu.folder),
        "modelIdentifier": fmu.description.coSimulation.modelIdentifier,
        "instanceName": name,
    }
    if fmu.version == "3.0":
        return FMU3Slave(**arguments)
    return FMU2Slave(**arguments, libraryPath=fmu.library())


def _plain(message: str) -> str:
    """Return the last line of a message, without the Python exception that PythonFMU wraps around it."""
    last = message.strip().splitlines()[-1]
    wrapped = re.fullmatch(r"""\w+\((['"])(.*)\1\)""", last)
    return wrapped.group(2) if wrapped else last
