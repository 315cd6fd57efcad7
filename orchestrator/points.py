"""A scalar FMU that runs once a contact point: to the master it is one component with vectors."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from .fmu_files import FmuDescription
from .instance import Instance, Start
from .ports import Port


class PointInstances:
    """One instance a contact point, each with its own memory; same methods as `Instance`.

    Parameters
    ----------
    name : str
        Name of the component.
    description : FmuDescription
        Of the scalar FMU.
    unpacked : Path
        Folder of the unpacked archive, shared by the instances.
    count : int
        Number of points.
    log : list of str, optional
        Receives what the FMUs log.
    """

    def __init__(
        self,
        name: str,
        description: FmuDescription,
        unpacked: Path,
        count: int,
        log: list[str] | None = None,
    ) -> None:
        self.name = name
        self.description = description
        self._parts: dict[int, list[tuple[Port, npt.NDArray[np.intp]]]] = {}
        with ExitStack() as opened:
            self.instances = [
                opened.enter_context(Instance(f"{name}[{k + 1}]", description, unpacked, log))
                for k in range(count)
            ]
            self._opened = opened.pop_all()

    @property
    def seconds(self) -> float:
        """Time spent in steps, exchange of values included [s]."""
        return sum(instance.seconds for instance in self.instances)

    def _split(self, port: Port) -> list[tuple[Port, npt.NDArray[np.intp]]]:
        """Return the port of each instance and where its values stand in `port`."""
        if id(port) not in self._parts:
            rows: list[list[int]] = [[] for _ in self.instances]
            for row, variable in enumerate(port.variables):
                rows[variable.point].append(row)
            self._parts[id(port)] = [
                (Port([port.variables[i] for i in part]), np.array(part, dtype=np.intp)) for part in rows
            ]
        return self._parts[id(port)]

    def enter_initialization(self, starts: Iterable[Start], stop_time: float) -> None:
        """Set start values, the same in every instance, and enter initialization mode."""
        values = list(starts)
        for instance in self.instances:
            instance.enter_initialization(values, stop_time)

    def exit_initialization(self) -> None:
        """Leave initialization mode: the FMUs are ready for steps."""
        for instance in self.instances:
            instance.exit_initialization()

    def step(self, inputs: Port, outputs: Port, now: float, size: float) -> None:
        """Write the inputs, advance every instance from `now` by `size` seconds, read the outputs."""
        parts = zip(self.instances, self._split(inputs), self._split(outputs))
        for instance, (given, rows), (found, places) in parts:
            given.values[:] = inputs.values[rows]
            instance.step(given, found, now, size)
            outputs.values[places] = found.values

    def write(self, inputs: Port, now: float = 0.0) -> None:
        """Write inputs outside a step."""
        for instance, (given, rows) in zip(self.instances, self._split(inputs)):
            given.values[:] = inputs.values[rows]
            instance.write(given, now)

    def read(self, outputs: Port, now: float = 0.0) -> None:
        """Read outputs outside a step."""
        for instance, (found, rows) in zip(self.instances, self._split(outputs)):
            instance.read(found, now)
            outputs.values[rows] = found.values

    def save_state(self) -> Any:
        """Return handles to the states of all instances; give them to `free_state` in the end."""
        return [instance.save_state() for instance in self.instances]

    def restore_state(self, state: Any) -> None:
        """Go back to saved states."""
        for instance, one in zip(self.instances, state):
            instance.restore_state(one)

    def free_state(self, state: Any) -> None:
        """Give up saved states."""
        for instance, one in zip(self.instances, state):
            instance.free_state(one)

    def reset(self) -> None:
        """Bring every instance back to where instantiation left it."""
        for instance in self.instances:
            instance.reset()

    def close(self) -> None:
        """Terminate and unload; safe after a failure."""
        self._opened.close()

    def __enter__(self) -> PointInstances:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
