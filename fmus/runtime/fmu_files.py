"""Model descriptions of FMUs, read and checked, and FMUs unpacked to run.

An FMU holds machine code, so running one means trusting its author. What is guarded (`fmus.archive.content`) is
everything before that: paths that leave the folder, archives that swell, XML that expands.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lxml import etree

from friction_models.common import InputError, unknown_name
from friction_models.loads import LOADS, MU

from ..archive.content import read_description, read_member
from ..archive.content import unpack as unpack_archive
from .c_interface.slave import library_in
from .fmu_variables import Variable, expand, sizing_parameter

#: Where a friction FMU holds its model card, and how large a card may be.
CARD, MAX_CARD_BYTES = "documentation/card.json", 4_000_000


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
    sizes : dict of str to int
        Values chosen for structural parameters (FMI 3.0).

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     description = describe(pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python"))
    >>> description.resolve("sigma_n")[0].unit, description.synthetic
    ('MPa', False)
    >>> description.resolve("sigma")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: law.fmu: unknown variable 'sigma'; allowed: T, clamp_to_domain, domain_distance, in_domain, mu, psi, sd, sigma_n, v_rel; did you mean 'sigma_n'?
    """

    path: Path
    raw: Any
    variables: dict[str, Variable]
    arrays: dict[str, list[Variable]]
    sizes: dict[str, int] = field(default_factory=dict)

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

    def sized(self, sizes: Mapping[str, int]) -> FmuDescription:
        """Return the description with other values of structural parameters.

        Raises
        ------
        InputError
            No such structural parameter, or a value outside its limits.
        """
        known = self.structure
        for name, value in sizes.items():
            if name not in known:
                raise unknown_name("structural parameter", name, known, str(self.path))
            low, high = max(1, _whole(known[name].min, 1)), _whole(known[name].max, 2**63 - 1)
            if not low <= value <= high:
                raise InputError(
                    f"{self.path}: structural parameter {name!r} = {value}, allowed: {low} to {high}"
                )
        merged = self.sizes | dict(sizes)
        return FmuDescription(self.path, self.raw, *expand(self.path, self.raw, merged), merged)

    @property
    def structure(self) -> dict[str, Any]:
        """fmpy's variables of the structural parameters, by name (FMI 3.0)."""
        return {str(v.name): v for v in self.raw.modelVariables if v.causality == "structuralParameter"}

    def structural(self) -> list[tuple[Variable, int]]:
        """Return the structural parameters that differ from their start values, and their values."""
        return [(self.variables[name], value) for name, value in self.sizes.items()]

    def sizing(self, name: str) -> str | None:
        """Return the structural parameter that sizes the vector `name`, None for what has a fixed size."""
        found = self.arrays.get(name)
        if self.version == "2.0" or not found:
            return None
        reference = found[0].reference
        item = next((v for v in self.raw.modelVariables if int(v.valueReference) == reference), None)
        return None if item is None else sizing_parameter(item)

    @property
    def version(self) -> str:
        """Version of the standard, ``2.0`` or ``3.0``."""
        return "2.0" if self.raw.fmiVersion == "2.0" else "3.0"

    @property
    def state_can_be_saved(self) -> bool:
        """Whether the FMU can be rolled back (needed by the iterated mode)."""
        flags = self.raw.coSimulation
        return bool(flags.canGetAndSetFMUstate)

    @property
    def is_scalar_friction(self) -> bool:
        """Whether this is a friction FMU of one contact point: five scalar loads in, mu out."""
        wanted = [*((q.name, "input") for q in LOADS), (MU.name, "output")]
        return all(
            name in self.variables and self.variables[name].causality == causality
            for name, causality in wanted
        )

    @property
    def synthetic(self) -> bool:
        """Whether the FMU says of itself (in its model card) that it was trained on synthetic data."""
        from friction_models.models.model_card import trained_on_synthetic

        try:
            return trained_on_synthetic(json.loads(read_member(self.path, CARD, MAX_CARD_BYTES)))
        except (InputError, ValueError, RecursionError):
            return False  # no card, or one of others

    @property
    def sha256(self) -> str:
        """Hash of the archive."""
        return file_hash(self.path)


