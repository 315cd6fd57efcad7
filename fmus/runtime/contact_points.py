"""One FMU instance for each contact point, with the methods of one `Instance` whose variables are vectors."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from friction_models.loads import FloatArray

from .fmu_files import UnpackedFmu
from .instance import AnyInstance, Instance, Start
from .ports import Port


@dataclass(frozen=True)
class _Split:
    """A port of all points, cut into the ports of the instances.

    `values` holds what is in `ports`, one after the other: value k of it is value `order[k]` of `whole`.
    """

    whole: Port
    ports: list[Port]
    values: FloatArray
    order: npt.NDArray[np.intp]


class PointInstances(AnyInstance):
    """One `Instance` a contact point of a scalar FMU, each with its own memory; they share the folder of the FMU."""

    def __init__(
        self, name: str, fmu: UnpackedFmu, count: int, log: list[str] | None = None, parts: int = 1
    ) -> None:
        self._splits: dict[int, _Split] = {}
        with ExitStack() as opened:
            self.instances = [
                opened.enter_context(Instance(f"{name}[{k + 1}]", fmu, log, parts)) for k in range(count)
            ]
            self._opened = opened.pop_all()

    @property
    def seconds(self) -> float:
        return sum(instance.seconds for instance in self.instances)

    @property
    def ended(self) -> bool:
        return any(instance.ended for instance in self.instances)

    def _split(self, port: Port) -> _Split:
        """Return the port of each instance, all in one array."""
        if id(port) not in self._splits:
            rows: list[list[int]] = [[] for _ in self.instances]
            for row, variable in enumerate(port.variables):
                rows[variable.point].append(row)
            order = np.array([row for part in rows for row in part], dtype=np.intp)
            values = port.values[order]
            ends = np.cumsum([len(part) for part in rows])
            ports = [
                Port([port.variables[i] for i in part], values[end - len(part) : end])
                for part, end in zip(rows, ends)
            ]
            self._splits[id(port)] = _Split(port, ports, values, order)
        return self._splits[id(port)]

    def enter_initialization(self, starts: Iterable[Start], stop_time: float) -> None:
        values = list(starts)
        for instance in self.instances:
            instance.enter_initialization(values, stop_time)

    def exit_initialization(self) -> None:
        for instance in self.instances:
            instance.exit_initialization()

    def step(self, inputs: Port, outputs: Port, now: float, size: float) -> None:
        given, found = self._split(inputs), self._split(outputs)
        given.values[:] = inputs.values[given.order]
        for instance, written, read in zip(self.instances, given.ports, found.ports):
            instance.step(written, read, now, size)
        outputs.values[found.order] = found.values

    def write(self, inputs: Port, now: float = 0.0) -> None:
        given = self._split(inputs)
        given.values[:] = inputs.values[given.order]
        for instance, written in zip(self.instances, given.ports):
            instance.write(written, now)

    def read(self, outputs: Port, now: float = 0.0) -> None:
        found = self._split(outputs)
        for instance, read in zip(self.instances, found.ports):
            instance.read(read, now)
        outputs.values[found.order] = found.values

    def save_state(self, now: float = 0.0) -> Any:
        return [instance.save_state(now) for instance in self.instances]

    def restore_state(self, state: Any, now: float = 0.0) -> None:
        for instance, one in zip(self.instances, state):
            instance.restore_state(one, now)

    def free_state(self, state: Any) -> None:
        for instance, one in zip(self.instances, state):
            instance.free_state(one)

    def close(self) -> None:
        self._opened.close()
