"""A friction map after the layered standard FMI-LS-STRUCT: its names, its terminal, its manifest.

Version 1.0.0-rc.1, a release candidate. The map is sampled on a rectilinear grid: for each axis a vector of sampling points,
the values of mu as one array with a dimension for each axis. The terminal says which variables these are.
"""

from __future__ import annotations

from collections.abc import Sequence

from lxml import etree

from friction_models.loads import LOAD_NAMES, MU

from ..archive.content import xml_bytes
from .quantities import AXIS, Parameter, parameter_arrays

NAME = "org.fmi-standard.fmi-ls-struct"
VERSION = "1.0.0-rc.1"
#: The one text that the schema of the manifest allows.
DESCRIPTION = "Layered standard for structuring of variables"
MANIFEST = f"extra/{NAME}/fmi-ls-manifest.xml"
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
#: What a terminal and its members are.
KIND, RULE = f"{NAME}.map.rectilinearGrid", f"{NAME}.map"
MEMBER = f"{NAME}.map."
#: Name of the terminal and of the array of values.
VALUES = "mu_map"


def axis_name(load: str) -> str:
    """Return the name of the vector of sampling points of a load.

    Examples
    --------
    >>> axis_name("T")
    'T_axis'
    """
    return f"{load}{AXIS}"


def map_axes(system: Sequence[Parameter]) -> list[str]:
    """Return the loads that a friction map goes over, in the order of its dimensions; empty for another model.

    Examples
    --------
    >>> names = ["T_axis[1]", "T_axis[2]", "mu_map[1]", "mu_map[2]"]
    >>> map_axes([Parameter(n, "1", 0.0) for n in names]), map_axes([Parameter("Ra", "um", 0.2)])
    (['T'], [])
    """
    arrays = parameter_arrays(system)
    if not arrays or arrays[-1].name != VALUES:
        return []
    axes = [a.name.removesuffix(AXIS) for a in arrays[:-1] if a.rises]
    lengths = tuple(n for a in arrays[:-1] for n in a.shape)
    fits = len(axes) == len(arrays) - 1 and lengths == arrays[-1].shape and set(axes) <= set(LOAD_NAMES)
    return axes if fits else []


def manifest_root(tag: str, name: str, version: str, description: str) -> etree._Element:
    """Return the manifest that tells an importer that the FMU keeps to a layered standard."""
    told = {"name": name, "version": version, "description": description}
    attributes = {f"{{{NAMESPACE}}}fmi-ls-{key}": value for key, value in told.items()}
    return etree.Element(tag, attributes, nsmap={"fmi-ls": NAMESPACE})


def manifest() -> bytes:
    """Return the manifest of the layered standard for maps."""
    return xml_bytes(manifest_root("fmiLayeredStandardManifest", NAME, VERSION, DESCRIPTION))


def with_map_terminal(terminals: bytes, axes: Sequence[str]) -> bytes:
    """Return a description of terminals with that of the map, each axis followed by the load that is looked up on it.

    Examples
    --------
    >>> text = with_map_terminal(b"<fmiTerminalsAndIcons><Terminals/></fmiTerminalsAndIcons>", ["T"])
    >>> [(m.get("variableName"), m.get("variableKind")[35:]) for m in etree.fromstring(text).iter("TerminalMemberVariable")]
    [('T_axis', 'domain'), ('T', 'domainInput'), ('mu_map', 'codomain'), ('mu', 'codomainOutput')]
    """
    root = etree.fromstring(terminals, etree.XMLParser(remove_blank_text=True, resolve_entities=False))
    place = root.find("Terminals")
    assert place is not None
    terminal = etree.SubElement(
        place,
        "Terminal",
        name=VALUES,
        matchingRule=RULE,
        terminalKind=KIND,
        description=f"mu over {', '.join(axes)}, linear between the sampling points",
    )
    pairs = [(axis_name(load), "domain", load, "domainInput") for load in axes]
    for parameter, kind, variable, its in (*pairs, (VALUES, "codomain", MU.name, "codomainOutput")):
        for name, role in ((parameter, kind), (variable, its)):
            etree.SubElement(
                terminal,
                "TerminalMemberVariable",
                variableName=name,
                memberName=name,
                variableKind=f"{MEMBER}{role}",
            )
    return xml_bytes(root)
