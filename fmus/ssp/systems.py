"""SSP 1.0: a system of FMUs with its connections and start values in one archive, as many simulators load it.

The archive holds `SystemStructure.ssd` and ``resources/*.fmu``; replacing one resource swaps a component.
SSP says nothing about the master algorithm. The communication step therefore stands in annotations, as
libcosim (``com.opensimulationplatform``) and OMSimulator (``org.openmodelica``) write them, and what only
this project knows (order, what to record, whether data is synthetic) in one of its own, which others skip.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lxml import etree

from friction_models.common import InputError

from ..archive.content import check_content, read_description, write_archive

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
OWN = "urn:tribofmu:ssp:1"
#: Types of our annotations.
OWN_TYPE, OSP_TYPE, OMS_TYPE = "tribofmu", "com.opensimulationplatform", "org.openmodelica"

DESCRIPTION = "SystemStructure.ssd"
TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
Value = bool | int | float | str


@dataclass(frozen=True)
class Connector:
    """A variable of a component, or of the whole system, that connections or values refer to.

    Attributes
    ----------
    name : str
        Of the FMU's variable, ``v_rel[3]`` included.
    kind : {"input", "output", "parameter"}
    type : str
        One of `TYPES`.
    unit : str
        Empty without one.
    """

    name: str
    kind: str
    type: str = "Real"
    unit: str = ""


@dataclass
class Component:
    """An FMU of the system.

    Attributes
    ----------
    name : str
    source : str
        Path in the archive, ``resources/friction.fmu``; components may share it.
    connectors : list of Connector
    start : dict of str to value
        Start values by variable.
    """

    name: str
    source: str
    connectors: list[Connector] = field(default_factory=list)
    start: dict[str, Value] = field(default_factory=dict)


@dataclass
class Structure:
    """What `SystemStructure.ssd` says.

    Attributes
    ----------
    name : str
    components : list of Component
    connections : list of tuple
        Start component, start variable, end component, end variable; "" as component is the system itself.
    connectors : list of Connector
        Of the system.
    start : dict of str to value
        Start values of the system, by the name of its connector or by ``component.variable``.
    stop, step : float or None
        End of the default experiment and communication step [s].
    notes : dict
        What this project keeps beside it; plain JSON.
    """

    name: str
    components: list[Component] = field(default_factory=list)
    connections: list[tuple[str, str, str, str]] = field(default_factory=list)
    connectors: list[Connector] = field(default_factory=list)
    start: dict[str, Value] = field(default_factory=dict)
    stop: float | None = None
    step: float | None = None
    notes: dict[str, Any] = field(default_factory=dict)


def write_ssp(
    path: str | os.PathLike[str],
    structure: Structure,
    resources: Mapping[str, str | os.PathLike[str]],
) -> Path:
    """Write an SSP 1.0 archive. Equal content gives equal bytes.

    Parameters
    ----------
    path : path-like
        The archive (``.ssp``).
    structure : Structure
        The system.
    resources : mapping of str to path-like
        FMU files by their path in the archive.

    Raises
    ------
    InputError
        Another suffix, a component without a resource, or an FMU that cannot be read.
    """
    if Path(path).suffix != ".ssp":
        raise InputError(f"{path}: suffix {Path(path).suffix!r}, allowed: '.ssp'")
    for component in structure.components:
        if component.source not in resources:
            raise InputError(
                f"{path}: component {component.name!r} refers to {component.source!r}, which is not among the resources"
            )
    from .writing import to_ssd

    units = _units(structure, resources)
    for file in resources.values():
        check_content(file)
    files = {name: Path(file).read_bytes() for name, file in resources.items()}
    return write_archive(path, files | {DESCRIPTION: to_ssd(structure, units)})


def pack_ssp(model: object, path: str | os.PathLike[str], boundary: bool = False, **options: Any) -> Path:
    """Write a friction model as an SSP of one component.

    Parameters
    ----------
    model : FrictionModel, path-like
        What `pack` takes.
    path : path-like
        The archive (``.ssp``).
    boundary : bool
        Make loads, with their start values, and outputs those of the system, too. Tools that turn an SSP into one FMU need that;
        libcosim and ecos refuse connections to the system itself.
    **options
        Of `pack`: `target`, `nodes`, `fmi`, `platforms`.

    Raises
    ------
    InputError
        What `pack` and `write_ssp` refuse.
    """
    import tempfile

    from ..targets.packing import pack

    if Path(path).suffix != ".ssp":
        raise InputError(f"{path}: suffix {Path(path).suffix!r}, allowed: '.ssp'")
    with tempfile.TemporaryDirectory(prefix="tribofmu-") as folder:
        fmu = pack(model, Path(folder) / "friction.fmu", **options)
        return write_ssp(path, single(fmu, boundary=boundary), {"resources/friction.fmu": fmu})


def single(fmu: str | os.PathLike[str], name: str = "friction", boundary: bool = False) -> Structure:
    """Return the structure of a system that is this FMU alone; with `boundary` its variables are the system's."""
    root = read_description(fmu)
    variables, starts = scalars(root)
    inputs, outputs = [], []
    for variable in variables:
        if variable.kind == "input":
            inputs.append(variable)
        elif variable.kind == "output":
            outputs.append(variable)
    experiment = root.find("DefaultExperiment")
    given = {} if experiment is None else dict(experiment.attrib)
    links = [("", c.name, name, c.name) for c in inputs] + [(name, c.name, "", c.name) for c in outputs]
    return Structure(
        name,
        [Component(name, f"resources/{name}.fmu", [*inputs, *outputs])],
        links if boundary else [],
        [*inputs, *outputs] if boundary else [],
        {c.name: starts[c.name] for c in inputs if c.name in starts} if boundary else {},
        stop=float(given.get("stopTime", 1.0)),
        step=float(given.get("stepSize", 0.01)),
    )


