"""Icon, terminal of the friction port, and licence of an FMU."""

from __future__ import annotations

from lxml import etree

from friction_models.loads import LOADS, MU

from ..interface.friction_source import FrictionSource
from .documentation import ASSETS

#: One line for the attribute `license` of the model description.
LICENCE = "wrapper: MIT; the model in it belongs to its author (documentation/licenses)"

#: `terminalKind` of the friction port: the five loads in, mu out, by these names and in these units.
TERMINAL_KIND = "org.tribofmu.friction"


def presentation_files(source: FrictionSource, fmi: str) -> dict[str, bytes]:
    """Return icon, terminals and licence by their path in the archive.

    Parameters
    ----------
    source : FrictionSource
        Author and licence of the model are taken from its card where it names them.
    fmi : {"2.0", "3.0"}
        FMI 2.0 knows an icon only (``model.png``); FMI 3.0 has terminals with icons of their own.
    """
    files = {"documentation/licenses/license.txt": licence_text(source).encode()}
    if fmi != "3.0":
        return files | {"model.png": (ASSETS / "icon.png").read_bytes()}
    for name in ("icon.png", "icon.svg", "friction_port.png", "friction_port.svg"):
        files[f"terminalsAndIcons/{name}"] = (ASSETS / name).read_bytes()
    return files | {"terminalsAndIcons/terminalsAndIcons.xml": terminals_xml()}


def licence_text(source: FrictionSource) -> str:
    """Return what is licensed how: the model and the wrapper."""
    author = str(source.card.get("author") or "")
    own = str(source.card.get("licence") or source.card.get("license") or "")
    return (
        "This FMU has two parts.\n\n"
        f"1. The friction model {source.name!r}: resources/model.onnx and the numbers in sources/model.h.\n"
        f"   It belongs to its author{f' ({author})' if author else ''}. "
        f"{f'Licence: {own}' if own else 'No licence is recorded in it; ask the author'}.\n\n"
        "2. The wrapper: the other files in sources/ and the libraries compiled from them.\n"
        "   SPDX-License-Identifier: MIT; the text is below.\n\n"
        + (ASSETS / "mit.txt").read_text(encoding="utf-8")
    )


def terminals_xml() -> bytes:
    """Return terminalsAndIcons.xml: one terminal with the five loads and mu, matched by the member names (plug)."""
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = etree.SubElement(root, "GraphicalRepresentation")
    box = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    etree.SubElement(picture, "CoordinateSystem", box | {"suggestedScalingFactorTo_mm": "0.1"})
    etree.SubElement(picture, "Icon", box)
    terminals = etree.SubElement(root, "Terminals")
    terminal = etree.SubElement(
        terminals,
        "Terminal",
        name="friction",
        matchingRule="plug",
        terminalKind=TERMINAL_KIND,
        description="contact points of tool and workpiece: loads in, friction coefficient out",
    )
    for q in (*LOADS, MU):
        etree.SubElement(
            terminal, "TerminalMemberVariable", variableName=q.name, memberName=q.name, variableKind="signal"
        )
    etree.SubElement(
        terminal,
        "TerminalGraphicalRepresentation",
        {"x1": "-110", "y1": "-10", "x2": "-90", "y2": "10"},
        iconBaseName="friction_port",
        defaultConnectionColor="140 47 27",
    )
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")
