"""Model descriptions of FMUs, read and checked, and FMUs unpacked to run.

An FMU holds machine code, so running one means trusting its author. What is guarded (`fmus.archive.content`) is
everything before that: paths that leave the folder, archives that swell, XML that expands.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Self

from lxml import etree

from friction_models.common import InputError, unknown_name
from friction_models.common.cached_results import path_digest
from friction_models.loads import LOADS, MU

from ..archive.content import read_description, read_member, unpack_members
from .c_interface.slave import library_in
from .fmu_variables import Variable, expand, sizing_parameter

#: Where a friction FMU holds its model card, and how large a card may be.
CARD, MAX_CARD_BYTES = "documentation/card.json", 4_000_000
#: The variables of a friction FMU and what they are.
_FRICTION = (*((q, "input") for q in LOADS), (MU, "output"))


@dataclass(frozen=True)
class FmuDescription:
    """What `modelDescription.xml` says.

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

    path: Path  #: The archive.
    raw: Any  #: fmpy's model description.
    variables: dict[str, Variable]  #: By full name, ``v_rel[3]`` included.
    #: Elements of each structured name in index order; a scalar is an array of one.
    arrays: dict[str, list[Variable]]
    #: Attributes of the element ``CoSimulation``; fmpy leaves out some of them, and the bounds.
    capabilities: Mapping[str, str]
    #: Attributes ``min`` and ``max`` of the structural parameters, empty where they are missing.
    bounds: Mapping[str, tuple[str, str]]
    #: Values chosen for structural parameters (FMI 3.0).
    sizes: Mapping[str, int] = field(default_factory=dict)

    def resolve(self, name: str, kind: str = "variable", causality: str | None = None) -> list[Variable]:
        """Return the elements behind a scalar, indexed or structured name.

        Raises InputError: no such variable; the message holds the nearest one.
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

    def sized(self, sizes: Mapping[str, int]) -> Self:
        """Return the description with other values of structural parameters.

        Raises InputError: no such structural parameter, or a value outside its limits.
        """
        known = self.structure
        for name, value in sizes.items():
            if name not in known:
                raise unknown_name("structural parameter", name, known, str(self.path))
            least, high = self.limits(name)
            low, high = max(1, least), 2**63 - 1 if high is None else high
            if not low <= value <= high:
                raise InputError(
                    f"{self.path}: structural parameter {name!r} = {value}, allowed: {low} to {high}"
                )
        merged = {**self.sizes, **sizes}
        variables, arrays = expand(self.path, self.raw, merged)
        return replace(self, variables=variables, arrays=arrays, sizes=merged)

    @property
    def structure(self) -> list[str]:
        """Names of the structural parameters (FMI 3.0)."""
        return [name for name, v in self.variables.items() if v.causality == "structuralParameter"]

    def limits(self, name: str) -> tuple[int, int | None]:
        """Return the smallest and the largest value of a structural parameter, None without a limit."""
        # Not through floating point, as they may have 64 bits.
        low, high = (
            int(t) if re.fullmatch(r"-?\d{1,20}", t) else None for t in self.bounds.get(name, ("", ""))
        )
        return low or 0, high

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

    def claims(self, capability: str) -> bool:
        """Whether the co-simulation interface claims a capability, by the name of either version."""
        wanted = capability.lower().removesuffix("s")
        return any(
            name.lower().removesuffix("s") == wanted and value in {"true", "1"}
            for name, value in self.capabilities.items()
        )

    @property
    def state_can_be_saved(self) -> bool:
        """Whether the FMU can be rolled back (needed by the iterated mode)."""
        return self.claims("canGetAndSetFMUstate")

    @property
    def is_friction(self) -> bool:
        """Whether there are inputs and an output with the names of the loads and of mu."""
        found = {name: self.arrays[name][0].causality for name in self.arrays}
        return all(found.get(q.name) == wanted for q, wanted in _FRICTION)

    @property
    def is_scalar_friction(self) -> bool:
        """Whether this is a friction FMU of one contact point: five scalar loads in, mu out."""
        return self.is_friction and all(q.name in self.variables for q, _ in _FRICTION)

    def contact_points(self) -> int:
        """Return for how many points a friction FMU is, whose variables are checked.

        Raises InputError: a variable is missing, is not an input or output, has another type, unit or number of points.
        """
        count = len(self.arrays.get("v_rel", ()))
        for quantity, wanted in _FRICTION:
            if quantity.name not in self.arrays:
                raise unknown_name("variable", quantity.name, self.arrays, str(self.path))
            elements = self.arrays[quantity.name]
            first = elements[0]
            where = f"{self.path}: variable {first.own!r}"
            if first.causality != wanted:
                raise InputError(f"{where} is a {first.causality}, allowed: {wanted}")
            self.check_float64(elements)
            if first.unit not in {quantity.unit, "", "-" if quantity.unit == "1" else ""}:
                raise InputError(f"{where} has unit {first.unit!r}, allowed: {quantity.unit!r}")
            if len(elements) != count:
                raise InputError(
                    f"{self.path}: {len(elements)} points of {quantity.name!r} and {count} of 'v_rel', allowed: equally many"
                )
        return count

    def check_float64(self, elements: Iterable[Variable]) -> None:
        """Refuse variables of another type."""
        wrong = next((v for v in elements if not v.is_float64), None)
        if wrong is not None:
            allowed = "Real" if self.version == "2.0" else "Float64"
            shown = wrong.exchange[4:] or wrong.type
            raise InputError(f"{self.path}: variable {wrong.own!r} is of type {shown}, allowed: {allowed}")

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
        return path_digest(self.path)


@dataclass(frozen=True)
class UnpackedFmu(FmuDescription):
    """A described FMU whose files are in a folder.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     fmu = UnpackedFmu.of(pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python", nodes=2))
    ...     fmu.contact_points(), fmu.variables["sigma_n[1]"].unit, [v.name for v in fmu.resolve("mu")]
    (2, 'MPa', ['mu[1]', 'mu[2]'])
    """

    folder: Path = Path()  #: A temporary one, from `of`, lives as long as this object.
    _temporary: TemporaryDirectory[str] | None = field(default=None, repr=False, compare=False)

    @classmethod
    def of(cls, path: str | os.PathLike[str], folder: Path | None = None) -> UnpackedFmu:
        """Unpack an FMU of any interface, or take the `folder` where somebody else has unpacked it.

        Raises InputError: what `describe` refuses, but for an FMU without co-simulation.
        """
        found = _described(Path(path))
        if folder is not None:
            return cls(**vars(found), folder=folder)
        temporary = TemporaryDirectory(prefix="tribofmu-", ignore_cleanup_errors=True)
        unpack_members(path, temporary.name)
        return cls(**vars(found), folder=Path(temporary.name), _temporary=temporary)

    @property
    def library(self) -> Path:
        """The library for this machine; it may not exist."""
        return library_in(self.folder, self.raw)


def read_model(path: Path) -> tuple[etree._Element, Any]:
    """Read modelDescription.xml of an FMU that nobody has looked at yet; return its root and fmpy's model description.

    Raises InputError: no such file, not an archive, a hostile or damaged archive, neither FMI 2.0 nor 3.0, neither
    co-simulation nor model exchange, a description that fmpy cannot use.
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

    Raises InputError: what `read_model` refuses; no co-simulation; a variable whose type, shape or start value cannot be used.
    """
    found = _described(Path(path))
    if found.raw.coSimulation is None:
        raise InputError(
            f"{path}: the FMU offers no co-simulation, allowed: FMI {found.raw.fmiVersion} for co-simulation"
        )
    return found


def _described(file: Path) -> FmuDescription:
    root, raw = read_model(file)
    interface = root.find("CoSimulation")
    capabilities = {} if interface is None else {str(k): str(v) for k, v in interface.attrib.items()}
    bounds = {
        str(v.get("name")): (str(v.get("min", "")), str(v.get("max", "")))
        for v in root.iterfind("ModelVariables/*[@causality='structuralParameter']")
    }
    try:
        return FmuDescription(file, raw, *expand(file, raw, {}), capabilities, bounds)
    except InputError:
        raise
    except Exception as error:  # sizes and start values that are no numbers
        raise _not_valid(file, raw.fmiVersion, error) from None


def unpack(description: FmuDescription, folder: Path) -> UnpackedFmu:
    """Unpack a described FMU into `folder`; nothing is written outside it.

    Raises InputError: a damaged or hostile archive, or no binary for this platform.
    """
    from fmpy import platform, platform_tuple

    unpack_members(description.path, folder)
    fmu = UnpackedFmu(**vars(description), folder=folder)
    if not fmu.library.is_file():
        wanted = platform if description.version == "2.0" else platform_tuple
        present = sorted(p.name for p in (folder / "binaries").glob("*") if p.is_dir())
        raise InputError(
            f"{fmu.path}: no binary for the platform {wanted!r}; present: {', '.join(present) or 'none'}"
        )
    return fmu


def _not_valid(path: Path, version: str, error: Exception) -> InputError:
    lines = str(error).strip().splitlines()
    return InputError(
        f"{path}: modelDescription.xml is not valid FMI {version} ({lines[0][:200] if lines else type(error).__name__})"
    )
