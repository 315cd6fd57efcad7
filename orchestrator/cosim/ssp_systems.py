"""Systems as SSP archives: `export_ssp` writes one, `load_ssp` reads one for the master."""

from __future__ import annotations

import os
import shutil
import tempfile
import weakref
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fmus.runtime.fmu_files import FmuDescription, describe
from fmus.runtime.fmu_variables import Variable
from friction_models.common import InputError
from friction_models.loads import MU

if TYPE_CHECKING:
    from fmus.ssp.systems import Component, Connector, Structure

    from .system import System
    from .wiring import Wiring


class UnpackedSsp:
    """The folder of an unpacked SSP; it lasts as long as a system refers to it."""

    def __init__(self, folder: str | None = None) -> None:
        self.folder = Path(folder or tempfile.mkdtemp(prefix="tribofmu-")).resolve()
        if folder is None:
            weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)

    def __deepcopy__(self, _memo: Any) -> UnpackedSsp:
        return self

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        # Another process borrows the folder; it does not own it.
        return UnpackedSsp, (str(self.folder),)


def export_ssp(system: System, path: str | os.PathLike[str], boundary: bool = False) -> Path:
    """Write a system as an SSP 1.0 archive that other simulators load.

    A scalar friction FMU that runs once a contact point becomes one component a point (``friction_1`` ...),
    and so does a friction FMU of FMI 3.0, as SSP 1.0 has no arrays; all of them refer to one resource.

    Parameters
    ----------
    system : System
        What to write; swap FMUs before.
    path : path-like
        The archive (``.ssp``).
    boundary : bool
        Make what the run records outputs of the system (``forming_force``), and what has a start value and no
        connection inputs of it (``friction_T``), which start there, too. Tools that turn an SSP into one FMU need
        that; libcosim and ecos refuse connections to the system itself.

    Raises
    ------
    InputError
        A set-up that does not hold (all problems at once), or arrays that SSP 1.0 cannot express.
    """
    from fmus.ssp.systems import Connector, Structure
    from fmus.ssp.writing import write_ssp

    from .wiring import Wiring

    wiring = Wiring.of(system)
    scaled = next((link for link in wiring.links if (link.factor, link.offset) != (1.0, 0.0)), None)
    if scaled is not None:
        raise InputError(
            f"{system.source}: a connection to {scaled.target}.{scaled.targets[0].name} converts units, which an archive "
            "cannot hold; allowed: FMUs that share the units of what they exchange"
        )
    careful = next((name for name, c in system.components.items() if c.contact_only), None)
    if careful is not None:
        raise InputError(
            f"{system.source}: component {careful!r} has contact_only, which an archive cannot hold; allowed: without it"
        )
    finer = next((name for name, c in system.components.items() if c.step is not None), None)
    if finer is not None:
        raise InputError(
            f"{system.source}: component {finer!r} has a step of its own, which an archive cannot hold; allowed: without it"
        )
    links = [
        (_copy(wiring, link.source, a), _plain(a), _copy(wiring, link.target, b), _plain(b))
        for link in wiring.links
        for a, b in zip(link.sources, link.targets)
    ]
    structure = Structure(
        system.name,
        [c for name in system.components for c in _components(wiring, name)],
        [(source, a, target, b) for source, a, target, b in links],
        stop=system.stop_time,
        step=system.communication_step,
    )
    names = [component.name for component in structure.components]
    if len(set(names)) != len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(
            f"{system.source}: the contact points of a component become components of their own, and the name {twice!r} "
            "is taken; allowed: another name for one of them"
        )
    structure.notes = {
        "name": system.name,
        "order": [copy for name in system.evaluation_order() for copy in _copies(wiring, name)],
        "synthetic": system.synthetic,
        "provenance": dict(system.provenance),
    }
    if system.record is not None:
        structure.notes["record"] = [
            f"{copy}.{text.strip().partition('.')[2]}"
            for text in system.record
            for copy in _copies(wiring, text.strip().partition(".")[0])
        ]
    if boundary:
        _open_inputs(wiring, structure)
        for item in wiring.recorded:
            for v in item.elements if item.elements[0].causality == "output" else ():
                copy = _copy(wiring, item.component, v)
                name = f"{copy}_{_plain(v)}"
                structure.connectors.append(Connector(name, "output", v.type, v.unit))
                structure.connections.append((copy, _plain(v), "", name))
    resources = {f"resources/{name}.fmu": system.fmu_path(name) for name in system.components}
    return write_ssp(path, structure, resources)


