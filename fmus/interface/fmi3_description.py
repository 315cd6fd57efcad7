"""modelDescription.xml and buildDescription.xml of FMI 3.0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lxml import etree

from .fmi2_description import GENERATION_TOOL, Description, add_units, number
from .quantities import Variable

#: Type of the annotation that carries the model's family and trained domain.
ANNOTATION = "org.tribofmu.model"


def to_xml3(description: Description, nodes: int = 1) -> bytes:
    """Return the model description of FMI 3.0 as UTF-8 XML; equal input gives equal bytes (no date).

    Parameters
    ----------
    description : Description
        Its `guid` is the instantiation token.
    nodes : int
        Number of start values of an array: the start value of the structural parameter.
    """
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=description.model_name,
        instantiationToken=description.guid,
        description=description.text,
        **({"license": description.licence} if description.licence else {}),
        generationTool=GENERATION_TOOL,
        variableNamingConvention="structured",
    )
    for tag, flags in (
        ("ModelExchange", description.model_exchange),
        ("CoSimulation", description.co_simulation),
    ):
        if flags is not None:
            options = {name: str(value).lower() for name, value in flags.items()}
            etree.SubElement(root, tag, modelIdentifier=description.identifier, **options)
    add_units(root, description.variables)
    categories = etree.SubElement(root, "LogCategories")
    etree.SubElement(categories, "Category", name="logStatusError", description="a call was refused")
    if description.step is not None:
        experiment = {"startTime": "0.0", "stepSize": number(description.step)}
        if description.stop is not None:
            experiment["stopTime"] = number(description.stop)
        etree.SubElement(root, "DefaultExperiment", experiment)
    references = {v.name: v.reference for v in description.variables}
    size = next((v.reference for v in description.variables if v.causality == "structuralParameter"), None)
    variables = etree.SubElement(root, "ModelVariables")
    for variable in description.variables:
        _variable(variables, variable, references, size, nodes)
    _structure(root, description, references)
    if description.annotations:
        annotations = etree.SubElement(root, "Annotations")
        annotation = etree.SubElement(annotations, "Annotation", type=ANNOTATION)
        etree.SubElement(annotation, "Model", dict(description.annotations))
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")


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
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")


def _variable(
    parent: etree._Element,
    variable: Variable,
    references: Mapping[str, int],
    size: int | None,
    nodes: int,
) -> None:
    kind = {"Real": "Float64"}.get(variable.type, variable.type)
    attributes = {"name": variable.name, "valueReference": str(variable.reference)}
    if variable.description:
        attributes["description"] = variable.description
    attributes |= {"causality": variable.causality, "variability": variable.variability}
    if variable.initial and variable.causality not in {"parameter", "structuralParameter"}:
        attributes["initial"] = variable.initial

    def text(value: float | bool | int) -> str:
        if kind == "Boolean":
            return str(bool(value)).lower()
        return number(float(value)) if kind == "Float64" else str(int(value))

    if variable.derivative:
        attributes["derivative"] = str(references[variable.derivative])
    if variable.unit:
        attributes["unit"] = variable.unit
    for name, limit in (("nominal", variable.nominal), ("min", variable.lower), ("max", variable.upper)):
        if limit is not None:
            attributes[name] = text(limit)
    if variable.start is not None:
        attributes["start"] = " ".join([text(variable.start)] * (nodes if variable.array else 1))
    element = etree.SubElement(parent, kind, attributes)
    if variable.array and size is not None:
        etree.SubElement(element, "Dimension", valueReference=str(size))


def _structure(root: etree._Element, description: Description, references: Mapping[str, int]) -> None:
    structure = etree.SubElement(root, "ModelStructure")
    outputs = [v for v in description.variables if v.causality == "output"]
    rates = [v for v in description.variables if v.derivative]
    indicators = [v for v in description.variables if v.name == "domain_indicator"]

    def listed(tag: str, unknowns: Sequence[Variable], initial: bool = False) -> None:
        for v in unknowns:
            attributes = {"valueReference": str(v.reference)}
            depends = v.initial_depends if initial and v.initial_depends is not None else v.depends
            if depends is not None:
                attributes["dependencies"] = " ".join(str(references[d]) for d in depends)
            etree.SubElement(structure, tag, attributes)

    listed("Output", outputs)
    listed("ContinuousStateDerivative", rates)
    listed("InitialUnknown", [v for v in (*outputs, *rates) if v.initial == "calculated"], True)
    if description.model_exchange is not None:
        listed("EventIndicator", indicators)
