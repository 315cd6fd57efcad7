"""One running FMU whose variables are read and set by name, for checks and for friction models. A master uses `Instance`."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_double, c_size_t, c_uint
from types import TracebackType
from typing import Any, TypeVar

import numpy as np

from friction_models.common import InputError, unknown_name
from friction_models.loads import FloatArray

from .c_interface import load
from .fmu_variables import exchange_type
from .ports import C_TYPES
from .unpacked import UnpackedFmu

__all__ = ["FmuError", "RunningFmu", "UnpackedFmu"]

_REAL = {"Real", "Float64", "Float32"}
_T = TypeVar("_T")


class FmuError(RuntimeError):
    """An FMU refused a call; the message is the one it logged."""


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

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from fmus.runtime.unpacked import UnpackedFmu
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     fmu = pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python")
    ...     with RunningFmu(UnpackedFmu(fmu)) as running:
    ...         running.set_real(["T", "sigma_n"], [80.0, 600.0])
    ...         running.step(0.0, 0.1)
    ...         running.get_real(["mu"])
    array([0.1])
    """

    def __init__(
        self,
        fmu: UnpackedFmu,
        name: str = "friction",
        start: Mapping[str, Any] | None = None,
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
        self._set_real, self._get_real = f"Set{fmu.real}", f"Get{fmu.real}"
        #: References and their number as C values, by names.
        self._prepared: dict[tuple[str, ...], tuple[Any, c_size_t]] = {}
        description = fmu.description
        if description.coSimulation is None:
            raise InputError(f"{fmu.path}: the FMU offers no co-simulation, allowed: an FMU that does")
        try:
            self.slave = load(fmu.path, description, fmu.folder)
        except InputError as error:
            reason = str(error).replace(f"{fmu.path}: ", "").replace(str(fmu.folder), "")[:200]
            raise InputError(
                f"{fmu.path}: no binary for this platform that can be loaded ({reason})"
            ) from None
        try:
            self._start(name, values)
        except BaseException:
            self.close()
            raise

    def _start(self, name: str, values: Mapping[str, Any]) -> None:
        structure = {n: v for n, v in values.items() if n in self.sizes}
        others = {n: v for n, v in values.items() if n not in self.sizes}
        self._asked(self.slave.instantiate, name, lambda _status, text: self._note(text))
        if structure:
            self.call("EnterConfigurationMode")
            self.set(structure)
            self.call("ExitConfigurationMode")
        self.set(others)
        self._initialize()

    def _initialize(self) -> None:
        self._asked(self.slave.enter_initialization)
        self._asked(self.slave.exit_initialization)

    def _note(self, message: bytes | None) -> None:
        # An FMU that logs without end must not fill the memory.
        if len(self.log) < 10_000:
            self.log.append((message or b"")[:2000].decode("utf-8", "replace").strip())

    def _asked(self, function: Callable[..., _T], *arguments: Any) -> _T:
        """Return what a function of the slave returns; a refusal becomes `FmuError` with the FMU's own words."""
        seen = len(self.log)
        try:
            return function(*arguments)
        except InputError:
            raise
        except Exception as error:
            own = [_plain(line) for line in self.log[seen:] if line]
            raise FmuError(own[-1] if own else " ".join(str(error).split())) from None

    def call(self, name: str, *arguments: Any) -> None:
        """Call a C function of the instance, its name without prefix, with ctypes objects."""
        self._asked(self.slave.call, name, *arguments)

    def count(self, names: Sequence[str]) -> int:
        """Return how many values the variables hold together, arrays at their present size."""
        return sum(self.fmu.length(n, self.sizes) for n in names)

    def set(self, values: Mapping[str, Any]) -> None:
        """Set variables by name, arrays element by element."""
        for name, value in values.items():
            variable = self.fmu.variables.get(name)
            if variable is None:
                raise unknown_name("variable", name, self.fmu.variables, str(self.fmu.path))
            exchange = exchange_type(variable.type, self._three)
            items = np.ravel(value).tolist() if np.ndim(value) else [value]
            if variable.type == "String" and len(items) == 1:
                self._asked(self.slave.set_string, int(variable.valueReference), str(items[0]))
                continue
            if exchange not in C_TYPES:
                raise InputError(
                    f"{self.fmu.path}: variable {name!r} of type {variable.type} cannot be set here"
                )
            convert = float if variable.type in _REAL else bool if variable.type == "Boolean" else int
            buffer = (C_TYPES[exchange] * len(items))(*(convert(v) for v in items))
            self._exchange(f"Set{exchange[4:]}", [name], buffer, len(items))

    def set_real(self, names: Sequence[str], values: FloatArray) -> None:
        """Set floating-point variables; the values of an array follow each other."""
        if names:
            buffer = np.array(values, dtype=float).ravel()
            self._exchange(
                self._set_real, names, (c_double * len(buffer)).from_buffer(buffer.data), len(buffer)
            )

    def get_real(self, names: Sequence[str]) -> FloatArray:
        """Return floating-point variables; the values of an array follow each other."""
        buffer = np.zeros(self.count(names) if self._three else len(names))
        if names:
            self._exchange(
                self._get_real, names, (c_double * len(buffer)).from_buffer(buffer.data), len(buffer)
            )
        return buffer

    def get_boolean(self, name: str) -> bool:
        """Return a Boolean variable."""
        buffer = (C_TYPES["fmi3Boolean" if self._three else "fmi2Boolean"] * 1)()
        self._exchange("GetBoolean", [name], buffer, 1)
        return bool(buffer[0])

    def _exchange(self, function: str, names: Sequence[str], buffer: Any, count: int) -> None:
        references = self._references(names)
        sizes = (c_size_t(count),) if self._three else ()
        self.call(
            function, (c_uint * len(references))(*references), c_size_t(len(references)), buffer, *sizes
        )

    def derivative(self, unknowns: Sequence[str], knowns: Sequence[str], seed: FloatArray) -> FloatArray:
        """Return the directional derivatives of `unknowns` along `seed`, one number a value of `knowns`."""
        return self._derivatives("GetDirectionalDerivative", unknowns, knowns, seed, unknowns)

    def adjoint(self, unknowns: Sequence[str], knowns: Sequence[str], seed: FloatArray) -> FloatArray:
        """Return the adjoint derivatives (FMI 3.0) for `seed`, one number a value of `unknowns`."""
        return self._derivatives("GetAdjointDerivative", unknowns, knowns, seed, knowns)

    def _derivatives(
        self,
        function: str,
        unknowns: Sequence[str],
        knowns: Sequence[str],
        seed: FloatArray,
        found: Sequence[str],
    ) -> FloatArray:
        count = self.count(found) if self._three else len(found)
        references = self._references(unknowns), self._references(knowns)
        return np.array(
            self._asked(self.slave.derivatives, function, *references, np.ravel(seed).tolist(), count)
        )

    def step(self, time: float, size: float) -> None:
        """Make a communication step; states that were saved before may be restored after it."""
        slave = self.slave
        slave.now.value, slave.size.value = time, size
        function, arguments = slave.advance(keeps_older_states=True)
        self._asked(lambda: slave.passed("DoStep", function(*arguments)))
        reached = slave.reached.value
        if slave.wants_to_end or (slave.early and reached < time + size):
            raise FmuError(f"the step of {size:g} s ended at {reached:g} s instead of {time + size:g} s")

    def save(self) -> Any:
        """Return the FMU state."""
        return self._asked(self.slave.save_state)

    def restore(self, state: Any) -> None:
        """Set the FMU state."""
        self._asked(self.slave.restore_state, state)

    def release(self, state: Any) -> None:
        """Free the FMU state."""
        self._asked(self.slave.free_state, state)

    def serialize(self, state: Any) -> bytes:
        """Return the FMU state as bytes."""
        return self._asked(self.slave.serialize, state)

    def deserialize(self, content: bytes) -> Any:
        """Return the FMU state that `serialize` wrote."""
        return self._asked(self.slave.deserialize, content)

    def reset(self) -> None:
        """Go back to the state after instantiation and initialize again with the start values."""
        self.call("Reset")
        self._initialize()

    def _references(self, names: Sequence[str]) -> list[int]:
        return [self.fmu.variables[n].valueReference for n in names]

    def close(self) -> None:
        """Free the instance; the library is unloaded."""
        self.slave.free()

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