def file_hash(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file as hexadecimal text.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "empty"
    ...     file.touch()
    ...     file_hash(file)[:16]
    'e3b0c44298fc1c14'
    """
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def read_model(path: Path) -> tuple[etree._Element, Any]:
    """Read modelDescription.xml of an FMU that nobody has looked at yet.

    Returns
    -------
    root : Element
        Root of the file.
    raw : object
        fmpy's model description.

    Raises
    ------
    InputError
        No such file, not an archive, a hostile or damaged archive, neither FMI 2.0 nor 3.0, neither co-simulation
        nor model exchange, a description that fmpy cannot use.
    """
    root = read_description(path)
    version = str(root.get("fmiVersion"))
    # FMI 3.1 and later minor versions promise to stay readable for importers of 3.0.
    if version != "2.0" and not re.fullmatch(r"3\.\d+", version):
        raise InputError(f"{path}: FMI version {version[:20]!r}, allowed: '2.0', '3.0'")
    from fmpy import read_model_description

    try:
        raw: Any = read_model_description(str(path), validate=False)
    except Exception as error:  # fmpy raises plain exceptions
        raise _not_valid(path, version, error) from None
    interfaces = [i for i in (raw.coSimulation, raw.modelExchange) if i is not None]
    if not interfaces:
        raise InputError(
            f"{path}: the FMU offers neither co-simulation nor model exchange, allowed: one of them"
        )
    for identifier in (str(i.modelIdentifier) for i in interfaces):
        # It becomes part of a path.
        if not re.fullmatch(r"[A-Za-z_]\w{0,199}", identifier, flags=re.ASCII):
            raise InputError(f"{path}: modelIdentifier {identifier[:60]!r}, allowed: a name as in C")
    for variable in raw.modelVariables:
        if not 0 <= int(variable.valueReference) < 2**32:
            raise InputError(
                f"{path}: variable {str(variable.name)[:60]!r} has value reference {variable.valueReference}, "
                f"allowed: 0 to {2**32 - 1}"
            )
    return root, raw


def describe(path: str | os.PathLike[str]) -> FmuDescription:
    """Read the model description of a co-simulation FMU.

    Raises
    ------
    InputError
        What `read_model` refuses; no co-simulation; a variable whose type, shape or start value cannot be used.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     description = describe(pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python", nodes=2))
    ...     description.version, [v.name for v in description.resolve("mu")]
    ('2.0', ['mu[1]', 'mu[2]'])
    """
    file = Path(path)
    _, raw = read_model(file)
    if raw.coSimulation is None:
        raise InputError(
            f"{file}: the FMU offers no co-simulation, allowed: FMI {raw.fmiVersion} for co-simulation"
        )
    try:
        return FmuDescription(file, raw, *expand(file, raw, {}))
    except InputError:
        raise
    except Exception as error:  # sizes and start values that are no numbers
        raise _not_valid(file, raw.fmiVersion, error) from None


def unpack(description: FmuDescription, folder: Path) -> Path:
    """Unpack a described FMU into `folder` and return the folder; nothing is written outside it.

    Raises
    ------
    InputError
        A damaged or hostile archive, or no binary for this platform.
    """
    from fmpy import platform, platform_tuple

    file = description.path
    unpack_archive(file, folder)
    if not library_in(folder, description.raw).is_file():
        wanted = platform if description.version == "2.0" else platform_tuple
        present = sorted(p.name for p in (folder / "binaries").glob("*") if p.is_dir())
        raise InputError(
            f"{file}: no binary for the platform {wanted!r}; present: {', '.join(present) or 'none'}"
        )
    return folder


def _whole(text: str | None, otherwise: int) -> int:
    """Return a limit from the XML; not through floating point, as it may have 64 bits."""
    return int(text) if text is not None and re.fullmatch(r"-?\d{1,20}", text) else otherwise


def _not_valid(path: Path, version: str, error: Exception) -> InputError:
    lines = str(error).strip().splitlines()
    return InputError(
        f"{path}: modelDescription.xml is not valid FMI {version} ({lines[0][:200] if lines else type(error).__name__})"
    )
