"""Running components of a system, and the transfer of values between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from fmus.runtime.errors import SimulationError
from fmus.runtime.instance import AnyInstance
from fmus.runtime.ports import Port
from friction_models.loads import FloatArray

from .points_without_pressure import Patch, PointsWithoutPressure
from .setup.description import SystemDescription
from .setup.wiring import Wiring

_Index: TypeAlias = npt.NDArray[np.intp] | slice


@dataclass
class Transfer:
    """Copies the values of all connections between two components; converts units where they differ."""

    source: str
    rows: _Index
    target: str
    places: _Index
    scale: tuple[FloatArray, FloatArray] | None
    patches: list[Patch]

    def apply(self, inputs: Mapping[str, Port], outputs: Mapping[str, Port]) -> None:
        """Hand the newest values on."""
        values = outputs[self.source].values[self.rows]
        if self.scale is not None:
            values = self.scale[0] * values + self.scale[1]
        if self.patches:
            values = values.copy()  # a slice shows the outputs themselves
            for patch in self.patches:
                patch.apply(values, outputs)
        inputs[self.target].values[self.places] = values


@dataclass
class Components:
    """Instances and ports of a system by component, and the transfers between them."""

    instances: Mapping[str, AnyInstance]
    order: Sequence[str]  # of evaluation
    #: What is connected or recorded of each component.
    inputs: dict[str, Port] = field(default_factory=dict)
    outputs: dict[str, Port] = field(default_factory=dict)
    incoming: dict[str, list[Transfer]] = field(default_factory=dict)  # by target
    #: Components that get other loads at points without contact.
    without_pressure: dict[str, PointsWithoutPressure] = field(default_factory=dict)

    @classmethod
    def of(
        cls, system: SystemDescription, wiring: Wiring, instances: Mapping[str, AnyInstance]
    ) -> Components:
        """Make the ports of all instances and the transfers of all connections."""
        made = cls(instances, system.evaluation_order())
        for name in wiring.descriptions:
            fed = [v for link in wiring.links if link.target == name for v in link.targets]
            given = [v for link in wiring.links if link.source == name for v in link.sources]
            given += [v for item in wiring.recorded if item.component == name for v in item.elements]
            made.inputs[name] = Port(fed)
            made.outputs[name] = Port({v.name: v for v in given}.values())
        for name, component in system.components.items():
            found = (
                PointsWithoutPressure.of(name, wiring.links, made.outputs) if component.contact_only else None
            )
            if found is not None:
                made.without_pressure[name] = found
        made.incoming = {name: [] for name in made.order}
        for transfer in made._transfers(wiring):
            made.incoming[transfer.target].append(transfer)
        return made

    def _transfers(self, wiring: Wiring) -> list[Transfer]:
        """Return one transfer for all connections of a pair of components."""
        pairs: dict[tuple[str, str], tuple[list[int], list[int], list[float], list[float]]] = {}
        patches: dict[tuple[str, str], list[Patch]] = {}
        for link in wiring.links:
            pair = (link.source, link.target)
            rows, places, factors, offsets = pairs.setdefault(pair, ([], [], [], []))
            for name, points in self.without_pressure.items():
                patch = points.patch(name, link, len(rows))
                if patch is not None:
                    patches.setdefault(pair, []).append(patch)
            rows += [self.outputs[link.source].index[v.name] for v in link.sources]
            places += [self.inputs[link.target].index[v.name] for v in link.targets]
            factors += [link.factor] * len(link.sources)
            offsets += [link.offset] * len(link.sources)
        transfers = []
        for (source, target), (rows, places, factors, offsets) in pairs.items():
            scaled = any(f != 1.0 for f in factors) or any(offsets)
            scale = (np.array(factors), np.array(offsets)) if scaled else None
            kept = patches.get((source, target), [])
            transfers.append(Transfer(source, _places(rows), target, _places(places), scale, kept))
        return transfers

    def hand_over(self, name: str) -> None:
        """Copy the newest values to the inputs of a component."""
        for transfer in self.incoming[name]:
            transfer.apply(self.inputs, self.outputs)

    def step(self, name: str, now: float, size: float) -> None:
        """Let a component make a step, and check what it gives out."""
        self.instances[name].step(self.inputs[name], self.outputs[name], now, size)
        if np.isnan(self.outputs[name].values).any():
            self.check_numbers(name, now + size)

    def check_numbers(self, name: str, at: float) -> None:
        """Raise where an output is not a number, unless it belongs to a point without contact that the component need not answer."""
        port = self.outputs[name]
        wrong = np.isnan(port.values)
        if name in self.without_pressure:
            idle = self.without_pressure[name].points(self.outputs)
            for rows in port.vectors().values():
                if len(rows) == len(idle):
                    wrong[rows] &= ~idle
        if wrong.any():
            found = port.variables[int(np.argmax(wrong))].name
            more = f" (and {int(wrong.sum()) - 1} more values)" if wrong.sum() > 1 else ""
            raise SimulationError(
                f"component {name!r} gives {found!r} = nan at t = {at:g} s{more}; allowed: a number"
            )

    def initialize(self, wiring: Wiring, stop_time: float) -> None:
        """Initialize all components, connected inputs with what feeds them.

        Values pass along the connections as often as there are components, so that they get through any
        chain of them; libcosim and ecos do the same, and start from the same values.
        """
        for name, instance in self.instances.items():
            instance.enter_initialization(wiring.starts[name], stop_time)
            if self.inputs[name].is_partial:
                instance.read(self.inputs[name])  # the elements that no connection feeds
        for _ in self.instances:
            for name, instance in self.instances.items():
                instance.read(self.outputs[name])
            for name, instance in self.instances.items():
                self.hand_over(name)
                instance.write(self.inputs[name])
        for name, instance in self.instances.items():
            instance.exit_initialization()
            instance.read(self.outputs[name])

    def needed_at_start(self, mode: str) -> set[str]:
        """Return the components whose values from before the first step are used by others."""
        rank = {name: k for k, name in enumerate(self.order)}
        pairs = {(t.source, t.target) for several in self.incoming.values() for t in several}
        return {a for a, b in pairs if mode == "jacobi" or rank[b] <= rank[a]}


def _places(numbers: list[int]) -> _Index:
    """Return an index for these places: a slice where they follow each other, which is faster."""
    first = numbers[0]
    if numbers == list(range(first, first + len(numbers))):
        return slice(first, first + len(numbers))
    return np.array(numbers, dtype=np.intp)
