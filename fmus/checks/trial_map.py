"""Trial of `check`: maps after the layered standard FMI-LS-STRUCT, as far as manifest, terminals and variables tell."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any

from lxml import etree

from friction_models.common import InputError

from ..archive.content import parse_xml
from ..interface.ls_struct import DESCRIPTION, KIND, MANIFEST, MEMBER, NAME, NAMESPACE, RULE, VERSION
from ..runtime.fmu_files import UnpackedFmu
from .report import Notes

if TYPE_CHECKING:
    from fmpy.model_description import ScalarVariable

_IRREGULAR = f"{NAME}.map.irregular"
_MAX_BYTES = 16 * 1024**2
#: What stands directly behind a vector of sampling points and behind an array of values, if anything, and its causalities.
_FOLLOWERS = {"domainInput": "domain", "codomainOutput": "codomain"}
_ROLES = (*_FOLLOWERS, *_FOLLOWERS.values())
_CAUSALITIES = {
    "domain": {"parameter", "constant", "structuralParameter"},
    "domainInput": {"input", "output", "local"},
    "codomainOutput": {"output", "local"},
}


def maps(fmu: UnpackedFmu, notes: Notes) -> None:
    """Look at the maps of an FMU that says that it keeps to the layered standard."""
    if not (fmu.folder / MANIFEST).is_file():
        return
    terminals = fmu.folder / "terminalsAndIcons" / "terminalsAndIcons.xml"
    try:
        problems = _manifest(_xml(fmu, MANIFEST))
        found = list(_xml(fmu, terminals.relative_to(fmu.folder).as_posix()).iter("{*}Terminal"))
        found = [t for t in found if str(t.get("terminalKind", "")).startswith(f"{NAME}.")]
        for terminal in found:
            problems += [f"terminal {terminal.get('name')!r}: {p}" for p in _terminal(fmu, terminal)]
    except InputError as error:
        notes.add(False, str(error))
        return
    for problem in problems[:10]:
        notes.add(False, problem)
    shapes = [f"{t.get('name')} over {', '.join(_named(t, 'domain'))}" for t in found]
    notes.add(not problems, f"maps after {NAME} {VERSION}: {'; '.join(shapes) or 'none'}")


def _xml(fmu: UnpackedFmu, path: str) -> etree._Element:
    file = fmu.folder / path
    if not file.is_file():
        raise InputError(f"{path} is missing; allowed: with the manifest of {NAME} it is there")
    if file.stat().st_size > _MAX_BYTES:
        raise InputError(f"{path}: {file.stat().st_size} bytes, allowed: at most {_MAX_BYTES}")
    return parse_xml(file.read_bytes(), path)


def _manifest(root: etree._Element) -> list[str]:
    wanted = {"name": NAME, "version": VERSION, "description": DESCRIPTION}
    problems = []
    if etree.QName(root).localname != "fmiLayeredStandardManifest":
        problems.append(
            f"manifest: element {etree.QName(root).localname!r}, allowed: 'fmiLayeredStandardManifest'"
        )
    for key, value in wanted.items():
        given = root.get(f"{{{NAMESPACE}}}fmi-ls-{key}")
        if given != value:
            problems.append(f"manifest: fmi-ls-{key} is {str(given)[:60]!r}, allowed: {value!r}")
    return problems


def _named(terminal: etree._Element, kind: str) -> list[str]:
    members = terminal.iterfind("{*}TerminalMemberVariable")
    return [str(m.get("variableName")) for m in members if m.get("variableKind") == MEMBER + kind]


def _terminal(fmu: UnpackedFmu, terminal: etree._Element) -> list[str]:
    """Return what is wrong with the terminal of a map."""
    variables: dict[str, ScalarVariable] = {v.name: v for v in fmu.raw.modelVariables}
    kind, problems = terminal.get("terminalKind"), []
    if kind not in {KIND, _IRREGULAR}:
        return [f"terminalKind {str(kind)[:80]!r}, allowed: {KIND!r}, {_IRREGULAR!r}"]
    if terminal.get("matchingRule") != RULE:
        problems.append(f"matchingRule {str(terminal.get('matchingRule'))[:80]!r}, better: {RULE!r}")
    before: tuple[str, Any] = ("", None)
    for member in terminal.iterfind("{*}TerminalMemberVariable"):
        name, role = str(member.get("variableName")), str(member.get("variableKind"))
        if not role.startswith(f"{NAME}"):
            continue
        role = role.removeprefix(MEMBER)
        variable = variables.get(name)
        if role not in _ROLES:
            problems.append(f"variableKind {role[:80]!r} of {name!r} is none of the standard")
        elif variable is None:
            problems.append(f"there is no variable {name[:80]!r}")
        else:
            allowed = _CAUSALITIES.get(role, {variable.causality})
            if variable.causality not in allowed:
                causes = ", ".join(sorted(allowed))
                problems.append(
                    f"{role} {name!r} has the causality {variable.causality!r}, allowed: {causes}"
                )
            if role in _FOLLOWERS and before[0] != _FOLLOWERS[role]:
                problems.append(f"{role} {name!r} does not stand directly behind its {_FOLLOWERS[role]}")
            elif role in _FOLLOWERS and before[1] and before[1].type != variable.type:
                problems.append(
                    f"{role} {name!r} is {variable.type}, allowed: {before[1].type} as {before[1].name!r}"
                )
        before = (role, variable)
    return problems + _shapes(terminal, variables, regular=kind == KIND)


def _shapes(terminal: etree._Element, variables: dict[str, ScalarVariable], regular: bool) -> list[str]:
    """Return what is wrong with the sizes of the arrays, and with the order of the sampling points."""
    lengths, problems = [], []
    known = {kind: [n for n in _named(terminal, kind) if n in variables] for kind in _ROLES}
    for name in known["domain"]:
        shape = _shape(variables[name])
        if len(shape) != 1:
            problems.append(f"domain {name!r} has {len(shape)} dimensions, allowed: 1")
        lengths.append(math.prod(shape))
        values = [float(x) for x in str(variables[name].start or "").split()]
        if regular and any(not b > a for a, b in itertools.pairwise(values)):
            problems.append(f"the sampling points of {name!r} do not rise")
    if not lengths or not known["codomain"]:
        problems.append("a map has at least one domain and one codomain")
    wanted = lengths if regular else lengths[:1]
    for name in known["codomain"]:
        if _shape(variables[name]) != wanted:
            problems.append(f"codomain {name!r} has the shape {_shape(variables[name])}, allowed: {wanted}")
    sizes = {math.prod(_shape(variables[n])) for n in known["domainInput"]}
    if len(sizes) > 1:
        problems.append(f"the domainInput variables have {sorted(sizes)} values, allowed: the same number")
    return problems


def _shape(variable: Any) -> list[int]:
    return [int(d.start if d.variable is None else d.variable.start) for d in variable.dimensions]
