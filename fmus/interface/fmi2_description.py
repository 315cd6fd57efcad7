"""modelDescription.xml of FMI 2.0, written so that fmpy's validation passes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lxml import etree

from .quantities import Variable, unit_base

GENERATION_TOOL = "tribofmu"


@dataclass(frozen=True)
class Description:
    """Content of a model description besides its variables.

    Attributes
    ----------
    model_name, identifier, guid, text : str
        Name, C identifier (also the name of the binary), GUID, one-line description.
    variables : sequence of Variable
    co_simulation, model_exchange : dict or None
        Capability flags beyond the identifier; None leaves the interface out.
    sources : sequence of str
        Files of `sources/` to be compiled.
    step : float or None
        Communication step of the default experiment [s].
    stop : float or None
        Stop time of the default experiment [s].
    annotations : mapping
        Written as attributes of a `VendorAnnotations` element of the tool `tribofmu`.
    licence : str
        One line on the licence; empty leaves it out.
    event_indicators : int
        Number of event indicators of model exchange (FMI 2.0).

    Examples
    --------
    >>> description = Description("law", "law", "{0}", "a law", [])
    >>> description.co_simulation, description.model_exchange
    ({}, None)
    """

    model_name: str
    identifier: str
    guid: str
    text: str
    variables: Sequence[Variable]
    co_simulation: Mapping[str, bool] | None = field(default_factory=dict)
    model_exchange: Mapping[str, bool] | None = None
    sources: Sequence[str] = ()
    step: float | None = None
    stop: float | None = None
    annotations: Mapping[str, str] = field(default_factory=dict)
    licence: str = ""
    event_indicators: int = 0


def number(value: float) -> str:
    """Return the shortest text that reads back to the same float64.

    Examples
    --------
    >>> number(0.1), number(2.0)
    ('0.1', '2.0')
    """
    return repr(float(value))


def to_xml(description: Description) -> bytes:
    """Return the model description as UTF-8 XML; equal input gives equal bytes (no date).

    Examples
    --------
    >>> text = to_xml(Description("law", "law", "{0}", "a law", []))
    >>> etree.fromstring(text).get("modelName")
    'law'
    """
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=description.model_name,
        guid=description.guid,
        description=description.text,
        **({"license": description.licence} if description.licence else {}),
        generationTool=GENERATION_TOOL,
        variableNamingConvention="structured",
        numberOfEventIndicators=str(description.event_indicators),
    )
    for tag, flags in (
        ("ModelExchange", description.model_exchange),
        ("CoSimulation", description.co_simulation),
    ):
        if flags is None:
            continue
        options = {name: str(value).lower() for name, value in flags.items()}
        element = etree.SubElement(root, tag, modelIdentifier=description.identifier, **options)
        if description.sources:
            files = etree.SubElement(element, "SourceFiles")
            for source in description.sources:
                etree.SubElement(files, "File", name=source)
    add_units(root, description.variables)
    categories = etree.SubElement(root, "LogCategories")
    etree.SubElement(categories, "Category", name="logStatusError", description="a call was refused")
    if description.step is not None:
        experiment = {"stepSize": number(description.step)}
        if description.stop is not None:
            experiment = {"startTime": "0.0", "stopTime": number(description.stop)} | experiment
        etree.SubElement(root, "DefaultExperiment", experiment)
    if description.annotations:
        vendor = etree.SubElement(root, "VendorAnnotations")
        tool = etree.SubElement(vendor, "Tool", name=GENERATION_TOOL)
        etree.SubElement(tool, "Model", dict(description.annotations))
    variables = etree.SubElement(root, "ModelVariables")
    index = {v.name: i + 1 for i, v in enumerate(description.variables)}
    for variable in description.variables:
        _variable(variables, variable, index)
    _structure(root, description.variables, index)
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")


def add_units(root: etree._Element, variables: Sequence[Variable]) -> None:
    """Write the units of the variables, with their SI base factors where they are known."""
    names = sorted({v.unit for v in variables if v.unit})
    if not names:
        return
    definitions = etree.SubElement(root, "UnitDefinitions")
    for name in names:
        unit = etree.SubElement(definitions, "Unit", name=name)
        base = unit_base(name)
        if base is not None:
            attributes = {k: number(v) if k in {"factor", "offset"} else str(int(v)) for k, v in base.items()}
            etree.SubElement(unit, "BaseUnit", attributes)


def _variable(parent: etree._Element, variable: Variable, index: Mapping[str, int]) -> None:
    attributes = {"name": variable.name, "valueReference": str(variable.reference)}
    if variable.description:
        attributes["description"] = variable.description
    attributes |= {"causality": variable.causality, "variability": variable.variability}
    if variable.initial:
        attributes["initial"] = variable.initial
    element = etree.SubElement(parent, "ScalarVariable", attributes)
    details: dict[str, str] = {}
    if variable.unit:
        details["unit"] = variable.unit
    if variable.derivative:
        details["derivative"] = str(index[variable.derivative])
    if variable.nominal is not None:
        details["nominal"] = number(variable.nominal)
    if variable.lower is not None:
        details["min"] = number(variable.lower)
    if variable.upper is not None:
        details["max"] = number(variable.upper)
    if variable.start is not None:
        start = variable.start
        if variable.type == "Boolean":
            details["start"] = str(bool(start)).lower()
        elif variable.type == "Integer":
            details["start"] = str(int(start))
        else:
            details["start"] = number(float(start))
    etree.SubElement(element, variable.type, details)


def _structure(root: etree._Element, variables: Sequence[Variable], index: Mapping[str, int]) -> None:
    structure = etree.SubElement(root, "ModelStructure")
    outputs = [v for v in variables if v.causality == "output"]
    rates = [v for v in variables if v.derivative]

    def listed(tag: str, unknowns: Sequence[Variable], initial: bool = False) -> None:
        if not unknowns:
            return
        parent = etree.SubElement(structure, tag)
        for v in sorted(unknowns, key=lambda v: index[v.name]):
            attributes = {"index": str(index[v.name])}
            depends = v.initial_depends if initial and v.initial_depends is not None else v.depends
            if depends is not None:
                attributes["dependencies"] = " ".join(str(i) for i in sorted(index[d] for d in depends))
            etree.SubElement(parent, "Unknown", attributes)

    listed("Outputs", outputs)
    listed("Derivatives", rates)
    listed("InitialUnknowns", [v for v in (*outputs, *rates) if v.initial in {"calculated", "approx"}], True)


def c_identifier(text: str) -> str:
    """Return `text` as a C identifier.

    Examples
    --------
    >>> c_identifier("2 laws: mu(T)")
    'm_2_laws_mu_t'
    """
    clean = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "model"
    return clean if clean[0].isalpha() else f"m_{clean}"
