"""FMUs as the master sees them: variables by name and structured name, unpacked where they can run.

An FMU holds machine code, so running one means trusting its author. What is guarded (`fmus.archive`) is
everything before that: paths that leave the folder, archives that swell, XML that expands.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from friction_models.loads import LOADS, MU, InputError, unknown_name

_INDEXED = re.compile(r"^(?P<base>.*)\[(?P<index>\d+)\]$")


@dataclass(frozen=True)
class Variable:
    """One scalar variable of an FMU, as far as a master needs it.

    `point` is the contact point whose instance holds it, where an FMU runs once a point.
    """

    name: str
    reference: int
    type: str
    causality: str
    unit: str
    point: int = 0


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
    def is_scalar_friction(self) -> bool:
        """Whether this is a friction FMU of one contact point: five scalar loads in, mu out."""
        wanted = [*((q.name, "input") for q in LOADS), (MU.name, "output")]
        return all(
            name in self.variables and self.variables[name].causality == causality
            for name, causality in wanted
        )

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
    from fmus.archive import read_description

    file = Path(path)
    version = read_description(file).get("fmiVersion")
    if version != "2.0":
        raise InputError(f"{file}: FMI version {version!r}, allowed: '2.0'")
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

    from fmus.archive import unpack as extract

    file = description.path
    extract(file, folder)
    name = description.raw.coSimulation.modelIdentifier + sharedLibraryExtension
    if not (folder / "binaries" / platform / name).is_file():
        present = sorted(p.name for p in (folder / "binaries").glob("*") if p.is_dir())
        raise InputError(
            f"{file}: no binary for the platform {platform!r}; present: {', '.join(present) or 'none'}"
        )
    return folder


def _first_line(error: BaseException) -> str:
    lines: Iterable[str] = str(error).strip().splitlines()
    return next(iter(lines), type(error).__name__)
