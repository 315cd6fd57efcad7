"""A user's co-simulation of a forming process: which component does what, and how an attribution varies it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from fmus.archive.content import read_member
from fmus.runtime.fmu_files import FmuDescription, describe
from forming.press import PressLevel
from friction_models.common import InputError
from friction_models.loads import MU

from ..cosim.setup.connections import split_connection
from ..cosim.system import System


@dataclass(frozen=True)
class FormingSystem:
    """A user's system of friction and forming FMU, each with the name of its component."""

    system: System
    forming: str
    friction: str
    description: FmuDescription  # of the forming FMU
    process: str  # empty for a forming FMU that is not of this project
    config: dict[str, object]  # what a forming FMU of this project was packed from
    fmi: str = "2.0"  # version of the friction FMU's interface

    @classmethod
    def of(cls, system: System) -> FormingSystem:
        """Find forming process and friction model in a system.

        The process computes stroke and force from mu, and has the parameters ``speed`` and ``T_tool``.
        """
        found = {name: describe(system.fmu_path(name)) for name in system.components}
        forming = [
            n for n, d in found.items() if {"stroke", "force"} <= d.variables.keys() and MU.name in d.arrays
        ]
        if len(forming) != 1:
            raise InputError(
                f"{system.source}: {len(forming)} components have stroke, force and mu; allowed: one forming process"
            )
        (name,) = forming
        connected = [parts for c in system.connections if (parts := split_connection(c)) is not None]
        sources = {
            source.rpartition(".")[0]
            for source, target, _ in connected
            if target.partition("[")[0].strip() == f"{name}.{MU.name}"
        }
        if len(sources) != 1:
            raise InputError(
                f"{system.source}: {name}.mu comes from {len(sources)} components; allowed: one friction FMU"
            )
        (friction,) = sources
        for parameter in ("speed", "T_tool"):
            if parameter not in found[name].variables:
                raise InputError(
                    f"{found[name].path}: no parameter {parameter!r}; allowed: a forming FMU with speed and T_tool, "
                    "which every level of the press sets"
                )
        config = _config(found[name].path)
        fmi = str(found[friction].raw.fmiVersion)
        return cls(system, name, friction, found[name], str(config.get("process", "")), config, fmi)

    @property
    def nodes(self) -> int:
        """Contact points of the forming FMU."""
        return len(self.description.resolve(MU.name))

    @property
    def travel(self) -> float:
        """Punch travel of one communication step [mm]."""
        speed = self.start_of("speed")
        assert speed is not None
        return self.system.communication_step * speed

    def start_of(self, parameter: str) -> float | None:
        """Return the value of a forming parameter in the system; None where the FMU has none."""
        own = self.system.components[self.forming].start.get(parameter)
        if own is not None:
            return float(own)  # type: ignore[arg-type]
        for variable in self.description.raw.modelVariables:
            if variable.name == parameter and variable.start is not None:
                return float(variable.start)
        return None

    def at(
        self, level: PressLevel, friction: Path, forming: Path, changes: dict[str, dict[str, float]]
    ) -> System:
        """Return the system at a level of the press, with other FMUs and start values."""
        fmus = {name: str(self.system.fmu_path(name)) for name in self.system.components}
        content = self.system.to_dict(fmus | {self.friction: str(friction), self.forming: str(forming)})
        parts = content["components"]
        parts[self.forming]["start"] |= {"speed": level.speed, "T_tool": level.T_tool}
        for name, values in changes.items():
            parts[name]["start"] |= values
        recorded = float(level.curves.groupby("repeat")["stroke"].max().min())
        asked = self.travel * self.system.steps
        steps = max(1, int(min(recorded, asked) / self.travel + 1e-6))
        content["communication_step"] = self.travel / level.speed
        content["stop_time"] = content["communication_step"] * steps
        content["record"] = [f"{self.forming}.stroke", f"{self.forming}.force"]
        content["name"] = self.system.name[:80]
        return System.from_dict(content, source=self.system.source)


def _config(fmu: Path) -> dict[str, object]:
    """Return what a forming FMU of this project was packed from; empty for any other."""
    try:
        content = json.loads(read_member(fmu, "resources/interface.json", 64 * 1024**2))
    except (InputError, ValueError, RecursionError):
        return {}
    good = isinstance(content, dict) and {"process", "fixed", "material"} <= content.keys()
    return content if good else {}
