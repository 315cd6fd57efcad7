"""Opening FMU archives from anywhere: checked, unpacked into a temporary folder, described.

An FMU holds machine code, so running one means trusting its author. What is guarded here is everything
before that: paths that leave the folder, links, archives that swell, XML that expands or is no FMI.
"""

from __future__ import annotations

import hashlib
import os
import re
import stat
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from friction_models.loads import InputError, unknown_name

MAX_MEMBERS = 20_000
MAX_UNPACKED = 2 * 1024**3
MAX_XML = 256 * 1024**2
_INDEXED = re.compile(r"^(?P<base>.*)\[(?P<index>\d+)\]$")


@dataclass(frozen=True)
class Variable:
    """One scalar variable of an FMU, as far as a master needs it."""

    name: str
    reference: int
    type: str
    causality: str
    unit: str


@dataclass(frozen=True)
class FmuDescription:
    """What `modelDescription.xml` says.

    Attributes
    ----------
    path : Path
        The archive.
    raw : object
        fmpy's model description.
    variables : dict of str to Variable
        By full name, ``v_rel[3]`` included.
    arrays : dict of str to list of Variable
        Elements of each structured name in index order; a scalar is an array of one.
    """

    path: Path
    raw: Any
    variables: dict[str, Variable]
    arrays: dict[str, list[Variable]]

    def resolve(self, name: str, kind: str = "variable", causality: str | None = None) -> list[Variable]:
        """Return the elements behind a scalar, indexed or structured name.

        Raises
        ------
        InputError
            No such variable; the message holds the nearest one.
        """
        if name in self.arrays:
            return self.arrays[name]
        if name in self.variables:
            return [self.variables[name]]
        allowed = [
            base
            for base, elements in self.arrays.items()
            if causality is None or elements[0].causality == causality
        ]
        raise unknown_name(kind, name, allowed, self.path.name)

    @property
    def state_can_be_saved(self) -> bool:
        """Whether the FMU can be rolled back (needed by the iterated mode)."""
        return bool(self.raw.coSimulation.canGetAndSetFMUstate)

    @property
    def sha256(self) -> str:
        """Hash of the archive."""
        return file_hash(self.path)


def file_hash(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file as hexadecimal text."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def describe(path: str | os.PathLike[str]) -> FmuDescription:
    """Read the model description of an FMI 2.0 co-simulation FMU.

    Raises
    ------
    InputError
        No such file, not an archive, a hostile or damaged archive, not FMI 2.0 co-simulation.
    """
    file = Path(path)
    with _archive(file) as archive:
        _check_members(file, archive)
        xml = _description_text(file, archive)
    version = re.search(rb'fmiVersion\s*=\s*["\']([^"\']*)["\']', xml[:4096])
    if version is not None and version.group(1) != b"2.0":
        raise InputError(f"{file}: FMI version {version.group(1).decode(errors='replace')!r}, allowed: '2.0'")
    try:
        from fmpy.model_description import read_model_description

        raw = read_model_description(str(file), validate=False)
    except Exception as error:
        raise InputError(
            f"{file}: modelDescription.xml is not valid FMI 2.0 ({_first_line(error)})"
        ) from None
    if raw.coSimulation is None:
        raise InputError(f"{file}: the FMU offers no co-simulation, allowed: FMI 2.0 for co-simulation")
    return _describe(file, raw)


def _describe(file: Path, raw: Any) -> FmuDescription:
    variables: dict[str, Variable] = {}
    indexed: dict[str, list[tuple[int, Variable]]] = {}
    for item in raw.modelVariables:
        declared = item.declaredType
        unit = item.unit or (declared.unit if declared is not None else None) or ""
        variable = Variable(item.name, int(item.valueReference), item.type, item.causality or "local", unit)
        if item.name in variables:
            raise InputError(f"{file}: variable {item.name!r} stands twice in modelDescription.xml")
        variables[item.name] = variable
        match = _INDEXED.match(item.name)
        base, index = (match["base"], int(match["index"])) if match else (item.name, 0)
        indexed.setdefault(base, []).append((index, variable))
    arrays = {base: [v for _, v in sorted(found, key=_index)] for base, found in indexed.items()}
    return FmuDescription(file, raw, variables, arrays)


def _index(pair: tuple[int, Variable]) -> int:
    return pair[0]


def unpack(description: FmuDescription, folder: Path) -> Path:
    """Unpack a described FMU into `folder` and return the folder; nothing is written outside it.

    Raises
    ------
    InputError
        A damaged or hostile archive, or no binary for this platform.
    """
    from fmpy import platform, sharedLibraryExtension

    file = description.path
    with _archive(file) as archive:
        for member in _check_members(file, archive):
            try:
                archive.extract(member, folder)
            except (zipfile.BadZipFile, OSError, EOFError, ValueError, NotImplementedError) as error:
                raise InputError(
                    f"{file}: member {member.filename!r} cannot be unpacked ({_first_line(error)})"
                ) from None
    name = description.raw.coSimulation.modelIdentifier + sharedLibraryExtension
    if not (folder / "binaries" / platform / name).is_file():
        present = sorted(p.name for p in (folder / "binaries").glob("*") if p.is_dir())
        raise InputError(
            f"{file}: no binary for the platform {platform!r}; present: {', '.join(present) or 'none'}"
        )
    return folder


def _archive(file: Path) -> zipfile.ZipFile:
    if file.is_dir():
        raise InputError(f"{file}: is a folder, allowed: an FMU file")
    if not file.is_file():
        raise InputError(f"{file}: no such file")
    try:
        return zipfile.ZipFile(file)
    except (zipfile.BadZipFile, OSError, EOFError, ValueError):
        raise InputError(f"{file}: not an FMU (the file is no ZIP archive or it is damaged)") from None


def _check_members(file: Path, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    members = archive.infolist()
    if len(members) > MAX_MEMBERS:
        raise InputError(f"{file}: {len(members)} members, allowed: at most {MAX_MEMBERS}")
    total = sum(m.file_size for m in members)
    if total > MAX_UNPACKED:
        raise InputError(f"{file}: {total} bytes unpacked, allowed: at most {MAX_UNPACKED}")
    for member in members:
        if _escapes(member):
            raise InputError(
                f"{file}: member {member.filename!r} is a link or leads out of the archive; allowed: plain relative paths"
            )
    return members


def _escapes(member: zipfile.ZipInfo) -> bool:
    name = member.filename.replace("\\", "/")
    path = PurePosixPath(name)
    link = stat.S_ISLNK(member.external_attr >> 16)
    return link or path.is_absolute() or ".." in path.parts or bool(re.match(r"^[A-Za-z]:", name))


def _description_text(file: Path, archive: zipfile.ZipFile) -> bytes:
    try:
        info = archive.getinfo("modelDescription.xml")
    except KeyError:
        raise InputError(f"{file}: not an FMU (modelDescription.xml is missing)") from None
    if info.file_size > MAX_XML:
        raise InputError(
            f"{file}: modelDescription.xml has {info.file_size} bytes, allowed: at most {MAX_XML}"
        )
    try:
        xml = archive.read(info)
    except (zipfile.BadZipFile, OSError, EOFError, ValueError, NotImplementedError) as error:
        raise InputError(f"{file}: modelDescription.xml cannot be read ({_first_line(error)})") from None
    if b"<!DOCTYPE" in xml or b"<!ENTITY" in xml:
        raise InputError(f"{file}: modelDescription.xml declares a document type; allowed: none")
    return xml


def _first_line(error: BaseException) -> str:
    lines: Iterable[str] = str(error).strip().splitlines()
    return next(iter(lines), type(error).__name__)
