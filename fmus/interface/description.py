"""modelDescription.xml of FMI 2.0 and 3.0, written so that fmpy's validation passes, and buildDescription.xml."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lxml import etree

from ..archive.content import xml_bytes
from .quantities import DeclaredVariable, unit_base

GENERATION_TOOL = "tribofmu"
#: Type of the annotation of FMI 3.0 that carries the model's family and trained domain.
ANNOTATION = "org.tribofmu.model"


@dataclass(frozen=True)
class Description:
    """Content of a model description."""

    model_name: str
    identifier: str  #: C identifier, also the name of the binary.
    guid: str  #: GUID or (FMI 3.0) instantiation token.
    text: str  #: One line that describes the model.
    variables: Sequence[DeclaredVariable]
    #: Capability flags beyond the identifier; None leaves the interface out.
    co_simulation: Mapping[str, bool] | None = field(default_factory=dict)
    model_exchange: Mapping[str, bool] | None = None
    sources: Sequence[str] = ()  #: Files of `sources/` to be compiled.
    step: float | None = None  #: Communication step of the default experiment [s].
    stop: float | None = None  #: Stop time of the default experiment [s].
    #: Written as attributes of a `VendorAnnotations` element of the tool `tribofmu`.
    annotations: Mapping[str, str] = field(default_factory=dict)
    licence: str = ""  #: One line on the licence; empty leaves it out.
    event_indicators: int = 0  #: Number of event indicators of model exchange (FMI 2.0).
    warns: bool = False  #: Whether warnings are logged, too.


def number(value: float) -> str:
    """Return the shortest text that reads back to the same float64.

    Examples
    --------
    >>> number(0.1), number(2.0)
    ('0.1', '2.0')
    """
    return repr(float(value))


def to_xml(description: Description, fmi: str = "2.0", nodes: int = 1) -> bytes:
    """Return the model description as UTF-8 XML; equal input gives equal bytes (no date).

    `nodes` is the number of start values of an array of FMI 3.0: the start value of the structural parameter.

    Examples
    --------
    >>> text = to_xml(Description("law", "law", "{0}", "a law", []))
    >>> etree.fromstring(text).get("modelName")
    'law'
    """
    three = fmi == "3.0"
    root = etree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": fmi,
            "modelName": description.model_name,
            "instantiationToken" if three else "guid": description.guid,
            "description": description.text,
            **({"license": description.licence} if description.licence else {}),
            "generationTool": GENERATION_TOOL,
            "variableNamingConvention": "structured",
        },
    )
    if not three:
        root.set("numberOfEventIndicators", str(description.event_indicators))
    for tag, flags in (
        ("ModelExchange", description.model_exchange),
        ("CoSimulation", description.co_simulation),
    ):
        if flags is None:
            continue
        options = {name: str(value).lower() for name, value in flags.items()}
        element = etree.SubElement(root, tag, modelIdentifier=description.identifier, **options)
        if description.sources and not three:
            files = etree.SubElement(element, "SourceFiles")
            for source in description.sources:
                etree.SubElement(files, "File", name=source)
    _units(root, description.variables)
    categories = etree.SubElement(root, "LogCategories")
    etree.SubElement(categories, "Category", name="logStatusError", description="a call was refused")
    if description.warns:
        etree.SubElement(
            categories, "Category", name="logStatusWarning", description="to know of a run that ended"
        )
    if description.step is not None:
        etree.SubElement(root, "DefaultExperiment", _experiment(description.step, description.stop, three))
    if description.annotations and not three:
        vendor = etree.SubElement(root, "VendorAnnotations")
        tool = etree.SubElement(vendor, "Tool", name=GENERATION_TOOL)
        etree.SubElement(tool, "Model", dict(description.annotations))
    variables = etree.SubElement(root, "ModelVariables")
    # The standards refer to a variable by its place in the file and by its value reference.
    numbers = {v.name: v.reference if three else i + 1 for i, v in enumerate(description.variables)}
    size = next((v.reference for v in description.variables if v.causality == "structuralParameter"), None)
    for variable in description.variables:
        element = _variable(variables, variable, numbers, three, nodes)
        if variable.array and size is not None:
            etree.SubElement(element, "Dimension", valueReference=str(size))
        for length in variable.shape:
            etree.SubElement(element, "Dimension", start=str(length))
    _structure(root, description, numbers, three)
    if description.annotations and three:
        annotations = etree.SubElement(root, "Annotations")
        annotation = etree.SubElement(annotations, "Annotation", type=ANNOTATION)
        etree.SubElement(annotation, "Model", dict(description.annotations))
    return xml_bytes(root)


def _experiment(step: float, stop: float | None, three: bool) -> dict[str, str]:
    size, end = {"stepSize": number(step)}, {} if stop is None else {"stopTime": number(stop)}
    if three:
        return {"startTime": "0.0"} | size | end
    return {"startTime": "0.0"} | end | size if end else size


def _units(root: etree._Element, variables: Sequence[DeclaredVariable]) -> None:
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


def _variable(
    parent: etree._Element, variable: DeclaredVariable, numbers: Mapping[str, int], three: bool, nodes: int
) -> etree._Element:
    kind = {"Real": "Float64"}.get(variable.type, variable.type) if three else variable.type
    attributes = {"name": variable.name, "valueReference": str(variable.reference)}
    if variable.description:
        attributes["description"] = variable.description
    attributes |= {"causality": variable.causality, "variability": variable.variability}
    if variable.initial and not (three and variable.causality in {"parameter", "structuralParameter"}):
        attributes["initial"] = variable.initial

    def text(value: float) -> str:
        if variable.type == "Boolean":
            return str(bool(value)).lower()
        return number(value) if variable.type == "Real" else str(int(value))

    unit = {"unit": variable.unit} if variable.unit else {}
    derivative = {"derivative": str(numbers[variable.derivative])} if variable.derivative else {}
    details = derivative | unit if three else unit | derivative
    for name, limit in (("nominal", variable.nominal), ("min", variable.lower), ("max", variable.upper)):
        if limit is not None:
            details[name] = text(limit)
    if variable.shape:
        details["start"] = " ".join(map(text, variable.starts))
    elif variable.start is not None:
        details["start"] = " ".join([text(variable.start)] * (nodes if variable.array else 1))
    if three:
        return etree.SubElement(parent, kind, attributes | details)
    return etree.SubElement(etree.SubElement(parent, "ScalarVariable", attributes), kind, details)


def _structure(
    root: etree._Element, description: Description, numbers: Mapping[str, int], three: bool
) -> None:
    structure = etree.SubElement(root, "ModelStructure")
    outputs = [v for v in description.variables if v.causality == "output"]
    rates = [v for v in description.variables if v.derivative]
    indicators = [v for v in description.variables if v.name == "domain_indicator"]

    def listed(tag: str, unknowns: Sequence[DeclaredVariable], initial: bool = False) -> None:
        if not unknowns:
            return
        parent = structure if three else etree.SubElement(structure, f"{tag}s")
        for v in unknowns:
            attributes = {"valueReference" if three else "index": str(numbers[v.name])}
            depends = v.initial_depends if initial and v.initial_depends is not None else v.depends
            if depends is not None:
                known = [numbers[d] for d in depends]
                attributes["dependencies"] = " ".join(map(str, known if three else sorted(known)))
            etree.SubElement(parent, tag if three else "Unknown", attributes)

    calculated = [v for v in (*outputs, *rates) if v.initial == "calculated"]
    listed("Output", outputs)
    listed("ContinuousStateDerivative" if three else "Derivative", rates)
    listed("InitialUnknown", calculated if three else sorted(calculated, key=lambda v: numbers[v.name]), True)
    if description.model_exchange is not None and three:
        listed("EventIndicator", indicators)


def build_description(identifier: str, main: str) -> bytes:
    """Return sources/buildDescription.xml: one C99 file to compile, nothing to define."""
    root = etree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = etree.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = etree.SubElement(configuration, "SourceFileSet", language="C99")
    etree.SubElement(files, "SourceFile", name=main)
    etree.SubElement(
        configuration,
        "Library",
        name="m",
        external="true",
        description="the mathematical library, where it is one of its own",
    )
    return xml_bytes(root)


def c_identifier(text: str) -> str:
    """Return `text` as a C identifier.

    Examples
    --------
    >>> c_identifier("2 laws: mu(T)")
    'm_2_laws_mu_t'
    """
    clean = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "model"
    return clean if clean[0].isalpha() else f"m_{clean}"
