"""One FMI 2.0 co-simulation FMU loaded through fmpy, with its messages; for checks and for reading friction."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from friction_models.loads import LOADS, MU, FloatArray, InputError, unknown_name

from .archive import read_description, unpack
from .interface import vector


class FmuError(RuntimeError):
    """An FMU refused a call; the message is the one it logged."""


class UnpackedFmu:
    """An FMU unpacked into a temporary folder that lives as long as this object.

    Attributes
    ----------
    path, folder : Path
    description : fmpy.model_description.ModelDescription
    variables : dict of str to fmpy's ScalarVariable
        By full name.

    Raises
    ------
    InputError
        A hostile or damaged archive, another version than FMI 2.0, no co-simulation.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        version = read_description(self.path).get("fmiVersion")
        if version != "2.0":
            raise InputError(f"{self.path}: FMI version {version!r}, allowed: '2.0'")
        self._temporary = tempfile.TemporaryDirectory(prefix="tribofmu-", ignore_cleanup_errors=True)
        self.folder = unpack(self.path, self._temporary.name)
        from fmpy import read_model_description

        try:
            self.description: Any = read_model_description(str(self.folder), validate=False)
        except Exception as error:  # fmpy raises plain exceptions
            reason = " ".join(str(error).split())
            raise InputError(f"{self.path}: modelDescription.xml is not usable ({reason[:200]})") from None
        if self.description.coSimulation is None:
            raise InputError(
                f"{self.path}: the FMU offers no co-simulation, allowed: FMI 2.0 for co-simulation"
            )
        self.variables: dict[str, Any] = {v.name: v for v in self.description.modelVariables}

    def elements(self, name: str) -> list[str]:
        """Return the scalar names that make up `name`.

        Raises
        ------
        InputError
            No such variable; with the nearest one.
        """
        found = vector(list(self.variables), name)
        if not found:
            raise unknown_name(
                "variable", name, {n.partition("[")[0] for n in self.variables}, str(self.path)
            )
        return found

    def unit(self, name: str) -> str:
        """Return the unit of a variable, empty without one."""
        variable = self.variables[name]
        declared = variable.declaredType
        return str(variable.unit or (declared.unit if declared is not None else None) or "")

    def friction(self) -> dict[str, list[str]]:
        """Return the element names of the five loads and of mu, checked as a friction FMU.

        Raises
        ------
        InputError
            A variable is missing, is not an input or output, has another unit or number of points.
        """
        found: dict[str, list[str]] = {}
        for quantity in (*LOADS, MU):
            names = self.elements(quantity.name)
            wanted = "output" if quantity is MU else "input"
            causality = self.variables[names[0]].causality
            if causality != wanted:
                raise InputError(f"{self.path}: variable {names[0]!r} is a {causality}, allowed: {wanted}")
            unit = self.unit(names[0])
            if unit not in {quantity.unit, "", "-" if quantity.unit == "1" else ""}:
                raise InputError(
                    f"{self.path}: variable {names[0]!r} has unit {unit!r}, allowed: {quantity.unit!r}"
                )
            found[quantity.name] = names
            if len(names) != len(found["v_rel"]):
                raise InputError(
                    f"{self.path}: {len(names)} points of {quantity.name!r} and {len(found['v_rel'])} of 'v_rel', "
                    "allowed: equally many"
                )
        return found


class RunningFmu:
    """An instance in step mode. Use it as a context manager.

    Parameters
    ----------
    fmu : UnpackedFmu
    name : str
        Instance name.
    start : dict, optional
        Values set before initialization.

    Raises
    ------
    InputError
        No binary for this platform, or one that cannot be loaded.
    FmuError
        The FMU refuses to start.
    """

    def __init__(self, fmu: UnpackedFmu, name: str = "friction", start: dict[str, Any] | None = None) -> None:
        from fmpy import calloc, fmi2, free
        from fmpy.fmi2 import FMU2Slave

        self.fmu = fmu
        self.log: list[str] = []

        # Not through fmpy's formatting proxy: it has one receiver a process, the instance created last.
        def logger(_env: Any, _name: bytes, _status: int, _category: bytes, message: bytes) -> None:
            self.log.append((message or b"").decode("utf-8", "replace").strip())

        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(logger)
        self._callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        self._callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        description = fmu.description
        try:
            self.slave: Any = FMU2Slave(
                guid=description.guid,
                unzipDirectory=str(fmu.folder),
                modelIdentifier=description.coSimulation.modelIdentifier,
                instanceName=name,
            )
        except Exception as error:
            raise InputError(
                f"{fmu.path}: no binary for this platform that can be loaded ({' '.join(str(error).split())[:200]})"
            ) from None
        # PythonFMU passes messages on only with logging switched on.
        self._call(self.slave.instantiate, callbacks=self._callbacks, loggingOn=True)
        self._call(self.slave.setupExperiment, startTime=0.0)
        if start:
            self.set(start)
        self._call(self.slave.enterInitializationMode)
        self._call(self.slave.exitInitializationMode)

    def _call(self, function: Any, *arguments: Any, **named: Any) -> Any:
        seen = len(self.log)
        try:
            return function(*arguments, **named)
        except Exception as error:
            own = [_plain(line) for line in self.log[seen:] if line]
            raise FmuError(own[-1] if own else " ".join(str(error).split())) from None

    def set(self, values: dict[str, Any]) -> None:
        """Set variables by name."""
        for name, value in values.items():
            variable = self.fmu.variables.get(name)
            if variable is None:
                raise unknown_name("variable", name, self.fmu.variables, str(self.fmu.path))
            setter = self.slave.setBoolean if variable.type == "Boolean" else self.slave.setReal
            self._call(setter, [variable.valueReference], [value])

    def set_real(self, names: Sequence[str], values: FloatArray) -> None:
        """Set Real variables."""
        references = [self.fmu.variables[n].valueReference for n in names]
        self._call(self.slave.setReal, references, np.asarray(values, dtype=float).tolist())

    def get_real(self, names: Sequence[str]) -> FloatArray:
        """Return Real variables."""
        references = [self.fmu.variables[n].valueReference for n in names]
        return np.array(self._call(self.slave.getReal, references))

    def get_boolean(self, name: str) -> bool:
        """Return a Boolean variable."""
        return bool(self._call(self.slave.getBoolean, [self.fmu.variables[name].valueReference])[0])

    def step(self, time: float, size: float) -> None:
        """Make a communication step."""
        self._call(self.slave.doStep, time, size)

    def save(self) -> Any:
        """Return the FMU state."""
        return self._call(self.slave.getFMUstate)

    def restore(self, state: Any) -> None:
        """Set the FMU state."""
        self._call(self.slave.setFMUstate, state)

    def through_bytes(self, state: Any) -> Any:
        """Return the state after serializing and reading it back."""
        return self._call(self.slave.deSerializeFMUstate, self._call(self.slave.serializeFMUstate, state))

    def close(self) -> None:
        """Free the instance; the library is unloaded."""
        slave, self.slave = self.slave, None
        if slave is not None:
            slave.freeInstance()

    def __enter__(self) -> RunningFmu:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _plain(message: str) -> str:
    """Return the last line of a message, without the Python exception that PythonFMU wraps around it."""
    last = message.strip().splitlines()[-1]
    wrapped = re.fullmatch(r"""\w+\((['"])(.*)\1\)""", last)
    return wrapped.group(2) if wrapped else last
