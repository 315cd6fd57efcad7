"""Writes SSP archives: `SystemStructure.ssd` and the FMUs beside it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from lxml import etree

from friction_models.common import InputError

from ..archive.content import check_content, read_description, write_archive, xml_bytes
from .systems import (
    DESCRIPTION,
    OMS_TYPE,
    OSP_TYPE,
    OWN_TYPE,
    SPACES,
    Connector,
    SspComponent,
    Structure,
    Value,
)
from .traceability import traceability_files


def write_ssp(
    path: str | os.PathLike[str],
    structure: Structure,
    resources: Mapping[str, str | os.PathLike[str]],
) -> Path:
    """Write an SSP 1.0 archive, with metadata of where it comes from. Equal content gives equal bytes.

    `resources` are FMU files by their path in the archive.
    Raises InputError: another suffix, a component without a resource, or an FMU that cannot be read.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from fmus.ssp.reading import read_ssp
    >>> from friction_models import ConstantFriction
    >>> system = Structure("law", [SspComponent("friction", "resources/friction.fmu")], stop=1.0, step=0.01)
    >>> with TemporaryDirectory() as place:
    ...     fmu = pack(ConstantFriction(mu=0.1), Path(place) / "friction.fmu", target="python")
    ...     archive = write_ssp(Path(place) / "law.ssp", system, {"resources/friction.fmu": fmu})
    ...     read = read_ssp(archive)
    >>> read.name, read.stop, read.step
    ('law', 1.0, 0.01)
    """
    if Path(path).suffix != ".ssp":
        raise InputError(f"{path}: suffix {Path(path).suffix!r}, allowed: '.ssp'")
    for component in structure.components:
        if component.source not in resources:
            raise InputError(
                f"{path}: component {component.name!r} refers to {component.source!r}, which is not among the resources"
            )
    descriptions = {name: read_description(file) for name, file in resources.items()}
    units = _units(structure, descriptions)
    for file in resources.values():
        check_content(file)
    files = {name: Path(file).read_bytes() for name, file in resources.items()}
    files[DESCRIPTION] = to_ssd(structure, units)
    return write_archive(path, files | traceability_files(structure, files, descriptions))


def _units(structure: Structure, descriptions: Mapping[str, etree._Element]) -> dict[str, dict[str, str]]:
    """Return the base units of all units that connectors have, as the FMUs define them."""
    connectors = [*structure.connectors, *(c for part in structure.components for c in part.connectors)]
    needed = {c.unit for c in connectors} - {""}
    defined: dict[str, dict[str, str]] = {}
    for name in sorted(descriptions):
        for unit in descriptions[name].iterfind("UnitDefinitions/Unit"):
            base = unit.find("BaseUnit")
            defined.setdefault(str(unit.get("name")), {} if base is None else dict(base.attrib))
    return {name: defined.get(name, {}) for name in sorted(needed)}


def to_ssd(structure: Structure, units: Mapping[str, Mapping[str, str]]) -> bytes:
    """Return the text of `SystemStructure.ssd`.

    Examples
    --------
    >>> text = to_ssd(Structure("law", [SspComponent("friction", "resources/friction.fmu")]), units={})
    >>> b'source="resources/friction.fmu"' in text
    True
    """
    root = etree.Element(_name("ssd:SystemStructureDescription"), nsmap=SPACES)
    root.set("version", "1.0")
    root.set("name", structure.name)
    root.set("generationTool", "tribofmu")
    system = _sub(root, "ssd:System", name=structure.name)
    _connectors(system, structure.connectors)
    _bindings(system, structure.start, structure)
    elements = _sub(system, "ssd:Elements")
    for component in structure.components:
        element = _sub(
            elements,
            "ssd:Component",
            name=component.name,
            type="application/x-fmu-sharedlibrary",
            source=component.source,
            implementation="CoSimulation",
        )
        _connectors(element, component.connectors)
        _bindings(element, component.start, component)
    if structure.connections:
        connections = _sub(system, "ssd:Connections")
        for start, output, end, given in structure.connections:
            link = _sub(connections, "ssd:Connection")
            for key, value in zip(
                ("startElement", "startConnector", "endElement", "endConnector"), (start, output, end, given)
            ):
                if value:
                    link.set(key, str(value))
    notes = _sub(system, "ssd:Annotations")
    if structure.step:  # first: OMSimulator takes the first annotation for its own
        oms = _sub(_sub(notes, "ssc:Annotation", type=OMS_TYPE), "oms:Annotations")
        master = _sub(_sub(oms, "oms:SimulationInformation"), "oms:FixedStepMaster", description="oms-ma")
        master.set("stepSize", repr(float(structure.step)))
        master.set("absoluteTolerance", "0.0001")
        master.set("relativeTolerance", "0.0001")
    own = _sub(notes, "ssc:Annotation", type=OWN_TYPE)
    _sub(own, "tribofmu:Notes").text = json.dumps(
        structure.notes | ({"communication_step": structure.step} if structure.step else {}), sort_keys=True
    )
    if units:
        parent = _sub(root, "ssd:Units")
        for name, base in units.items():
            _sub(_sub(parent, "ssc:Unit", name=name), "ssc:BaseUnit", **base)
    experiment = _sub(root, "ssd:DefaultExperiment", startTime="0.0")
    if structure.stop is not None:
        experiment.set("stopTime", repr(float(structure.stop)))
    if structure.step:
        note = _sub(_sub(experiment, "ssd:Annotations"), "ssc:Annotation", type=OSP_TYPE)
        algorithm = _sub(note, "osp:Algorithm")
        _sub(algorithm, "osp:FixedStepAlgorithm", baseStepSize=repr(float(structure.step)))
    return xml_bytes(root)


def _name(tag: str) -> str:
    """Return a tag with a prefix of `SPACES` as lxml takes it."""
    prefix, _, name = tag.partition(":")
    return f"{{{SPACES[prefix]}}}{name}"


def _sub(parent: etree._Element, tag: str, **attributes: str) -> etree._Element:
    return etree.SubElement(parent, _name(tag), attributes)


def _connectors(parent: etree._Element, connectors: Sequence[Connector]) -> None:
    if not connectors:
        return
    place = _sub(parent, "ssd:Connectors")
    for connector in connectors:
        typed = _sub(
            _sub(place, "ssd:Connector", name=connector.name, kind=connector.kind), f"ssc:{connector.type}"
        )
        if connector.type == "Real" and connector.unit:
            typed.set("unit", connector.unit)
        if connector.type == "Enumeration":
            typed.set("name", connector.name)


def _bindings(parent: etree._Element, start: Mapping[str, Value], owner: Structure | SspComponent) -> None:
    if not start:
        return
    types = {c.name: c.type for c in owner.connectors}
    binding = _sub(_sub(parent, "ssd:ParameterBindings"), "ssd:ParameterBinding")
    place = _sub(_sub(binding, "ssd:ParameterValues"), "ssv:ParameterSet", version="1.0", name="start")
    place = _sub(place, "ssv:Parameters")
    for name, value in start.items():
        kind = types.get(name) or _kind(value)
        text = str(value).lower() if isinstance(value, bool) else str(value)
        if kind == "Real":
            text = repr(float(value))
        _sub(_sub(place, "ssv:Parameter", name=name), f"ssv:{kind}", value=text)


def _kind(value: Value) -> str:
    if isinstance(value, bool):
        return "Boolean"
    return {int: "Integer", float: "Real"}.get(type(value), "String")
