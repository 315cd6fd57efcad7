"""One running FMU of a co-simulation. Buffers and calls of a step are prepared once, because steps must be fast."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol, Self

from friction_models.common import InputError

from .c_interface import Slave, load
from .c_interface.slave import DISCARD, WARNING, CallFailed
from .errors import SimulationEnded, SimulationError
from .fmu_files import UnpackedFmu
from .fmu_variables import Variable
from .messages import Messages
from .ports import Port

#: Name, function and arguments of a prepared call.
_Call = tuple[str, Any, tuple[Any, ...]]
#: A variable and its start value.
Start = tuple[Variable, bool | int | float | str]
_clock = time.perf_counter


class AnyInstance(Protocol):
    """What a master needs of a component: `Instance`, `PointInstances`, or either of them in a process of its own."""

    @property
    def seconds(self) -> float:
        """Time spent in steps, exchange of values included [s]."""

    @property
    def ended(self) -> bool:
        """Whether the FMU made its last step: it asked to end the simulation."""

    def enter_initialization(self, starts: Iterable[Start], stop_time: float) -> None:
        """Set start values and enter initialization mode: now values can be read and written."""

    def exit_initialization(self) -> None:
        """Leave initialization mode: the FMU is ready for steps."""

    def step(self, inputs: Port, outputs: Port, now: float, size: float) -> None:
        """Write the inputs, advance from `now` by `size` seconds, read the outputs.

        Raises SimulationError: the FMU refused a call; SimulationEnded: it ended the simulation before the step was complete.
        With a complete step `ended` is set.
        """

    def write(self, inputs: Port, now: float = 0.0) -> None:
        """Write inputs outside a step."""

    def read(self, outputs: Port, now: float = 0.0) -> None:
        """Read outputs outside a step."""

    def save_state(self, now: float = 0.0) -> Any:
        """Return a handle to the complete state; give it to `free_state` in the end."""

    def restore_state(self, state: Any, now: float = 0.0) -> None:
        """Go back to a saved state."""

    def free_state(self, state: Any) -> None:
        """Give up a saved state."""

    def close(self) -> None:
        """Terminate and unload; safe after a failure."""


class LoadedFmu:
    """A loaded co-simulation FMU (FMI 2.0 or 3.0) between instantiation and `close`; the methods are those of `AnyInstance`."""

    def __init__(self, name: str, fmu: UnpackedFmu, log: list[str] | None = None) -> None:
        self.name = name
        self.fmu = fmu
        self.log = log if log is not None else []
        self._messages = Messages(name, self.log)
        self._running = False
        self.slave: Slave = load(fmu.path, fmu.raw, fmu.folder)
        # FMI 2.0 messages are formats, those of FMI 3.0 plain text.
        formats = fmu.version == "2.0"
        try:
            self.slave.instantiate(name, lambda status, text: self._messages.receive(status, text, formats))
            self._configure()
        except InputError:
            self.slave.free()
            raise
        except Exception as error:
            self.slave.free()
            raise self._not_created(self._messages.cause(error)) from None

    def _configure(self) -> None:
        """Set the structural parameters (FMI 3.0) that differ from their start values."""
        if self.fmu.sizes:
            self.slave.call("EnterConfigurationMode")
            self._assign((self.fmu.variables[name], value) for name, value in self.fmu.sizes.items())
            self.slave.call("ExitConfigurationMode")

    def _not_created(self, cause: str) -> Exception:
        return InputError(
            f"{self.fmu.path}: component {self.name!r}: {cause}; allowed: an FMU whose binary "
            f"accepts the GUID of its model description, {str(self.fmu.raw.guid)[:60]!r}"
        )

    def _failed(self, call: str, at: float, cause: str) -> Exception:
        return SimulationError(f"component {self.name!r} failed at t = {at:g} s in {call}: {cause}")

    def _failure(self, call: str, at: float, error: BaseException) -> Exception:
        self._running = False
        return self._failed(call, at, self._messages.cause(error))

    @contextmanager
    def _doing(self, call: str, at: float = 0.0) -> Iterator[None]:
        """Let a refused call become an error that says what was done, when and why it failed."""
        self._messages.forget()
        try:
            yield
        except CallFailed as error:
            raise self._failure(call, at, error) from None

    def initialize(self, starts: Iterable[Start], stop_time: float | None = None) -> None:
        """Set start values and go through initialization mode; without a stop time the end is open."""
        self.enter_initialization(starts, stop_time)
        self.exit_initialization()

    def _assign(self, starts: Iterable[Start]) -> None:
        numbers: dict[str, tuple[Variable, float]] = {}
        for variable, value in starts:
            if variable.type == "String":
                self.slave.set_string(variable.reference, str(value))
            else:
                numbers[variable.name] = (variable, float(value))
        port = Port([variable for variable, _ in numbers.values()])
        port.values[:] = [value for _, value in numbers.values()]
        self._set(port)

    def enter_initialization(self, starts: Iterable[Start], stop_time: float | None = None) -> None:
        with self._doing("initialization"):
            self._assign(starts)
            self.slave.enter_initialization(stop_time)

    def exit_initialization(self) -> None:
        with self._doing("initialization"):
            self.slave.exit_initialization()
        self._running = True

    def _calls(self, port: Port, direction: str) -> list[_Call]:
        return [
            (direction + group.exchange[4:], *self.slave.exchange(group, direction)) for group in port.groups
        ]

    def _set(self, port: Port) -> None:
        port.to_buffers()
        for name, function, arguments in self._calls(port, "Set"):
            self.slave.passed(name, function(*arguments))

    def write(self, inputs: Port, now: float = 0.0) -> None:
        with self._doing("setting inputs", now):
            self._set(inputs)

    def read(self, outputs: Port, now: float = 0.0) -> None:
        with self._doing("reading outputs", now):
            for name, function, arguments in self._calls(outputs, "Get"):
                self.slave.passed(name, function(*arguments))
        outputs.from_buffers()

    def save_state(self, now: float = 0.0) -> Any:
        with self._doing("saving the state", now):
            return self.slave.save_state()

    def restore_state(self, state: Any, now: float = 0.0) -> None:
        with self._doing("restoring the state", now):
            self.slave.restore_state(state)

    def free_state(self, state: Any) -> None:
        self.slave.free_state(state)

    def reset(self) -> None:
        """Bring the FMU back to where instantiation left it."""
        with self._doing("reset"):
            self.slave.call("Reset")
        self._running = False

    def close(self) -> None:
        slave = self.slave
        if self._running:
            self._running = False
            try:
                slave.call("Terminate")
            except CallFailed as error:
                self._messages.note(f"terminate: {self._messages.cause(error)}")
        slave.free()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class Instance(LoadedFmu):
    """An FMU that runs in a system as the component `name`; it makes `parts` steps in each communication step.

    `fmu` comes from `unpack`; `log` receives what the FMU logs.
    Raises InputError: the binary cannot be loaded, or creates no instance (a wrong GUID, for example).
    """

    def __init__(self, name: str, fmu: UnpackedFmu, log: list[str] | None = None, parts: int = 1) -> None:
        super().__init__(name, fmu, log)
        self.seconds = 0.0
        self.ended = False
        self._parts = parts
        self._now, self._size = self.slave.now, self.slave.size
        self._inputs = self._outputs = Port([])
        self._step = self._bound(self._inputs, self._outputs)

    def reset(self) -> None:
        super().reset()
        self.ended = False

    def step(self, inputs: Port, outputs: Port, now: float, size: float) -> None:
        began = _clock()
        self._messages.forget()
        if inputs is not self._inputs or outputs is not self._outputs:
            self._step = self._bound(inputs, outputs)
            self._inputs, self._outputs = inputs, outputs
        self._now.value = now
        self._size.value = size
        try:
            self._step()
        except CallFailed as error:
            raise self._failure("a step", now, error) from None
        self.seconds += _clock() - began

    def _bound(self, inputs: Port, outputs: Port) -> Callable[[], None]:
        """Return one function that makes all calls of a step on these ports; it raises `CallFailed`."""
        refused = self.slave.refused
        sets, gets = self._calls(inputs, "Set"), self._calls(outputs, "Get")
        wants_to_end, finish = self.slave.wants_to_end, self._finish
        advance, step = self.slave.advance() if self._parts == 1 else (self._in_parts(), ())

        def general() -> None:
            inputs.to_buffers()
            for name, function, arguments in sets:
                status = function(*arguments)
                if status > WARNING:
                    refused(name, status)
            status = advance(*step)
            if status > WARNING or wants_to_end:
                finish(status)
            for name, function, arguments in gets:
                status = function(*arguments)
                if status > WARNING:
                    refused(name, status)
            outputs.from_buffers()

        if not (inputs.is_direct and outputs.is_direct and len(sets) == len(gets) == 1):
            return general
        ((_, write, written),) = sets
        ((_, read, found),) = gets

        # Real numbers in and out and nothing else: three calls and hardly anything around them.
        def direct() -> None:
            status = write(*written)
            if status > WARNING:
                refused(sets[0][0], status)
            status = advance(*step)
            if status > WARNING or wants_to_end:
                finish(status)
            status = read(*found)
            if status > WARNING:
                refused(gets[0][0], status)

        return direct

    def _in_parts(self) -> Callable[[], int]:
        """Return a function that makes the smaller steps of a communication step."""
        advance, step = self.slave.advance()
        now, size, parts = self._now, self._size, self._parts
        wants_to_end = self.slave.wants_to_end

        def several() -> int:
            begin, whole = now.value, size.value
            size.value = whole / parts
            for k in range(parts):
                now.value = begin + k * (whole / parts)
                status = int(advance(*step))
                if status > WARNING or wants_to_end:
                    if k < parts - 1:
                        self.slave.early.value = True
                    break
            size.value = whole
            return status

        return several

    def _finish(self, status: int) -> None:
        """Deal with a step that was refused, or after which the FMU asks to end the simulation."""
        slave = self.slave
        end = self._now.value + self._size.value / self._parts
        if status > WARNING:
            if status != DISCARD or self._messages.complained or not slave.terminated():
                slave.refused("DoStep", status)
            slave.early.value = slave.early.value or slave.reached.value < end - 1e-9 * self._size.value
        else:
            slave.reached.value = max(slave.reached.value, self._now.value)
        if slave.early:
            said = self._messages.cause("")
            raise SimulationEnded(
                f"component {self.name!r} ended the simulation at t = {slave.reached.value:g} s"
                + (f": {said}" if said else "")
            )
        self.ended = True