def _open_inputs(wiring: Wiring, structure: Structure) -> None:
    """Make the inputs that nothing feeds inputs of the system, with their start values."""
    from fmus.ssp.systems import Connector

    fed = {(target, given) for _, _, target, given in structure.connections}
    for name, pairs in wiring.starts.items():
        for variable, value in pairs:
            for copy in _copies(wiring, name) if variable.causality == "input" else ():
                own = f"{copy}_{_plain(variable)}"
                if (copy, _plain(variable)) not in fed:
                    structure.connectors.append(Connector(own, "input", variable.type, variable.unit))
                    structure.connections.append(("", own, copy, _plain(variable)))
                    structure.start[own] = value


def _copies(wiring: Wiring, name: str) -> list[str]:
    count = wiring.count(name)
    return [name] if count == 1 else [f"{name}_{k + 1}" for k in range(count)]


def _copy(wiring: Wiring, name: str, variable: Variable) -> str:
    """Return the component of the SSP that holds an element."""
    if wiring.count(name) == 1:
        return name
    return f"{name}_{(variable.point or variable.element) + 1}"


def _plain(variable: Variable) -> str:
    """Return the name of a variable in the FMU of one contact point."""
    return variable.base or variable.name


def _components(wiring: Wiring, name: str) -> list[Component]:
    from fmus.ssp.systems import Component, Connector

    description = wiring.descriptions[name]
    used: dict[str, dict[str, Connector]] = {copy: {} for copy in _copies(wiring, name)}

    if name in wiring.sizes and len(describe(description.path).resolve(MU.name)) > 1:
        raise InputError(
            f"{description.path}: its arrays have more than one element by default, which SSP 1.0 cannot express; "
            "allowed: an FMU for one point (`--nodes 1`), or FMI 2.0"
        )

    def use(variables: Sequence[Variable], kind: str) -> None:
        for v in variables:
            if v.element and not wiring.count(name) > 1:
                raise InputError(
                    f"{description.path}: {v.name!r} is an element of an FMI 3.0 array, which SSP 1.0 cannot express; "
                    "allowed: scalars, or FMI 2.0 with `--nodes`"
                )
            connector = Connector(_plain(v), kind, v.type, v.unit)
            used[_copy(wiring, name, v)].setdefault(connector.name, connector)

    for link in wiring.links:
        if link.target == name:
            use(link.targets, "input")
        if link.source == name:
            use(link.sources, "output")
    for item in wiring.recorded:
        if item.component == name and item.elements[0].causality == "output":
            use(item.elements, "output")
    start: dict[str, Any] = {}
    for variable, value in wiring.starts[name]:
        start[_plain(variable)] = value
        for connectors in used.values():
            kind = "input" if variable.causality == "input" else "parameter"
            connectors.setdefault(
                _plain(variable), Connector(_plain(variable), kind, variable.type, variable.unit)
            )
    return [
        Component(copy, f"resources/{name}.fmu", list(connectors.values()), dict(start))
        for copy, connectors in used.items()
    ]


def load_ssp(path: str | os.PathLike[str]) -> System:
    """Read an SSP archive as a system; its FMUs are unpacked into a temporary folder.

    Connections to the system's own connectors are left out: there is nothing outside. Inputs that nothing
    feeds keep the start value of the system's input, if it has one, else that of their FMU. The communication step comes from the annotations of this
    project, of libcosim or of OMSimulator, else from the default experiments of the FMUs.

    Raises
    ------
    InputError
        What `read_ssp` refuses, a broken FMU, or no step and stop time anywhere.
    """
    from fmus.ssp.reading import read_ssp, unpack_ssp

    from .system import System

    file = Path(path)
    structure = read_ssp(file)
    place = UnpackedSsp()
    unpack_ssp(file, place.folder)
    descriptions = {c.name: describe(place.folder / c.source) for c in structure.components}
    fed = {(end, given) for start, _, end, given in structure.connections if start}
    components = {}
    for component in structure.components:
        description = descriptions[component.name]
        start: dict[str, Any] = {
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
    system = System.from_dict(content | known, place.folder, str(file))
    system._unpacked = place
    return system


def _start(variable: Variable) -> Any:
    value = variable.starts[variable.element]
    kinds = {"Boolean": bool, "Integer": int}
    return kinds.get(variable.type, float)(value)


def _default(descriptions: Any, key: str, choose: Any) -> float | None:
    found: list[float] = []
    one: FmuDescription
    for one in descriptions:
        experiment = one.raw.defaultExperiment
        value = getattr(experiment, key, None) if experiment is not None else None
        if value is not None:
            found.append(float(value))
    return choose(found) if found else None