def scalars(root: etree._Element) -> tuple[list[Connector], dict[str, Value]]:
    """Return the inputs, outputs and parameters of a model description (FMI 2.0 or 3.0) as connectors.

    With them the start values of those that are Real. An FMI 3.0 array counts as a scalar: SSP 1.0 has no arrays, and ours have one element by default.
    """
    declared = {t.get("name"): t for t in root.iter("SimpleType")}
    declared |= {t.get("name"): t for t in root.iterfind("TypeDefinitions/*") if t.tag.endswith("Type")}
    found: list[Connector] = []
    starts: dict[str, Value] = {}
    for variable in root.iterfind("ModelVariables/*"):
        kind = variable.get("causality")
        if kind not in {"input", "output", "parameter"}:
            continue
        typed = variable if variable.tag != "ScalarVariable" else next(iter(variable))
        name = str(typed.tag)
        kinds = {"Float64": "Real", "Float32": "Real"}
        name = kinds.get(name, "Integer" if "Int" in name else name)
        if name not in TYPES:
            continue
        definition = declared.get(typed.get("declaredType"))
        units = [typed.get("unit")]
        if definition is not None:
            units += [definition.get("unit"), *(e.get("unit") for e in definition)]
        unit = next((u for u in units if u), "")
        found.append(Connector(str(variable.get("name")), kind, name, unit))
        if name == "Real" and typed.get("start"):
            starts[found[-1].name] = float(str(typed.get("start")).split()[0])
    return found, starts


def _units(
    structure: Structure, resources: Mapping[str, str | os.PathLike[str]]
) -> dict[str, dict[str, str]]:
    """Return the base units of all units that connectors have, as the FMUs define them."""
    connectors = [*structure.connectors, *(c for part in structure.components for c in part.connectors)]
    needed = {c.unit for c in connectors} - {""}
    defined: dict[str, dict[str, str]] = {}
    for name in sorted(resources):
        for unit in read_description(resources[name]).iterfind("UnitDefinitions/Unit"):
            base = unit.find("BaseUnit")
            defined.setdefault(str(unit.get("name")), {} if base is None else dict(base.attrib))
    return {name: defined.get(name, {}) for name in sorted(needed)}
