"""An FMU instance in a separate process, with the methods of `Instance`."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.loads import FloatArray

from .contact_points import PointInstances
from .errors import SimulationEnded, SimulationError
from .fmu_files import UnpackedFmu
from .fmu_variables import Variable
from .instance import AnyInstance, Instance, Start
from .ports import Port
from .separate_process import PATIENCE, Apart, Died

_clock = time.perf_counter


class IsolatedInstance(AnyInstance):
    """An `Instance`, or `PointInstances` with a number of points, in a process of its own.

    A step is one message to and fro, whole vectors in it. `waiting` is called every now and then during a call; what it
    raises ends the process.
    Raises InputError: the binary cannot be loaded, or creates no instance; SimulationError: it ends its process.
    """

    seconds = 0.0
    ended = False

    def __init__(
        self,
        name: str,
        fmu: UnpackedFmu,
        points: int | None,
        log: list[str],
        parts: int = 1,
        waiting: Callable[[], None] | None = None,
    ) -> None:
        self.name = name
        self.log = log
        self._ports: dict[int, tuple[int, Port]] = {}
        arguments = (name, str(fmu.path), dict(fmu.sizes), str(fmu.folder), points, parts)
        errors = (SimulationError, SimulationEnded)
        self._apart = Apart(_Served, *arguments, errors=errors, waiting=waiting)
        self._ask("loading", 0.0, "ready")

    def _ask(self, doing: str, now: float, method: str, *arguments: Any) -> Any:
        try:
            return self._apart.call(method, *arguments)
        except Died as end:
            raise SimulationError(
                f"component {self.name!r} failed at t = {now:g} s in {doing}: {end}"
            ) from None
        except Exception:
            self._take_log()
            raise

    def _take_log(self) -> None:
        with contextlib.suppress(Died, RuntimeError):  # what was said with the last breath is lost
            self.log += self._apart.call("taken_log")

    def _number(self, port: Port) -> int:
        if id(port) not in self._ports:
            number = int(self._ask("the exchange of values", 0.0, "port", port.variables))
            self._ports[id(port)] = (number, port)  # kept alive, so that its id stays its own
        return self._ports[id(port)][0]

    def enter_initialization(self, starts: Iterable[Start], stop_time: float) -> None:
        self._ask("initialization", 0.0, "enter_initialization", list(starts), stop_time)

    def exit_initialization(self) -> None:
        self._ask("initialization", 0.0, "exit_initialization")
        self._take_log()

    def step(self, inputs: Port, outputs: Port, now: float, size: float) -> None:
        began = _clock()
        numbers = self._number(inputs), self._number(outputs)
        answer: FloatArray = self._ask("a step", now, "step", *numbers, inputs.values.tobytes(), now, size)
        outputs.values[:] = answer[:-2]
        self.ended = bool(answer[-2])
        if answer[-1]:
            self._take_log()
        self.seconds += _clock() - began

    def write(self, inputs: Port, now: float = 0.0) -> None:
        self._ask("setting inputs", now, "write", self._number(inputs), inputs.values.tobytes(), now)

    def read(self, outputs: Port, now: float = 0.0) -> None:
        outputs.values[:] = self._ask("reading outputs", now, "read", self._number(outputs), now)

    def save_state(self, now: float = 0.0) -> int:
        return int(self._ask("saving the state", now, "save_state", now))

    def restore_state(self, state: int, now: float = 0.0) -> None:
        self._ask("restoring the state", now, "restore_state", state, now)

    def free_state(self, state: int) -> None:
        with contextlib.suppress(Died):  # gone with its process
            self._apart.call("free_state", state)

    def close(self) -> None:
        until = _clock() + PATIENCE

        def waiting() -> None:
            if _clock() > until:
                raise Died("it did not end")

        self._apart.waiting = waiting  # the interrupt that led here was dealt with
        with contextlib.suppress(Died, RuntimeError):
            self._apart.call("close")  # an FMU may have something to say at its end
        self._take_log()
        self._apart.close()


class _Served:
    """The other end of `IsolatedInstance`."""

    def __init__(
        self, name: str, path: str, sizes: dict[str, int], unpacked: str, points: int | None, parts: int
    ) -> None:
        fmu = UnpackedFmu.of(path, Path(unpacked)).sized(sizes)
        self.log: list[str] = []
        self.ports: list[Port] = []
        self.states: dict[int, Any] = {}
        self.instance: Instance | PointInstances = (
            Instance(name, fmu, self.log, parts)
            if points is None
            else PointInstances(name, fmu, points, self.log, parts)
        )
        self.enter_initialization = self.instance.enter_initialization
        self.exit_initialization = self.instance.exit_initialization
        self.close = self.instance.close

    def ready(self) -> None:
        """Say that the FMU is there."""

    def taken_log(self) -> list[str]:
        taken, self.log[:] = list(self.log), []
        return taken

    def port(self, variables: list[Variable]) -> int:
        self.ports.append(Port(variables))
        return len(self.ports) - 1

    def step(self, written: int, read: int, values: bytes, now: float, size: float) -> FloatArray:
        given, found = self.ports[written], self.ports[read]
        given.values[:] = np.frombuffer(values)
        self.instance.step(given, found, now, size)
        return np.concatenate([found.values, (self.instance.ended, bool(self.log))])

    def write(self, number: int, values: bytes, now: float) -> None:
        self.ports[number].values[:] = np.frombuffer(values)
        self.instance.write(self.ports[number], now)

    def read(self, number: int, now: float) -> FloatArray:
        self.instance.read(self.ports[number], now)
        return self.ports[number].values

    def save_state(self, now: float) -> int:
        number = max(self.states, default=0) + 1
        self.states[number] = self.instance.save_state(now)
        return number

    def restore_state(self, number: int, now: float) -> None:
        self.instance.restore_state(self.states[number], now)

    def free_state(self, number: int) -> None:
        self.instance.free_state(self.states.pop(number))
