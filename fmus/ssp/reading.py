"""Reads SSP archives without trusting them: bounded sizes, plain XML, no file outside the archive."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from lxml import etree

from friction_models.common import InputError, check_readable

from ..archive.content import MAX_DESCRIPTION_BYTES, parse_xml, read_member, read_members, unpack_members
from .systems import DESCRIPTION, SPACES, Connector, SspComponent, Structure, Value

#: Our notes are small; what is larger is not ours.
_MAX_NOTES = 1_000_000


def read_ssp(path: str | os.PathLike[str]) -> Structure:
    """Read the structure of an SSP archive of one level.

    Raises InputError: no such file, a hostile or damaged archive, no or unusual `SystemStructure.ssd`; nested systems,
    transformations and mappings, which would change the numbers if they were passed over.
    """
    file = Path(path)
    check_readable(file, allowed="an SSP archive (.ssp)")
    try:
        members = read_members(file)
    except InputError as error:
        raise InputError(str(error).replace("not an FMU: ", "not an SSP: ")) from None
    if DESCRIPTION not in members:
        raise InputError(f"{file}: not an SSP: there is no {DESCRIPTION} in the archive")
    root = parse_xml(read_member(file, DESCRIPTION, MAX_DESCRIPTION_BYTES), f"{file}: {DESCRIPTION}")
    if root.tag != f"{{{SPACES['ssd']}}}SystemStructureDescription":
        raise InputError(f"{file}: {DESCRIPTION} holds {root.tag!r}, allowed: an SSP 1.0 system structure")
    system = root.find("ssd:System", SPACES)
    if system is None:
        raise InputError(f"{file}: {DESCRIPTION} has no System")
    return _Reader(file, set(members)).structure(root, system)


def unpack_ssp(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> Path:
    """Unpack an archive that `read_ssp` accepts into `folder`."""
    return unpack_members(path, folder)


class _Reader:
    def __init__(self, file: Path, members: set[str]) -> None:
        self.file = file
        self.members = members

    def structure(self, root: etree._Element, system: etree._Element) -> Structure:
        for tag, what in (
            ("ssd:Elements/ssd:System", "nested systems"),
            ("ssd:Elements/ssd:SignalDictionaryReference", "signal dictionaries"),
        ):
            if system.find(tag, SPACES) is not None:
                raise InputError(f"{self.file}: {what} are not read, allowed: components of one level")
        name = str(system.get("name") or root.get("name") or self.file.stem)
        result = Structure(name, connectors=_connectors(system), start=self._start(system, name))
        result.components = [
            self._component(e) for e in system.iterfind("ssd:Elements/ssd:Component", SPACES)
        ]
        names = [c.name for c in result.components]
        if not names:
            raise InputError(f"{self.file}: the system has no components")
        if len(set(names)) != len(names):
            twice = next(n for n in names if names.count(n) > 1)
            raise InputError(f"{self.file}: component {twice!r} stands twice, allowed: once")
        known = {*names, ""}
        for element in system.iterfind("ssd:Connections/ssd:Connection", SPACES):
            result.connections.append(self._connection(element, known))
        experiment = root.find("ssd:DefaultExperiment", SPACES)
        if experiment is not None:
            begin = self._number(experiment, "startTime")
            if begin:
                raise InputError(f"{self.file}: startTime is {begin:g}, allowed: 0")
            result.stop = self._number(experiment, "stopTime")
        result.notes = self._notes(system)
        result.step = self._step(root, system, result.notes)
        return result

    def _component(self, element: etree._Element) -> SspComponent:
        name, source = str(element.get("name") or ""), str(element.get("source") or "")
        if not name or "." in name or "->" in name or name != name.strip():
            raise InputError(
                f"{self.file}: component name {name!r} cannot be used, allowed: a name without '.' and '->'"
            )
        if (
            element.find("ssd:ParameterBindings/ssd:ParameterBinding/ssd:ParameterMapping", SPACES)
            is not None
        ):
            raise InputError(f"{self.file}: component {name!r} has a parameter mapping, which is not read")
        place = self._inside(source, f"component {name!r}")
        if PurePosixPath(place).suffix != ".fmu":
            raise InputError(f"{self.file}: component {name!r} is {source!r}, allowed: an FMU in the archive")
        return SspComponent(name, place, _connectors(element), self._start(element, f"component {name!r}"))

    def _inside(self, source: str, what: str) -> str:
        """Return the member of the archive that a reference means."""
        place = unquote(source).removeprefix("./")
        if place not in self.members:
            raise InputError(f"{self.file}: {what} refers to {source!r}, which is not in the archive")
        return place

    def _connection(self, element: etree._Element, known: set[str]) -> tuple[str, str, str, str]:
        keys = ("startElement", "startConnector", "endElement", "endConnector")
        start, output, end, given = (str(element.get(key) or "") for key in keys)
        shown = f"{start}.{output} -> {end}.{given}"
        for name in (start, end):
            if name not in known:
                raise InputError(f"{self.file}: connection {shown!r} names {name!r}, which is no component")
        if not output or not given:
            raise InputError(f"{self.file}: connection {shown!r} lacks a connector")
        if any(isinstance(e.tag, str) and e.tag.endswith("Transformation") for e in element):
            raise InputError(f"{self.file}: connection {shown!r} transforms values, which is not read")
        return start, output, end, given

    def _start(self, element: etree._Element, what: str) -> dict[str, Value]:
        values: dict[str, Value] = {}
        for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", SPACES):
            prefix = str(binding.get("prefix") or "")
            sets = binding.findall("ssd:ParameterValues/ssv:ParameterSet", SPACES)
            source = binding.get("source")
            if source is not None:
                place = self._inside(source, f"{what}: parameter values")
                content = read_member(self.file, place, MAX_DESCRIPTION_BYTES)
                sets.append(parse_xml(content, f"{self.file}: {place}"))
            for parameter in (p for s in sets for p in s.iterfind("ssv:Parameters/ssv:Parameter", SPACES)):
                name = prefix + str(parameter.get("name") or "")
                values[name] = self._value(parameter, f"{what}: parameter {name!r}")
        return values

    def _value(self, parameter: etree._Element, what: str) -> Value:
        typed = next((e for e in parameter if isinstance(e.tag, str)), None)
        kind = "" if typed is None else str(etree.QName(typed).localname)
        text = "" if typed is None else str(typed.get("value") or "")
        try:
            if kind == "Real":
                number = float(text)
                if not math.isfinite(number):
                    raise ValueError
                return number
            if kind in {"Integer", "Enumeration"}:
                return int(text)
        except ValueError:
            raise InputError(f"{self.file}: {what} is {text!r}, allowed: {kind}") from None
        if kind == "Boolean" and text in {"true", "false", "1", "0"}:
            return text in {"true", "1"}
        if kind == "String":
            return text
        raise InputError(
            f"{self.file}: {what} is {text!r} of type {kind!r}, allowed: Real, Integer, Boolean, String"
        )

    def _number(self, element: etree._Element, key: str) -> float | None:
        text = element.get(key)
        if text is None:
            return None
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise InputError(f"{self.file}: {key} is {text!r}, allowed: a number")
        return number

    def _step(self, root: etree._Element, system: etree._Element, notes: dict[str, object]) -> float | None:
        own = notes.pop("communication_step", None)
        if isinstance(own, int | float) and not isinstance(own, bool):
            return float(own)
        for place, tag, key in (
            (root, ".//osp:FixedStepAlgorithm", "baseStepSize"),
            (system, ".//oms:FixedStepMaster", "stepSize"),
        ):
            found = place.find(tag, SPACES)
            if found is not None:
                return self._number(found, key)
        return None

    def _notes(self, system: etree._Element) -> dict[str, object]:
        found = system.find("ssd:Annotations/ssc:Annotation/tribofmu:Notes", SPACES)
        text = "" if found is None else str(found.text or "")
        if not text or len(text) > _MAX_NOTES:
            return {}
        try:
            notes = json.loads(text)
        except (ValueError, RecursionError):
            raise InputError(f"{self.file}: the notes of tribofmu in {DESCRIPTION} are not JSON") from None
        return notes if isinstance(notes, dict) else {}


def _connectors(element: etree._Element) -> list[Connector]:
    found = []
    for connector in element.iterfind("ssd:Connectors/ssd:Connector", SPACES):
        typed = next(
            (e for e in connector if isinstance(e.tag, str) and e.tag.startswith(f"{{{SPACES['ssc']}}}")),
            None,
        )
        kind = "Real" if typed is None else str(etree.QName(typed).localname)
        unit = "" if typed is None else str(typed.get("unit") or "")
        found.append(
            Connector(str(connector.get("name") or ""), str(connector.get("kind") or ""), kind, unit)
        )
    return found
