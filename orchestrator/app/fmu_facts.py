"""Facts about an FMU for the page that offers it; the file is not trusted, and none of its code runs."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from friction_models.common import InputError
from friction_models.common.errors import shown

from .project.loaded import kept_while_unchanged

if TYPE_CHECKING:
    from lxml.etree import _Element

#: Largest description that is read for a card [byte], and most variables that it names.
LARGEST, NAMED = 20_000_000, 12
_KINDS = {
    "CoSimulation": "co-simulation",
    "ModelExchange": "model exchange",
    "ScheduledExecution": "scheduled execution",
}
#: Folders of shared libraries as FMI 2.0 and 3.0 name them.
_SYSTEMS = {
    "linux64": "Linux", "win64": "Windows", "darwin64": "macOS", "win32": "Windows (32 bit)", "linux32": "Linux (32 bit)",
    "x86_64-linux": "Linux", "x86_64-windows": "Windows", "x86_64-darwin": "macOS", "aarch64-darwin": "macOS (ARM)",
    "aarch64-linux": "Linux (ARM)", "aarch64-windows": "Windows (ARM)",
}  # fmt: skip
_PLACE = re.compile(r"\[\d+(,\d+)*\]$")


@dataclass(frozen=True)
class Facts:
    """What is known of an FMU or a system: `rows` of a table, when it was `written` (UTC), and why there is not more."""

    rows: list[tuple[str, str]] = field(default_factory=list)
    written: str = ""
    problem: str = ""


@kept_while_unchanged(200)
def facts_of(file: Path) -> Facts:
    """Return what is known of an FMU; of a system size and date alone."""
    found = file.stat()
    written = datetime.fromtimestamp(found.st_mtime, UTC).strftime("%Y-%m-%d %H:%M")
    rows, problem = [], ""
    if file.suffix == ".fmu":
        try:
            rows = _described(file)
        except (InputError, OSError) as error:
            problem = f"What is in it cannot be read: {shown(error)}"
    return Facts(
        [*rows, ("size", f"{found.st_size / 1000:.0f} kB"), ("written", f"{written} UTC")], written, problem
    )


def _described(file: Path) -> list[tuple[str, str]]:
    from fmus.archive.content import parse_xml, read_archive, read_member

    members = read_archive(file)
    name = "modelDescription.xml"
    root = parse_xml(read_member(file, name, LARGEST), f"{file.name}: {name}")
    kinds = [word for tag, word in _KINDS.items() if root.find(tag) is not None]
    variables = [v for v in root.iterfind("ModelVariables/*") if isinstance(v.tag, str)]
    rows = [
        ("model", shown(root.get("modelName", ""), 120)),
        ("FMI", f"{shown(root.get('fmiVersion', '?'), 10)}, {' and '.join(kinds) or 'of no known kind'}"),
        ("runs as", _runs_as(list(members))),
        ("inputs", _names(variables, "input")),
        ("outputs", _names(variables, "output")),
        ("parameters", _names(variables, "parameter")),
    ]
    points = _points(variables)
    return [*(r for r in rows if r[1]), *([("contact points", str(points))] if points > 1 else [])]


def _runs_as(members: list[str]) -> str:
    """Return what an archive holds to be run.

    Examples
    --------
    >>> _runs_as(["binaries/linux64/a.so", "binaries/win64/a.dll", "sources/a.c"]), _runs_as(["resources/law.py", "binaries/linux64/a.so"])
    ('compiled code for Linux, Windows; C sources', 'Python, which has to be installed')
    """
    if any(m.startswith("resources/") and m.endswith(".py") for m in members):
        return "Python, which has to be installed"
    folders = sorted({m.split("/")[1] for m in members if m.startswith("binaries/") and m.count("/") > 1})
    compiled = ", ".join(_SYSTEMS.get(f, shown(f, 30)) for f in folders)
    parts = [
        f"compiled code for {compiled}" if compiled else "",
        "C sources" if any(m.endswith(".c") for m in members) else "",
    ]
    return "; ".join(p for p in parts if p)


def _names(variables: list[_Element], causality: str) -> str:
    """Return the variables of a causality with their units; arrays are named once."""
    found: dict[str, str] = {}
    for v in variables:
        if v.get("causality") == causality:
            found.setdefault(_PLACE.sub("", v.get("name", "?")), _unit(v))
    named = [f"{shown(n, 60)} [{shown(u, 20)}]" if u else shown(n, 60) for n, u in found.items()]
    more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
    return ", ".join(named[:NAMED]) + more


def _unit(variable: _Element) -> str:
    """Return the unit: FMI 3.0 has it with the variable, FMI 2.0 with its type."""
    return str(variable.get("unit") or next((t.get("unit") for t in variable if t.get("unit")), ""))


def _points(variables: list[_Element]) -> int:
    """Return how many contact points there are: as FMI 2.0 numbers names, or as FMI 3.0 gives dimensions."""
    outputs = [v for v in variables if v.get("causality") == "output"]
    numbered = Counter(_PLACE.sub("", name) for v in outputs if _PLACE.search(name := v.get("name", "")))
    sizes = {d.get("start", "") for v in outputs for d in v.iterfind("Dimension")}
    asked = {d.get("valueReference") for v in outputs for d in v.iterfind("Dimension")} - {None}
    sizes |= {v.get("start", "") for v in variables if v.get("valueReference") in asked}
    given = [int(s) for s in sizes if s.isdecimal() and len(s) < 10]
    return max([1, *numbered.values(), *given])
