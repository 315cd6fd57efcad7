"""Systems as SSP 1.0 archives that other simulators load."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from fmus.runtime.fmu_files import describe
from fmus.runtime.fmu_variables import Variable
from fmus.ssp.systems import Connector, SspComponent, Structure, Value
from fmus.ssp.writing import write_ssp
from friction_models.common import InputError
from friction_models.loads import MU

from .setup.description import SystemDescription
from .setup.wiring import Wiring


def export_ssp(system: SystemDescription, path: str | os.PathLike[str], boundary: bool = False) -> Path:
    """Write a system as an SSP 1.0 archive that other simulators load.

    A scalar friction FMU that runs once a contact point becomes one component a point (``friction_1`` ...),
    and so does a friction FMU of FMI 3.0, as SSP 1.0 has no arrays; all of them refer to one resource.

    With `boundary` what the run records become outputs of the system (``forming_force``), and what has a start value and
    no connection becomes an input of it (``friction_T``), which starts there, too. Tools that turn an SSP into one FMU
    need that; libcosim and ecos refuse connections to the system itself.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from fmus.ssp.reading import read_ssp
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     law = pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python")
    ...     system = SystemDescription.from_dict({
    ...         "communication_step": 0.1, "stop_time": 1.0, "components": {"friction": {"fmu": str(law)}},
    ...     })
    ...     structure = read_ssp(export_ssp(system, Path(place) / "system.ssp"))
    >>> [component.name for component in structure.components], structure.step
    (['friction'], 0.1)
    """
    wiring = Wiring.of(system)
    scaled = next((link for link in wiring.links if (link.factor, link.offset) != (1.0, 0.0)), None)
    if scaled is not None:
        raise InputError(
            f"{system.source}: a connection to {scaled.target}.{scaled.targets[0].name} converts units, which an archive "
            "cannot hold; allowed: FMUs that share the units of what they exchange"
        )
    careful = [name for name, c in system.components.items() if c.contact_only]
    finer = [name for name, c in system.components.items() if c.step is not None]
    for found, what in ((careful, "contact_only"), (finer, "a step of its own")):
        if found:
            raise InputError(
                f"{system.source}: component {found[0]!r} has {what}, which an archive cannot hold; allowed: without it"
            )
    links = [
        (_copy(wiring, link.source, a), a.own, _copy(wiring, link.target, b), b.own)
        for link in wiring.links
        for a, b in zip(link.sources, link.targets)
    ]
    structure = Structure(
        system.name,
        [c for name in system.components for c in _components(wiring, name)],
        links,
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
                name = f"{copy}_{v.own}"
                structure.connectors.append(Connector(name, "output", v.type, v.unit))
                structure.connections.append((copy, v.own, "", name))
    resources = {f"resources/{name}.fmu": system.fmu_path(name) for name in system.components}
    return write_ssp(path, structure, resources)


def _open_inputs(wiring: Wiring, structure: Structure) -> None:
    """Make the inputs that nothing feeds inputs of the system, with their start values."""
    fed = {(target, given) for _, _, target, given in structure.connections}
    for name, pairs in wiring.starts.items():
        for variable, value in pairs:
            for copy in _copies(wiring, name) if variable.causality == "input" else ():
                own = f"{copy}_{variable.own}"
                if (copy, variable.own) not in fed:
                    structure.connectors.append(Connector(own, "input", variable.type, variable.unit))
                    structure.connections.append(("", own, copy, variable.own))
                    structure.start[own] = value


def _copies(wiring: Wiring, name: str) -> list[str]:
    count = wiring.count(name)
    return [name] if count == 1 else [f"{name}_{k + 1}" for k in range(count)]


def _copy(wiring: Wiring, name: str, variable: Variable) -> str:
    """Return the component of the SSP that holds an element."""
    if wiring.count(name) == 1:
        return name
    return f"{name}_{(variable.point or variable.element) + 1}"


def _components(wiring: Wiring, name: str) -> list[SspComponent]:
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
            connector = Connector(v.own, kind, v.type, v.unit)
            used[_copy(wiring, name, v)].setdefault(connector.name, connector)

    for link in wiring.links:
        if link.target == name:
            use(link.targets, "input")
        if link.source == name:
            use(link.sources, "output")
    for item in wiring.recorded:
        if item.component == name and item.elements[0].causality == "output":
            use(item.elements, "output")
    start: dict[str, Value] = {}
    for variable, value in wiring.starts[name]:
        start[variable.own] = value
        for connectors in used.values():
            kind = "input" if variable.causality == "input" else "parameter"
            connectors.setdefault(variable.own, Connector(variable.own, kind, variable.type, variable.unit))
    return [
        SspComponent(copy, f"resources/{name}.fmu", list(connectors.values()), dict(start))
        for copy, connectors in used.items()
    ]
