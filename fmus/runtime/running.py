"""One running FMU whose variables are read and set by name, for checks and for friction models. A master uses `Instance`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from .fmu_files import UnpackedFmu
from .instance import LoadedFmu, Start
from .ports import C_TYPES, Port

__all__ = ["FmuError", "RunningFmu", "UnpackedFmu"]

#: The value of a variable: a number, a text, or the numbers of an array.
Value = bool | int | float | str | Sequence[float] | FloatArray


class FmuError(RuntimeError):
    """An FMU refused a call; the message is the one it logged."""


class RunningFmu(LoadedFmu):
    """An instance in step mode, with values `start` set before initialization. Use it as a context manager.

    A structural parameter of FMI 3.0 in `start` is set in configuration mode.
    Raises InputError: no co-simulation, no binary for this platform, or one that cannot be loaded; a size that cannot be
    set; FmuError: the FMU refuses to start.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     fmu = pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python")
    ...     with RunningFmu(UnpackedFmu.of(fmu)) as running:
    ...         running.set_real(["T", "sigma_n"], [80.0, 600.0])
    ...         running.step(0.0, 0.1)
    ...         running.get_real(["mu"])
    array([0.1])
    """

    def __init__(
        self, fmu: UnpackedFmu, name: str = "friction", start: Mapping[str, Value] | None = None
    ) -> None:
        if fmu.raw.coSimulation is None:
            raise InputError(f"{fmu.path}: the FMU offers no co-simulation, allowed: an FMU that does")
        values = dict(start or {})
        sizes = {n: int(values.pop(n)) for n in fmu.structure if n in values}  # type: ignore[arg-type]
        self._ports: dict[tuple[str, ...], Port] = {}
        fmu = fmu.sized(sizes) if sizes else fmu
        try:
            super().__init__(name, fmu)
        except InputError as error:
            reason = str(error).replace(f"{fmu.path}: ", "").replace(str(fmu.folder), "")[:200]
            raise InputError(
                f"{fmu.path}: no binary for this platform that can be loaded ({reason})"
            ) from None
        try:
            self.initialize(self._starts(values))
        except BaseException:
            self.close()
            raise

    def _not_created(self, cause: str) -> Exception:
        return FmuError(cause)

    def _failed(self, call: str, at: float, cause: str) -> Exception:
        return FmuError(cause)

    def _starts(self, values: Mapping[str, Value]) -> list[Start]:
        """Return the elements of variables with their values; one value serves all elements."""
        pairs: list[Start] = []
        for name, value in values.items():
            elements = self.fmu.resolve(name)
            kind = elements[0]
            if kind.type != "String" and kind.exchange not in C_TYPES:
                raise InputError(f"{self.fmu.path}: variable {name!r} of type {kind.type} cannot be set here")
            items = [value] * len(elements) if isinstance(value, str) or np.ndim(value) == 0 else value
            pairs += zip(elements, items)  # type: ignore[arg-type]
        return pairs

    def call(self, name: str, *arguments: Any) -> None:
        """Call a C function of the instance, its name without prefix, with ctypes objects."""
        with self._doing(""):
            self.slave.call(name, *arguments)

    def set(self, values: Mapping[str, Value]) -> None:
        """Set variables by name; one value serves all elements of an array."""
        with self._doing(""):
            self._assign(self._starts(values))

    def _port(self, names: Sequence[str]) -> Port:
        key = tuple(names)
        if key not in self._ports:
            self._ports[key] = Port([v for name in names for v in self.fmu.resolve(name)])
        return self._ports[key]

    def set_real(self, names: Sequence[str], values: FloatArray | Sequence[float]) -> None:
        """Set numbers; the values of an array follow each other."""
        port = self._port(names)
        port.values[:] = np.ravel(values)
        self.write(port)

    def get_real(self, names: Sequence[str]) -> FloatArray:
        """Return numbers; the values of an array follow each other."""
        port = self._port(names)
        self.read(port)
        return port.values.copy()

    def get_boolean(self, name: str) -> bool:
        """Return a Boolean variable."""
        return bool(self.get_real([name])[0])

    def derivative(self, unknowns: Sequence[str], knowns: Sequence[str], seed: FloatArray) -> FloatArray:
        """Return the directional derivatives of `unknowns` along `seed`, one number a value of `knowns`."""
        count = sum(len(self.fmu.resolve(n)) for n in unknowns)
        return self._derivatives("GetDirectionalDerivative", unknowns, knowns, seed, count)

    def adjoint(self, unknowns: Sequence[str], knowns: Sequence[str], seed: FloatArray) -> FloatArray:
        """Return the adjoint derivatives (FMI 3.0) for `seed`, one number a value of `unknowns`."""
        count = sum(len(self.fmu.resolve(n)) for n in knowns)
        return self._derivatives("GetAdjointDerivative", unknowns, knowns, seed, count)

    def _derivatives(
        self, function: str, unknowns: Sequence[str], knowns: Sequence[str], seed: FloatArray, count: int
    ) -> FloatArray:
        of, by = (
            [r for n in names for r in dict.fromkeys(v.reference for v in self.fmu.resolve(n))]
            for names in (unknowns, knowns)
        )
        with self._doing(""):
            return np.array(self.slave.derivatives(function, of, by, np.ravel(seed).tolist(), count))

    def step(self, time: float, size: float) -> None:
        """Make a communication step; states that were saved before may be restored after it."""
        slave = self.slave
        slave.now.value, slave.size.value = time, size
        function, arguments = slave.advance(keeps_older_states=True)
        with self._doing(""):
            slave.passed("DoStep", function(*arguments))
        reached = slave.reached.value
        if slave.wants_to_end or (slave.early and reached < time + size):
            raise FmuError(f"the step of {size:g} s ended at {reached:g} s instead of {time + size:g} s")

    def serialize(self, state: Any) -> bytes:
        """Return the FMU state as bytes."""
        with self._doing(""):
            return self.slave.serialize(state)

    def deserialize(self, content: bytes) -> Any:
        """Return the FMU state that `serialize` wrote."""
        with self._doing(""):
            return self.slave.deserialize(content)

    def reset(self) -> None:
        """Go back to the state after instantiation and initialize again with the start values of the FMU."""
        super().reset()
        self.initialize(())
