"""Icon, terminals of the friction port and of a map, and licence of an FMU."""

from __future__ import annotations

from ..interface.friction_source import FrictionSource
from ..interface.ls_struct import MANIFEST, manifest, map_axes, with_map_terminal
from .documentation import ASSETS

#: One line for the attribute `license` of the model description.
LICENCE = "wrapper: MIT; the model in it belongs to its author (documentation/licenses)"
#: What an FMI 3.0 archive holds of its terminal: loads in, mu out, matched by the names of the members.
_TERMINALS = ("icon.png", "icon.svg", "friction_port.png", "friction_port.svg", "terminalsAndIcons.xml")


def presentation_files(source: FrictionSource, fmi: str) -> dict[str, bytes]:
    """Return icon, terminals and licence by their path in the archive.

    FMI 2.0 knows an icon only (``model.png``); FMI 3.0 has terminals with icons of their own, also that of a friction map, with
    the manifest of the layered standard.
    """
    files = {"documentation/licenses/license.txt": licence_text(source).encode()}
    if fmi != "3.0":
        return files | {"model.png": (ASSETS / "icon.png").read_bytes()}
    files |= {f"terminalsAndIcons/{name}": (ASSETS / name).read_bytes() for name in _TERMINALS}
    axes = map_axes(source.system)
    if axes:
        terminals = f"terminalsAndIcons/{_TERMINALS[-1]}"
        files |= {terminals: with_map_terminal(files[terminals], axes), MANIFEST: manifest()}
    return files


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
