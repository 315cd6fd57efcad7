"""Systems from SSP archives."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from fmus.runtime.fmu_files import FmuDescription, describe
from fmus.runtime.fmu_variables import StartValue, Variable
from fmus.ssp.reading import read_ssp, unpack_ssp
from friction_models.common import InputError

from .setup.description import TemporaryFolder


def read_system(path: str | os.PathLike[str]) -> tuple[TemporaryFolder, dict[str, object]]:
    """Unpack the FMUs of an SSP archive; return their folder and the system as it would stand in a YAML file there.

    Connections to the system's own connectors are left out: there is nothing outside. Inputs that nothing
    feeds keep the start value of the system's input, if it has one, else that of their FMU. The communication step
    comes from the annotations of this project, of libcosim or of OMSimulator, else from the default experiments of the FMUs.
    """
    file = Path(path)
    structure = read_ssp(file)
    place = TemporaryFolder()
    unpack_ssp(file, place.folder)
    descriptions = {c.name: describe(place.folder / c.source) for c in structure.components}
    fed = {(end, given) for start, _, end, given in structure.connections if start}
    components = {}
    for component in structure.components:
        description = descriptions[component.name]
        start: dict[str, StartValue] = {
            name: _start(v)
            for name, v in description.variables.items()
            if v.causality == "input"
            and (component.name, name) not in fed
            and v.type in {"Real", "Integer", "Boolean"}
        }
        prefix = f"{component.name}."
        start |= {k.removeprefix(prefix): v for k, v in structure.start.items() if k.startswith(prefix)}
        outside = {
            given: structure.start[output]
            for begin, output, end, given in structure.connections
            if not begin and end == component.name and output in structure.start
        }
        components[component.name] = {"fmu": component.source, "start": start | component.start | outside}
    step = structure.step or _default(descriptions.values(), "stepSize", min)
    stop = structure.stop or _default(descriptions.values(), "stopTime", max)
    for value, what in ((step, "communication step"), (stop, "stop time")):
        if value is None:
            raise InputError(f"{file}: neither the SSP nor its FMUs say a {what}")
    known = {
        k: structure.notes[k] for k in ("order", "record", "synthetic", "provenance") if k in structure.notes
    }
    content = {
        "name": structure.notes.get("name", structure.name),
        "communication_step": step,
        "stop_time": stop,
        "components": components,
        "connections": [f"{a}.{x} -> {b}.{y}" for a, x, b, y in structure.connections if a and b],
    }
    return place, content | known


def _start(variable: Variable) -> bool | int | float:
    value: Any = variable.starts[variable.element]
    if variable.type == "Boolean":
        return bool(value)
    return int(value) if variable.type == "Integer" else float(value)


def _default(
    descriptions: Iterable[FmuDescription], key: str, choose: Callable[[list[float]], float]
) -> float | None:
    """Return the smallest or largest of a value that the FMUs give for their default experiment."""
    experiments = [one.raw.defaultExperiment for one in descriptions]
    values = [getattr(experiment, key, None) for experiment in experiments]
    found = [float(value) for value in values if value is not None]
    return choose(found) if found else None
